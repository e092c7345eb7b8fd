"""The ground as a polyline in the plane, plus loose stones: what to collide with, draw and finish at.

Heights are relative to the ground at x = 0, where the robot starts. A vertical riser is two points of equal x.
The contact's friction coefficient is the foot's.
"""

import bisect
import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

Point = tuple[float, float]

BEHIND_M = 5.0
AHEAD_M = 120.0
# Past the last edge by more than half a robot: then the hind feet have met it too.
RUN_OUT_M = 0.45
STAIRS = 8
PLATEAU_M = 0.5


@dataclass(frozen=True)
class Stone:
    """A loose stone: a convex polygon (x, z around its own centre) and where its centre starts."""

    x_m: float
    z_m: float
    corners_m: tuple[Point, ...]
    density_kg_m2: float


@dataclass(frozen=True)
class Terrain:
    """Fixed ground and loose stones. ``finish_x_m``: where the robot has passed it all, None if nowhere."""

    name: str
    points_m: tuple[Point, ...]
    loose: tuple[Stone, ...] = ()
    finish_x_m: float | None = None

    def __post_init__(self) -> None:
        if any(b[0] < a[0] for a, b in zip(self.points_m, self.points_m[1:], strict=False)):
            raise ValueError(f"terrain {self.name}: its points must go forward, never back")

    @cached_property
    def _x_m(self) -> list[float]:
        return [x for x, _ in self.points_m]

    def height_m(self, x_m: float) -> float:
        """Ground height at ``x_m``; at a riser its upper edge; beyond the ends the end's height."""
        points = self.points_m
        right = bisect.bisect_right(self._x_m, x_m)
        left = bisect.bisect_left(self._x_m, x_m)
        if left != right:
            return max(z for _, z in points[left:right])
        if right == 0 or right == len(points):
            return points[min(right, len(points) - 1)][1]
        (x0, z0), (x1, z1) = points[right - 1], points[right]
        return z0 + (z1 - z0) * (x_m - x0) / (x1 - x0)

    def highest_m(self, from_x_m: float, to_x_m: float) -> float:
        """Highest ground between two x, either way round, both ends included."""
        low, high = min(from_x_m, to_x_m), max(from_x_m, to_x_m)
        inside = self.points_m[bisect.bisect_left(self._x_m, low) : bisect.bisect_right(self._x_m, high)]
        return max([self.height_m(low), self.height_m(high), *(z for _, z in inside)])


def flat() -> Terrain:
    """Level ground."""
    return Terrain("flat", _ground([(0.0, 0.0)]))


def ramp(angle_deg: float, start_m: float = 0.35, length_m: float = 0.8) -> Terrain:
    """Up a slope of ``length_m`` along the ground, over a plateau, and down again."""
    _check("angle_deg", angle_deg, 0.0, 40.0)
    _check_start(start_m)
    _check("length_m", length_m, 0.1, 4.0)
    run, rise = length_m * math.cos(math.radians(angle_deg)), length_m * math.sin(math.radians(angle_deg))
    top = start_m + run
    corners = [(start_m, 0.0), (top, rise), (top + PLATEAU_M, rise), (top + PLATEAU_M + run, 0.0)]
    return Terrain("ramp", _ground(corners), (), corners[-1][0] + RUN_OUT_M)


def slope(angle_deg: float, start_m: float = 0.35, length_m: float = 0.8) -> Terrain:
    """Up a slope of ``length_m`` along the ground onto a plateau; with an angle < 0 down from one."""
    _check("angle_deg", angle_deg, -40.0, 40.0)
    _check_start(start_m)
    _check("length_m", length_m, 0.1, 4.0)
    angle = math.radians(angle_deg)
    corners = [(start_m, 0.0), (start_m + length_m * math.cos(angle), length_m * math.sin(angle))]
    return Terrain("slope", _ground(corners), (), corners[-1][0] + RUN_OUT_M)


def stairs(height_m: float, start_m: float = 0.35, tread_m: float = 0.25) -> Terrain:
    """STAIRS steps of ``height_m`` up, ``tread_m`` from edge to edge; with height < 0 down."""
    _check("height_m", height_m, -0.3, 0.3)
    _check_start(start_m)
    _check("length_m", tread_m, 0.05, 2.0)
    edges = [start_m + i * tread_m for i in range(STAIRS)]
    corners = [(x, (i + up) * height_m) for i, x in enumerate(edges) for up in (0, 1)]
    return Terrain("stairs", _ground(corners), (), edges[-1] + RUN_OUT_M)


