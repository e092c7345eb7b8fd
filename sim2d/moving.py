"""A recording as a moving picture: one SVG that loops by itself in a page, a README or a browser, without a script.

Seen from the right, a little from behind and above, in parallel projection; the picture follows the robot. Every body
is a line of points, drawn again at each frame. A walk in the plane is drawn as deep as the robot is wide.
"""

import html
from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from .recording import Array, Aside, Recording, rotations
from .view import shown_rows, solid, turned

PIXELS_PER_M = 900
ACROSS, UP = -0.35, 0.35  # how far a point is drawn ahead and higher for each metre to the left
WIDTH_M, BELOW_M, ABOVE_M = 0.9, 0.03, 0.06  # of the picture; under the ground's near edge, over the torso
GROUND_M, LINES_M = 0.25, 0.1  # half the ground's width; lines on it, so that it is seen to go by
TOP, SIDE, BACK = "#4a6a93", "#2f4a6d", "#243a56"  # of the torso
NEAR_LEG, FAR_LEG = "#d2691e", "#b89b80"
TREAD, RISER, EDGE, LINE, STONE, STONE_SIDE = "#e6ddcf", "#c4b59c", "#d1c4ae", "#c9bca6", "#b5a184", "#9d8768"
FACES = ((BACK, ((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1))),  # ends of length, width, height: what is seen of it
         (SIDE, ((0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1))),
         (TOP, ((0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1))))  # fmt: skip
DIRECTIONS = np.array([(np.cos(angle), np.sin(angle)) for angle in np.arange(12) * np.pi / 6])


def moving_svg(recording: Recording, title: str, torso_half_m: tuple[float, float, float]) -> str:
    """Return the picture. ``torso_half_m``: half the torso's length, width, height; ``title``: read out and shown."""
    rows, aside = shown_rows(recording), recording.aside or _flat(recording, torso_half_m[1])
    seconds = float(recording.time_s[rows[-1]] - recording.time_s[rows[0]])
    floor = float(recording.foot_xz_m[rows, :, 1].min()) - recording.foot_radius_m - UP * GROUND_M - BELOW_M
    top = float(recording.torso_z_m.max()) + torso_half_m[2] + UP * torso_half_m[1] + ABOVE_M
    width, height = round(WIDTH_M * PIXELS_PER_M), round((top - floor) * PIXELS_PER_M)
    draw = _Draw(seconds, floor, height)
    legs = [_leg(draw, recording, rows, aside, leg) for leg in (1, 3, 0, 2)]  # the far ones first
    away = ";".join(f"{(WIDTH_M / 2 - at) * PIXELS_PER_M:.1f} 0" for at in recording.torso_x_m[rows])
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">',
        f"<title>{html.escape(title)}</title>",
        f'<rect width="{width}" height="{height}" fill="#f7f4ef"/>',
        "<g>",
        f'<animateTransform attributeName="transform" type="translate" {draw.timing} values="{away}"/>',
        '<g id="ground">', *_ground(draw, recording), '</g><g id="stones">', *_stones(draw, recording, rows), "</g>",
        *legs[:2], '<g id="torso" stroke-linejoin="round" stroke-width="4">',
        *_torso(draw, recording, rows, aside, torso_half_m), "</g>", *legs[2:], "</g>",
        f'<text x="14" y="26" font-family="sans-serif" font-size="17" fill="{SIDE}">{html.escape(title)}</text>',
        "</svg>",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def projected(points_m: Array) -> Array:
    """Return (..., 2) of (..., 3): how far ahead and how high a point is drawn, m."""
    return np.asarray(points_m[..., [0, 2]] + points_m[..., 1:2] * (ACROSS, UP))


def _flat(recording: Recording, half_width_m: float) -> Aside:
    """Return the third dimension of a walk in the plane: nothing moves sideways, the legs are beside the torso."""
    count, beside_m = len(recording.time_s), half_width_m + recording.foot_radius_m
    attitude_rad, legs_m = np.outer(recording.torso_pitch_rad, (0.0, 1.0, 0.0)), np.array([-1, 1, -1, 1]) * beside_m
    return Aside(np.zeros(count), attitude_rad, np.broadcast_to(legs_m[:, None], (count, 4, 3)))


