"""What a recording looks like: one self-contained HTML animation, and one picture of the path.

The page holds its data, style and script, so it plays without a network and can be mailed.
"""

import html
import json
import math
from collections.abc import Sequence
from pathlib import Path
from string import Template
from typing import Any

import numpy as np

from .model import LEGS
from .recording import Array, Recording
from .terrain import Point

PAGE = Path(__file__).parent / "pages" / "walk.html"
FRAMES_PER_S = 25
STONE_STEP_M, STONE_STEP_RAD = 2e-4, 0.02  # a stone that moved less since it was last drawn stays where it is
MARGIN_M = 0.03
LEG_COLOURS = ("#d2691e", "#e9b88f", "#7a3e10", "#c99a72")


def animation_html(recording: Recording, title: str, sentence: str, facts: list[tuple[str, str]],
                   torso_half_m: tuple[float, float]) -> str:
    """Return the page. ``facts`` are rows of its table; ``torso_half_m`` is half the torso's length and height."""
    rows, ground = shown_rows(recording), _ground_below(recording)
    data = {
        "time_s": _rounded(recording.time_s[rows], 3),
        "torso": _rounded(
            np.stack([recording.torso_x_m, recording.torso_z_m, recording.torso_pitch_rad], axis=1)[rows], 4
        ),
        "pitch_deg": _rounded(np.degrees(recording.torso_pitch_rad[rows]), 2),
        "hip": _rounded(recording.hip_xz_m[rows], 4),
        "knee": _rounded(recording.knee_xz_m[rows], 4),
        "foot": _rounded(recording.foot_xz_m[rows], 4),
        "contact": recording.contact[rows].astype(int).tolist(),
        "torque_Nm": _rounded(recording.torque_Nm[rows], 2),
        "stall_Nm": _rounded(recording.stall_Nm, 3),
        "ground_z": _rounded(ground[rows], 4),
        "view_m": _rounded(_view_m(recording, ground, torso_half_m)[rows].max(axis=0), 3),
        "terrain": [[[round(x, 4), round(z, 4)] for x, z in solid(recording.terrain.points_m)]],
        "stones": [[[round(x, 4), round(z, 4)] for x, z in stone.corners_m] for stone in recording.terrain.loose],
        "stone_moves": _stone_moves(recording, rows),
        "foot_radius_m": recording.foot_radius_m,
        "torso_half_m": list(torso_half_m),
        "facts": [list(row) for row in facts],
    }
    # "</" would end the script element early
    text = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("</", "<\\/")
    page = Template(PAGE.read_text(encoding="utf-8"))
    return page.substitute(title=html.escape(title), sentence=html.escape(sentence), data=text)


def shown_rows(recording: Recording) -> Array:
    """Indexes of the ticks shown, about FRAMES_PER_S of them a second, the last one included."""
    ticks = len(recording.time_s)
    seconds = float(recording.time_s[-1] - recording.time_s[0]) if ticks > 1 else 0.0
    step = max(1, round(ticks / max(1.0, seconds * FRAMES_PER_S)))
    return np.unique(np.append(np.arange(0, ticks, step), ticks - 1))


