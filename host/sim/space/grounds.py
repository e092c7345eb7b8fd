"""Grounds by name for the 3-D check: those of `caramelo walk`, a step met askew, and one under the left legs only."""

import math
from dataclasses import dataclass

from sim2d import terrain

from ...util.errors import UserError
from ..export.ground import Ground, extrude, stones

ASKEW_RAD = math.radians(20.0)
# As `caramelo walk` has them (host/sim/walk.py).
_HEIGHT_M = {"stones": 0.012, "gravel": 0.012}
_STEP_M = 0.02


@dataclass(frozen=True)
class GroundSpec:
    """A ground by name. ``height_m`` None: 12 mm for stones, 20 mm for steps; ``start_m``: where it begins."""

    name: str
    height_m: float | None = None
    angle_deg: float = 5.34
    start_m: float = 0.35
    length_m: float | None = None
    seed: int = 0


NAMES = ("flat", "stones", "gravel", "ramp", "step", "step-up", "step-down", "box", "angled", "left")


def make_ground(spec: GroundSpec) -> Ground:
    """Return the ground, or raise UserError naming what is wrong with it."""
    if spec.name not in NAMES:
        raise UserError(f"--terrain {spec.name}: no such ground; there are {', '.join(NAMES)}")
    try:
        return _make(spec)
    except ValueError as error:
        raise UserError(f"--terrain {spec.name}: {error}") from error


def _make(spec: GroundSpec) -> Ground:
    height_m = _HEIGHT_M.get(spec.name, _STEP_M) if spec.height_m is None else spec.height_m
    if spec.name in ("stones", "gravel"):
        return stones(spec.seed, height_m, spec.start_m, spec.length_m or 2.0, loose=spec.name == "gravel")
    if spec.name == "flat":
        return extrude(terrain.flat())
    if spec.name == "ramp":
        return extrude(terrain.ramp(spec.angle_deg, spec.start_m))
    if spec.name == "box":
        return extrude(terrain.box(height_m, spec.start_m, spec.length_m or 0.06))
    if spec.name in ("step-up", "step-down"):
        return extrude(terrain.step(height_m if spec.name == "step-up" else -height_m, spec.start_m, None))
    step = terrain.step(height_m, spec.start_m, spec.length_m or 0.45)
    if spec.name == "left":
        return extrude(step, right_m=0.0)
    return extrude(step, yaw_rad=ASKEW_RAD if spec.name == "angled" else 0.0)
