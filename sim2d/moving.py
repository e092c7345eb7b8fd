"""A recording as a moving picture: one SVG that loops by itself, in a page, a README or a browser, without a script.

Seen from the right side; the picture follows the robot. Every body is a line of points, drawn again at each frame.
"""

import html
from collections.abc import Sequence

import numpy as np

from .recording import Array, Recording
from .terrain import Point
from .view import shown_rows, solid, turned

PIXELS_PER_M = 900
WIDTH_M, BELOW_M, ABOVE_M = 0.9, 0.05, 0.06  # of the picture; what it shows under the lowest foot, over the torso
TORSO, NEAR_LEG, FAR_LEG, STONE = "#2f4a6d", "#d2691e", "#c8b7a6", "#b5a184"  # the left legs are behind
_STYLE = "fill:none;stroke-linecap:round;stroke-linejoin:round"


def moving_svg(recording: Recording, title: str, torso_half_m: tuple[float, float]) -> str:
    """Return the picture. ``torso_half_m``: half the torso's length and height; ``title``: read out and shown on it."""
    rows = shown_rows(recording)
    seconds = float(recording.time_s[rows[-1]] - recording.time_s[rows[0]])
    x, floor = recording.torso_x_m[rows], float(recording.foot_xz_m[rows, :, 1].min()) - recording.foot_radius_m
    bottom, top = floor - BELOW_M, float(recording.torso_z_m.max()) + torso_half_m[1] + ABOVE_M
    width, height = round(WIDTH_M * PIXELS_PER_M), round((top - bottom) * PIXELS_PER_M)
    shown = [_limb(recording, rows, leg, FAR_LEG, bottom, height, seconds) for leg in (1, 3)]
    shown.append(_torso(recording, rows, torso_half_m, bottom, height, seconds))
    shown += [_limb(recording, rows, leg, NEAR_LEG, bottom, height, seconds) for leg in (0, 2)]
    ground = [_ground(line, bottom, height) for line in recording.terrain.polylines]
    ground += [_stone(recording, rows, stone, bottom, height, seconds) for stone in range(len(recording.terrain.loose))]
    away = ";".join(f"{WIDTH_M / 2 * PIXELS_PER_M - at * PIXELS_PER_M:.1f} 0" for at in x)
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img">',
        f"<title>{html.escape(title)}</title>",
        f'<rect width="{width}" height="{height}" fill="#f7f4ef"/>',
        "<g>",
        f'<animateTransform attributeName="transform" type="translate" {_timing(seconds)} values="{away}"/>',
        *ground, *shown, "</g>",
        f'<text x="14" y="26" font-family="sans-serif" font-size="17" fill="#2f4a6d">{html.escape(title)}</text>',
        "</svg>",
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _timing(seconds: float) -> str:
    return f'dur="{max(seconds, 0.01):.2f}s" repeatCount="indefinite"'  # nothing lasts no time at all


def _points(xz_m: Array, bottom: float, height: int) -> str:
    """Points of n x 2 metres as SVG has them."""
    return " ".join(f"{x * PIXELS_PER_M:.0f},{height - (z - bottom) * PIXELS_PER_M:.0f}" for x, z in xz_m)


def _moving(kind: str, frames: list[str], seconds: float, look: str) -> str:
    if len(set(frames)) == 1:
        return f'<{kind} points="{frames[0]}" {look}/>'
    values = ";".join(frames)
    return (f'<{kind} points="{frames[0]}" {look}><animate attributeName="points" {_timing(seconds)} '
            f'values="{values}"/></{kind}>')


def _limb(recording: Recording, rows: Array, leg: int, colour: str, bottom: float, height: int, seconds: float) -> str:
    parts = (recording.hip_xz_m, recording.knee_xz_m, recording.foot_xz_m)
    joints = np.stack([part[rows, leg] for part in parts], axis=1)
    frames = [_points(frame, bottom, height) for frame in joints]
    thick = 2 * recording.foot_radius_m * PIXELS_PER_M
    return _moving("polyline", frames, seconds, f'style="{_STYLE};stroke:{colour};stroke-width:{thick:.0f}"')


def _torso(recording: Recording, rows: Array, half_m: tuple[float, float], bottom: float, height: int,
           seconds: float) -> str:
    length, tall = half_m
    corners = [(-length, -tall), (length, -tall), (length, tall), (-length, tall)]
    places = np.stack([recording.torso_x_m, recording.torso_z_m], axis=1)[rows]
    frames = _turned(corners, places, -recording.torso_pitch_rad[rows], bottom, height)  # pitch > 0 is nose down
    return _moving("polygon", frames, seconds, f'fill="{TORSO}" stroke="{TORSO}" stroke-width="8" '
                                               'stroke-linejoin="round"')


def _stone(recording: Recording, rows: Array, stone: int, bottom: float, height: int, seconds: float) -> str:
    corners = recording.terrain.loose[stone].corners_m
    places, turns = recording.stone_xz_m[rows, stone], recording.stone_turn_rad[rows, stone]
    return _moving("polygon", _turned(corners, places, turns, bottom, height), seconds, f'fill="{STONE}"')


def _turned(corners: Sequence[Point], places: Array, turns_rad: Array, bottom: float, height: int) -> list[str]:
    """Points of a body whose corners lie round its place, turned counter-clockwise, for each frame."""
    moves = zip(places, turns_rad, strict=True)
    return [_points(turned(corners, place, turn), bottom, height) for place, turn in moves]


def _ground(line: list[Point], bottom: float, height: int) -> str:
    points = _points(np.array(solid(line)), bottom, height)
    return f'<polygon points="{points}" fill="#d9cfc0" stroke="#8d7c62" stroke-width="2"/>'
