"""Ground in three dimensions: sim2d's polylines extended sideways, and grounds that exist only in three dimensions."""

import itertools
import math
import random
from dataclasses import dataclass

from sim2d.terrain import Point, Terrain

Vector = tuple[float, float, float]

HALF_WIDTH_M = 3.0
# A slab reaches this far below the lowest ground, so that no foot can get under it.
_DEEP_M = 0.1
STONE_DENSITY_KG_M3 = 2500.0


@dataclass(frozen=True)
class Block:
    """A box of the ground: its half sizes, turned by pitch, then yaw; loose with a mass."""

    centre_m: Vector
    half_m: Vector
    pitch_rad: float = 0.0
    yaw_rad: float = 0.0
    mass_kg: float = 0.0

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """The turn as (w, x, y, z)."""
        cp, sp = math.cos(self.pitch_rad / 2), math.sin(self.pitch_rad / 2)
        cy, sy = math.cos(self.yaw_rad / 2), math.sin(self.yaw_rad / 2)
        return cy * cp, -sy * sp, cy * sp, sy * cp


@dataclass(frozen=True)
class Ground:
    """A level floor at ``floor_m`` and the blocks on it. The robot starts at x = 0, on height 0."""

    name: str
    floor_m: float = 0.0
    blocks: tuple[Block, ...] = ()


def extrude(terrain: Terrain, right_m: float = -HALF_WIDTH_M, yaw_rad: float = 0.0) -> Ground:
    """Return the polyline drawn out from y = ``right_m`` to the left, turned by ``yaw_rad`` about its first corner.

    ValueError for loose stones: a disc of the plane is no stone of the world (see ``stones``).
    """
    if terrain.loose:
        raise ValueError(f"terrain {terrain.name}: its loose stones are discs of the plane")
    floor_m = min(z for _, z in terrain.points_m)
    pivot_x_m = terrain.points_m[1][0]
    blocks = []
    for start, end in itertools.pairwise(terrain.points_m):
        if end[0] > start[0] and (start[1] > floor_m or end[1] > floor_m):
            block = _slab(start, end, floor_m, right_m)
            blocks.append(_turned(block, pivot_x_m, yaw_rad))
    return Ground(terrain.name, floor_m, tuple(blocks))


def _slab(start: Point, end: Point, floor_m: float, right_m: float) -> Block:
    """Return a box whose top is the line from ``start`` to ``end``; a level one stands on the floor's depth."""
    along_m, rise_m = end[0] - start[0], end[1] - start[1]
    length_m, pitch_rad = math.hypot(along_m, rise_m), -math.atan2(rise_m, along_m)
    # a slope's slab is thin, or its far lower corner would stick out of the next slope down
    half_depth_m = (end[1] - floor_m + _DEEP_M) / 2 if rise_m == 0 else min(_DEEP_M / 4, length_m / 8)
    middle = (start[0] + end[0]) / 2, (start[1] + end[1]) / 2
    centre = (
        middle[0] - math.sin(pitch_rad) * half_depth_m,
        (right_m + HALF_WIDTH_M) / 2,
        middle[1] - math.cos(pitch_rad) * half_depth_m,
    )
    return Block(centre, (length_m / 2, (HALF_WIDTH_M - right_m) / 2, half_depth_m), pitch_rad)


def _turned(block: Block, pivot_x_m: float, yaw_rad: float) -> Block:
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y, z = block.centre_m
    centre = (pivot_x_m + cos * (x - pivot_x_m) - sin * y, sin * (x - pivot_x_m) + cos * y, z)
    return Block(centre, block.half_m, block.pitch_rad, yaw_rad, block.mass_kg)


def stones(
    seed: int, height_m: float = 0.012, start_m: float = 0.25, length_m: float = 2.0, loose: bool = False
) -> Ground:
    """Return flat stones about 25 mm long on level ground, 15 a 0.1 m2, fixed or loose; different for every seed."""
    rng = random.Random(f"stones in space {seed}")
    half_width_m = 0.25
    count = round(150 * length_m * 2 * half_width_m * (0.4 if loose else 1.0))
    return Ground("stones", 0.0, tuple(_stone(rng, height_m, start_m, length_m, half_width_m, loose)
                                       for _ in range(count)))


def _stone(
    rng: random.Random, height_m: float, start_m: float, length_m: float, half_width_m: float, loose: bool
) -> Block:
    high_m = height_m * rng.uniform(0.4, 1.0)
    half = (rng.uniform(0.008, 0.02), rng.uniform(0.008, 0.02), high_m / 2)
    centre = (start_m + rng.uniform(0, length_m), rng.uniform(-half_width_m, half_width_m), high_m / 2)
    mass_kg = 8 * half[0] * half[1] * half[2] * STONE_DENSITY_KG_M3 if loose else 0.0
    return Block(centre, half, 0.0, rng.uniform(0, math.pi), mass_kg)