def _ground_below(recording: Recording) -> Array:
    """Height of the ground under the torso, smoothed over half a second so that the view does not jump."""
    heights = np.array([recording.terrain.height_m(float(x)) for x in recording.torso_x_m])
    width = min(len(heights), 51)
    padded = np.pad(heights, (width // 2, width - 1 - width // 2), mode="edge")
    return np.asarray(np.convolve(padded, np.ones(width) / width, mode="valid"))


def _view_m(rec: Recording, ground_z: Array, torso_half_m: tuple[float, float]) -> Array:
    """How far the robot goes from its torso to either side, above the ground below, and under that; rows of three."""
    length, height = torso_half_m
    cos, sin = np.cos(rec.torso_pitch_rad), np.sin(rec.torso_pitch_rad)
    corners = [(x * cos + z * sin, z * cos - x * sin) for x in (-length, length) for z in (-height, height)]
    xs = [rec.torso_x_m + x for x, _ in corners]
    zs = [rec.torso_z_m + z for _, z in corners]
    for points in (rec.hip_xz_m, rec.knee_xz_m, rec.foot_xz_m):
        xs += list(points[:, :, 0].T)
        zs += list(points[:, :, 1].T)
    aside = np.abs(np.array(xs) - rec.torso_x_m).max(axis=0)
    above, under = np.max(zs, axis=0) - ground_z, ground_z - np.min(zs, axis=0)
    return np.stack([aside, above, under], axis=1) + rec.foot_radius_m + MARGIN_M


def _stone_moves(rec: Recording, rows: Array) -> list[list[list[float]]]:
    """For each loose stone where it is drawn, from which frame on: [frame, x, z, turn]."""
    moves = []
    for stone in range(len(rec.terrain.loose)):
        places, turns = rec.stone_xz_m[rows, stone], rec.stone_turn_rad[rows, stone]
        own: list[list[float]] = []
        for frame, ((x, z), turn) in enumerate(zip(places.tolist(), turns.tolist(), strict=True)):
            if not own or math.dist(own[-1][1:3], (x, z)) > STONE_STEP_M or abs(turn - own[-1][3]) > STONE_STEP_RAD:
                own.append([frame, round(x, 4), round(z, 4), round(turn, 2)])
        moves.append(own)
    return moves


def turned(corners_m: Sequence[Point], place_m: Array, turn_rad: float) -> Array:
    """Return where the corners of a body are that lie round its place, turned counter-clockwise; n x 2."""
    cos, sin = math.cos(turn_rad), math.sin(turn_rad)
    return np.asarray(np.array(corners_m) @ np.array([[cos, sin], [-sin, cos]]) + place_m)


def solid(line: Sequence[Point]) -> list[Point]:
    """A ground line closed far below, so that it can be filled."""
    deep = min(z for _, z in line) - 0.5
    return [*line, (line[-1][0], deep), (line[0][0], deep)]


def _rounded(values: Array, digits: int) -> Any:
    return np.round(values, digits).tolist()


def path_png(recording: Recording, title: str, target: Path) -> None:
    """Draw the walk's path into a PNG file: ground, torso and feet from the side, and the pitch below."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11, 4.6), layout="constrained")
    FigureCanvasAgg(figure)
    side, pitch = figure.subplots(2, 1, height_ratios=(2, 1))
    _draw_side(side, recording)
    side.set_title(title)
    pitch.plot(recording.torso_x_m, np.degrees(recording.torso_pitch_rad), color="#2f4a6d", linewidth=0.9)
    pitch.set_xlabel("way of the torso, m")
    pitch.set_ylabel("pitch, deg")
    pitch.grid(alpha=0.3)
    pitch.set_xlim(side.get_xlim())
    figure.savefig(target, dpi=110)


def _draw_side(axes: Any, rec: Recording) -> None:
    body = np.concatenate([rec.hip_xz_m, rec.knee_xz_m, rec.foot_xz_m], axis=1)
    left, right = float(body[:, :, 0].min()) - 0.05, float(body[:, :, 0].max()) + 0.05
    xs, zs = zip(*solid(rec.terrain.points_m), strict=True)
    axes.fill(xs, zs, color="#d9cfc0", edgecolor="#8d7c62", linewidth=1.2)
    _draw_stones(axes, rec)
    for leg in range(4):
        foot = rec.foot_xz_m[:, leg]
        axes.plot(foot[:, 0], foot[:, 1] - rec.foot_radius_m, color=LEG_COLOURS[leg], linewidth=0.8,
                  label=f"{LEGS[leg]} sole")
    axes.plot(rec.torso_x_m, rec.torso_z_m, color="#2f4a6d", linewidth=1.4, label="torso")
    for row in _poses(rec):
        for leg in (0, 2):
            limb = np.stack([rec.hip_xz_m[row, leg], rec.knee_xz_m[row, leg], rec.foot_xz_m[row, leg]])
            axes.plot(limb[:, 0], limb[:, 1], color="#9aa5b5", linewidth=1.0, zorder=0)
        hips = rec.hip_xz_m[row, [2, 0]]
        axes.plot(hips[:, 0], hips[:, 1], color="#9aa5b5", linewidth=2.5, zorder=0)
    axes.set_xlim(left, right)
    top = max(float(rec.torso_z_m.max()), float(body[:, :, 1].max())) + 0.06
    axes.set_ylim(float(body[:, :, 1].min()) - 0.04, top)
    axes.set_aspect("equal", adjustable="box")
    axes.set_ylabel("height, m")
    axes.legend(loc="upper center", ncols=5, fontsize=8, frameon=False, bbox_to_anchor=(0.5, -0.08))
    axes.grid(alpha=0.25)


def _draw_stones(axes: Any, rec: Recording) -> None:
    """Loose stones: outlines where they lay at first, filled where they lie at the end."""
    for row, style in ((0, {"facecolor": "none", "alpha": 0.5}), (-1, {"facecolor": "#b5a184"})):
        for stone, (place, turn) in enumerate(zip(rec.stone_xz_m[row], rec.stone_turn_rad[row], strict=True)):
            corners = turned(rec.terrain.loose[stone].corners_m, place, turn)
            axes.fill(corners[:, 0], corners[:, 1], edgecolor="#8d7c62", linewidth=0.6, **style)


def _poses(recording: Recording) -> list[int]:
    """Rows at which the robot is drawn: about one for each 0.25 m, and the last."""
    gone = recording.torso_x_m - recording.torso_x_m[0]
    count = max(1, math.floor(float(gone[-1]) / 0.25))
    return [*(int(np.argmax(gone >= i * 0.25)) for i in range(count + 1) if (gone >= i * 0.25).any()), len(gone) - 1]
