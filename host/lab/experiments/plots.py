"""The experiments' pictures, drawn into PNG files."""

from pathlib import Path
from typing import Any

import numpy as np

from sim2d.recording import Recording

from ...util.pictures import make_figure
from .foot_in_air import Swing
from .trials import PLANE, SPACE, Answer

_COLOURS = ("#2f4a6d", "#d2691e", "#4c8c4a", "#a33b5e", "#7a6a3a", "#4b9bb5", "#8a5fb0", "#555555")


def swings(cases: list[tuple[str, Swing]], target: Path) -> None:
    """Draw x, y and height over time, wanted and done, a column for each case."""
    figure = make_figure(5.5 * len(cases), 6)
    grid = figure.subplots(3, len(cases), squeeze=False, sharex=True)
    for column, (name, swing) in enumerate(cases):
        wanted, done = np.array(swing.wanted), np.array(swing.done)
        for row, what in enumerate(("x", "y", "height")):
            axes = grid[row][column]
            axes.plot(wanted[:, 0], 1000 * wanted[:, row + 1], ".", color=_COLOURS[1], markersize=4, label="wanted")
            axes.plot(done[:, 0], 1000 * done[:, row + 1], color=_COLOURS[0], linewidth=1.2, label="done")
            axes.set_ylabel(f"{what}, mm")
            if np.ptp(wanted[:, row + 1]) == 0:  # the plane has no sideways
                axes.set_ylim(-1, 1)
            axes.grid(alpha=0.3)
        grid[0][column].set_title(f"Foot in the air {name}")
        grid[0][column].legend(loc="lower right")
        grid[2][column].set_xlabel("time, s")
        grid[2][column].set_xlim(0, 0.9)
    figure.savefig(target, dpi=100)


def attitudes(cases: list[tuple[str, Answer]], target: Path) -> None:
    """Draw pitch, and roll where there is one, over time: one strip for each case."""
    figure = make_figure(10, 0.6 + 1.7 * len(cases))
    grid = figure.subplots(len(cases), 1, squeeze=False)
    for axes, (name, answer) in zip(grid[:, 0], cases, strict=True):
        for what, degrees, colour in _angles(answer.recording):
            axes.plot(answer.recording.time_s, degrees, color=colour, linewidth=0.9, label=what)
        axes.set_ylabel("deg")
        axes.set_title(f"{name}: {answer.figures['reason']}", fontsize=9, loc="left")
        axes.grid(alpha=0.3)
    grid[0, 0].legend(loc="upper right", ncols=2, fontsize=8)
    grid[-1, 0].set_xlabel("time, s")
    figure.savefig(target, dpi=100)


def _angles(recording: Recording) -> list[tuple[str, Any, str]]:
    if recording.aside is None:
        return [("pitch (plane)", np.degrees(recording.torso_pitch_rad), _COLOURS[0])]
    angles = np.degrees(recording.aside.attitude_rad)
    return [("roll (3-D)", angles[:, 0], _COLOURS[1]), ("pitch (3-D)", angles[:, 1], _COLOURS[0])]


Lines = dict[str, list[tuple[float, float]]]  # points by name


def lines(panels: dict[str, Lines], x_label: str, y_label: str, limit: float | None, target: Path) -> None:
    """Draw a panel for each simulator, a line for each kind, and a limit, if there is one, across."""
    figure = make_figure(5.5 * len(panels), 4)
    grid = figure.subplots(1, len(panels), squeeze=False, sharey=True)
    for axes, (place, named) in zip(grid[0], panels.items(), strict=True):
        for i, (name, points) in enumerate(named.items()):
            # lines that lie on each other stay visible: thick below thin
            axes.plot(*zip(*points, strict=True), marker="o", markersize=9 - 1.2 * i, linewidth=5 - 0.75 * i,
                      color=_COLOURS[i], label=name)
        if limit is not None:
            axes.axhline(limit, color="#a33b5e", linestyle="--", linewidth=1)
        axes.set_xlabel(x_label)
        axes.set_title({PLANE: "in the plane (sim2d)", SPACE: "in 3-D (MuJoCo)"}[place])
        axes.grid(alpha=0.3)
        axes.legend()
    grid[0][0].set_ylabel(y_label)
    grid[0][0].set_ylim(bottom=-5)
    figure.savefig(target, dpi=100)