class _Draw:
    """Writes shapes: metres of the picture's plane to pixels, and the points of each frame."""

    def __init__(self, seconds: float, floor_m: float, height: int) -> None:
        self.timing = f'dur="{max(seconds, 0.01):.2f}s" repeatCount="indefinite"'  # a duration must be above 0
        self._floor_m, self._height = floor_m, height

    def points(self, flat_m: Array) -> str:
        """Points of n x 2 metres as SVG has them."""
        pixels = ((x * PIXELS_PER_M, self._height - (z - self._floor_m) * PIXELS_PER_M) for x, z in flat_m)
        return " ".join(f"{x:.0f},{z:.0f}" for x, z in pixels)

    def still(self, points_m: Array, look: str, kind: str = "polygon") -> str:
        """A shape of n x 3 metres."""
        return f'<{kind} points="{self.points(projected(points_m))}" {look}/>'

    def moving(self, kind: str, flat_m: Array, look: str) -> str:
        """A shape of frames x n x 2 metres."""
        frames = [self.points(frame) for frame in flat_m]
        if len(set(frames)) == 1:
            return f'<{kind} points="{frames[0]}" {look}/>'
        return (f'<{kind} points="{frames[0]}" {look}><animate attributeName="points" {self.timing} '
                f'values="{";".join(frames)}"/></{kind}>')


def _leg(draw: _Draw, recording: Recording, rows: Array, aside: Aside, leg: int) -> str:
    parts = np.stack([recording.hip_xz_m, recording.knee_xz_m, recording.foot_xz_m], axis=2)[rows, leg]
    points = np.stack([parts[..., 0], aside.leg_y_m[rows, leg], parts[..., 1]], axis=-1)
    thick, colour = 2 * recording.foot_radius_m * PIXELS_PER_M, FAR_LEG if leg in (1, 3) else NEAR_LEG
    return draw.moving("polyline", projected(points), f'style="fill:none;stroke-linecap:round;stroke-linejoin:round;'
                       f'stroke:{colour};stroke-width:{thick:.0f}"')  # fmt: skip


def _torso(draw: _Draw, recording: Recording, rows: Array, aside: Aside,
           half_m: tuple[float, float, float]) -> Iterator[str]:
    place = np.stack([recording.torso_x_m, aside.torso_y_m, recording.torso_z_m], axis=1)[rows, None]
    turn = rotations(aside.attitude_rad[rows])
    for colour, ends in FACES:
        corners = (np.array(ends) * 2.0 - 1.0) * half_m
        points = place + corners @ turn.transpose(0, 2, 1)
        yield draw.moving("polygon", projected(points), f'fill="{colour}" stroke="{colour}"')


def _stones(draw: _Draw, recording: Recording, rows: Array) -> Iterator[str]:
    """Stones of the plane, as long as the ground is wide: their outline, and their near end."""
    for stone, loose in enumerate(recording.terrain.loose):
        moves = zip(recording.stone_xz_m[rows, stone], recording.stone_turn_rad[rows, stone], strict=True)
        ends = np.stack([turned(loose.corners_m, place, turn) for place, turn in moves])
        depth = GROUND_M * np.array([ACROSS, UP])
        near, both = ends - depth, np.concatenate([ends - depth, ends + depth], axis=1)
        outline = np.take_along_axis(both, (both @ DIRECTIONS.T).argmax(axis=1)[..., None], axis=1)
        yield draw.moving("polygon", outline, f'fill="{STONE}"')
        yield draw.moving("polygon", near, f'fill="{STONE_SIDE}"')


def _ground(draw: _Draw, recording: Recording) -> Iterator[str]:
    """Treads and risers from far to near, lines on what is level, and the near side."""
    ahead, behind = recording.torso_x_m.max() + WIDTH_M, recording.torso_x_m.min() - WIDTH_M
    line = recording.terrain.points_m
    for (x0, z0), (x1, z1) in reversed(list(pairwise(line))):
        if x1 == x0 and z1 < z0:
            continue  # faces away
        look = f'fill="{RISER if x1 == x0 else TREAD}" stroke="{LINE}"'
        yield draw.still(_strip((x0, z0), (x1, z1)), look)
        first, last = max(x0, behind), min(x1, ahead)
        for x in np.arange(np.ceil(first / LINES_M), np.floor(last / LINES_M) + 1) * LINES_M:
            z = np.interp(x, (x0, x1), (z0, z1))
            yield draw.still(_strip((x, z), (x, z))[1:3], f'stroke="{LINE}" fill="none"', "polyline")
    side = np.array([(x, -GROUND_M, z) for x, z in solid(line)])
    yield draw.still(side, f'fill="{EDGE}" stroke="{RISER}" stroke-width="2"')


def _strip(start: tuple[float, float], end: tuple[float, float]) -> Array:
    """Corners of the ground between two of its points, x and z, as wide as it is drawn."""
    (x0, z0), (x1, z1) = start, end
    return np.array([(x0, -GROUND_M, z0), (x1, -GROUND_M, z1), (x1, GROUND_M, z1), (x0, GROUND_M, z0)])
