"""The ground of a walk by name: a polyline in the plane, extended sideways in space; and grounds only in space."""

import math
from collections.abc import Callable
from dataclasses import dataclass

from sim2d import terrain
from sim2d.terrain import Terrain

from ..util.errors import UserError
from .export.ground import Ground, extrude, stones

ASKEW_RAD = math.radians(20.0)
STONES = ("stones", "gravel")  # lie in space as nowhere in the plane
ONLY_SPACE = ("angled", "left")  # a step met askew, and one under the left legs only
STAIR_M = 0.04
_HEIGHTS_M = {"stones": 0.012, "gravel": 0.012, "stairs-up": STAIR_M, "stairs-down": STAIR_M}
DEFAULT_HEIGHT_M = {**_HEIGHTS_M, **dict.fromkeys(("step", "step-up", "step-down", "box", *ONLY_SPACE), 0.02)}
NAMES = ("flat", "stones", "gravel", "ramp", "slope-up", "slope-down", "step", "step-up", "step-down", "box",
         "stairs-up", "stairs-down", *ONLY_SPACE)


@dataclass(frozen=True)
class GroundSpec:
    """A ground by name; UserError for an unknown name.

    ``height_m`` None: the ground's own; ``start_m``: where it begins; ``length_m``: of a step, a box, a tread, a
    slope, or of all stones, None: the ground's own; ``seed`` of the stones.
    """

    name: str = "flat"
    height_m: float | None = None
    angle_deg: float = 5.34
    start_m: float = 0.35
    length_m: float | None = None
    seed: int = 0

    def __post_init__(self) -> None:
        if self.name not in NAMES:
            raise UserError(f"--terrain {self.name}: allowed {', '.join(NAMES)}")
        if self.height_m is not None and self.name not in DEFAULT_HEIGHT_M:
            raise UserError(f"--height: {self.name} has no height; only with {', '.join(DEFAULT_HEIGHT_M)}")

    @property
    def height(self) -> float:
        """The obstacle's height, m; 0 where there is none."""
        return DEFAULT_HEIGHT_M.get(self.name, 0.0) if self.height_m is None else self.height_m


FLAT = GroundSpec()


def make_terrain(spec: GroundSpec) -> Terrain:
    """Return the ground in the plane, for grounds only in space the step that it contains; UserError if impossible."""
    height, start, length = spec.height, spec.start_m, spec.length_m
    makers: dict[str, Callable[[], Terrain]] = {
        "flat": terrain.flat,
        "stones": lambda: terrain.stones(spec.seed, height, start, length or 2.0),
        "gravel": lambda: terrain.gravel(spec.seed, height, start, length or 2.0),
        "ramp": lambda: terrain.ramp(spec.angle_deg, start, length or 0.8),
        "slope-up": lambda: terrain.slope(spec.angle_deg, start, length or 0.8),
        "slope-down": lambda: terrain.slope(-spec.angle_deg, start, length or 0.8),
        "step-up": lambda: terrain.step(height, start, None),
        "step-down": lambda: terrain.step(-height, start, None),
        "box": lambda: terrain.box(height, start, length or 0.06),
        "stairs-up": lambda: terrain.stairs(height, start, length or 0.25),
        "stairs-down": lambda: terrain.stairs(-height, start, length or 0.25),
    }
    try:
        return makers.get(spec.name, lambda: terrain.step(height, start, length or 0.6))()
    except ValueError as error:
        raise UserError(f"--terrain {spec.name}: {error}") from error


def make_ground(spec: GroundSpec) -> Ground:
    """Return the ground in space; UserError if it is impossible."""
    if spec.name in STONES:
        return stones(spec.seed, spec.height, spec.start_m, spec.length_m or 2.0, loose=spec.name == "gravel")
    drawn = make_terrain(spec)
    if spec.name == "left":
        return extrude(drawn, right_m=0.0)
    return extrude(drawn, yaw_rad=ASKEW_RAD if spec.name == "angled" else 0.0)