def step(height_m: float, start_m: float = 0.35, length_m: float | None = 0.6) -> Terrain:
    """A step up and, ``length_m`` later, down again; with length None only up; with height < 0 down first."""
    _check("height_m", height_m, -0.3, 0.3)
    _check_start(start_m)
    corners = [(start_m, 0.0), (start_m, height_m)]
    if length_m is not None:
        _check("length_m", length_m, 0.02, 4.0)
        corners += [(start_m + length_m, height_m), (start_m + length_m, 0.0)]
    return Terrain("step", _ground(corners), (), corners[-1][0] + RUN_OUT_M)


def box(height_m: float, start_m: float = 0.35, length_m: float = 0.05) -> Terrain:
    """A box to step over, shorter than a foot's stride."""
    _check("height_m", height_m, 0.0, 0.3)
    _check_start(start_m)
    _check("length_m", length_m, 0.01, 0.2)
    end = start_m + length_m
    corners = [(start_m, 0.0), (start_m, height_m), (end, height_m), (end, 0.0)]
    return Terrain("box", _ground(corners), (), end + RUN_OUT_M)


def stones(seed: int, height_m: float = 0.012, start_m: float = 0.25, length_m: float = 4.0) -> Terrain:
    """Fixed stones up to ``height_m`` high, 15 to 45 mm wide, 5 to 40 mm apart, different for every seed."""
    _check("height_m", height_m, 0.0, 0.05)
    _check_start(start_m)
    _check("length_m", length_m, 0.1, 10.0)
    rng = random.Random(f"stones {seed}")
    corners: list[Point] = []
    x = start_m
    while x < start_m + length_m:
        width, top = rng.uniform(0.015, 0.045), height_m * rng.uniform(0.4, 1.0)
        left, right = x + width * rng.uniform(0.15, 0.4), x + width * rng.uniform(0.6, 0.85)
        corners += [(x, 0.0), (left, top * rng.uniform(0.8, 1.0)), (right, top), (x + width, 0.0)]
        x += width + rng.uniform(0.005, 0.040)
    return Terrain("stones", _ground(corners), (), start_m + length_m + RUN_OUT_M)


def gravel(seed: int, height_m: float = 0.012, start_m: float = 0.25, length_m: float = 1.5) -> Terrain:
    """Loose stones of ``height_m`` and less, lying about 25 mm apart on level ground, free to move.

    A stone is a disc-like polygon of stone (2500 kg/m3) as deep as it is high, so a few grams.
    """
    _check("height_m", height_m, 0.004, 0.03)
    _check_start(start_m)
    _check("length_m", length_m, 0.1, 4.0)
    rng = random.Random(f"gravel {seed}")
    loose: list[Stone] = []
    x = start_m
    while x < start_m + length_m:
        radius = 0.5 * height_m * rng.uniform(0.6, 1.0)
        loose.append(Stone(x, radius, _pebble(rng, radius), 2500.0 * 2 * radius))
        x += 2 * radius + rng.uniform(0.004, 0.030)
    return Terrain("gravel", _ground([(0.0, 0.0)]), tuple(loose), start_m + length_m + RUN_OUT_M)


def _pebble(rng: random.Random, radius_m: float) -> tuple[Point, ...]:
    """Five to seven corners on a circle, unevenly spaced."""
    count = rng.randint(5, 7)
    angles = [(k + rng.uniform(-0.3, 0.3)) * math.tau / count for k in range(count)]
    return tuple((radius_m * math.cos(a), radius_m * math.sin(a)) for a in angles)


def _ground(corners: Sequence[Point]) -> tuple[Point, ...]:
    """Corners with level ground before and behind."""
    start, end = (-BEHIND_M, corners[0][1]), (corners[-1][0] + AHEAD_M, corners[-1][1])
    return (start, *corners, end)


def _check_start(start_m: float) -> None:
    _check("start_m", start_m, 0.15, 3.0)


def _check(name: str, value: float, low: float, high: float) -> None:
    """Raise one line that says what is allowed."""
    if not low <= value <= high:
        raise ValueError(f"terrain: {name} = {value}: allowed {low:g} .. {high:g}")
