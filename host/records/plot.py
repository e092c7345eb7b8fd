"""A picture of a record: states, joint angles wanted and measured, loads, attitude, stability, heat, timing."""

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..robot.model import JOINT_NAMES, LEG_NAMES
from ..util.console import plain
from ..util.errors import UserError
from ..util.files import atomic_path
from ..util.pictures import make_figure
from .reader import Record

if TYPE_CHECKING:
    from numpy import ndarray

    Array = ndarray[Any, Any]

CLOSE = 0.03  # of the picture's width: closer names of states would overlap
LONGEST_NAME = 80  # characters of names that are written into one line
LARGEST = 1e12  # larger values, and values that are not numbers, leave a gap
STRETCHES = 1000  # of a curve; the axes are 950 dots wide
COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red")

# The fields to draw, for read_record.
FIELDS = {
    "/state": ("state",),
    "/joints": ("wanted_rad", "measured_rad"),
    "/load": ("load",),
    "/attitude": ("known", "roll_rad", "pitch_rad"),
    "/stability": ("margin_m",),
    "/health": ("temperature_C", "voltage_V"),
    "/timing": ("late_ms", "busy_ms"),
}


def plot_png(record: Record, path: Path) -> None:
    """Draw a record's ``FIELDS`` into a PNG file; UserError if it has none."""
    if not any(len(record.of(topic)) for topic in FIELDS):
        raise UserError(f"{record.path}: nothing to draw: it contains no message of {', '.join(FIELDS)}")
    figure = make_figure(12, 19)
    axes = figure.subplots(8, 1, sharex=True)
    title = f"{record.about.get('robot', 'robot')[:LONGEST_NAME]}: {record.duration_s:.1f} s, {record.path.name}"
    figure.suptitle(plain(title), parse_math=False)
    _draw_joints(record, axes[:3])
    _draw_load(record, axes[3])
    _draw_attitude(record, axes[4])
    _draw_stability(record, axes[5])
    _draw_health(record, axes[6])
    _draw_timing(record, axes[7])
    changes = _changes(record)
    _name_states(changes, record.duration_s, axes[0])
    for each in axes:
        each.vlines([at_s for _, at_s in changes], 0, 1, transform=each.get_xaxis_transform(), color="0.6", lw=0.6)
        each.grid(alpha=0.3)
        each.margins(x=0.01)
        if each.get_legend_handles_labels()[0]:
            each.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    with atomic_path(path) as draft, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of letters that the font lacks
        figure.savefig(draft, dpi=100, format="png")


def _curves(record: Record, topic: str, name: str) -> "tuple[Array, Array]":
    """Return times in s and a field's values, a row per message, at least one column; NaN if it can't be drawn."""
    import numpy as np

    column = record.of(topic).columns[name]
    values = np.asarray(column.all, dtype=float).reshape(-1, column.width or 1)
    return _thinned(np.array(record.times_s(topic)), np.where(np.abs(values) < LARGEST, values, np.nan))


def _thinned(times_s: "Array", values: "Array") -> "tuple[Array, Array]":
    """Return the lowest and the highest value of many short stretches, which look the same in the picture."""
    import numpy as np

    step = len(values) // STRETCHES
    if step <= 2:
        return times_s, values
    whole = len(values) // step * step
    stretches = values[:whole].reshape(-1, step, values.shape[1])
    both = np.stack([np.fmin.reduce(stretches, axis=1), np.fmax.reduce(stretches, axis=1)], axis=1)
    thin = both.reshape(-1, values.shape[1])
    times_s = np.concatenate([np.repeat(times_s[:whole:step], 2), times_s[whole:]])
    return times_s, np.concatenate([thin, values[whole:]])


def _draw_joints(record: Record, axes: Any) -> None:
    from numpy import degrees

    times_s, wanted_rad = _curves(record, "/joints", "wanted_rad")
    _, measured_rad = _curves(record, "/joints", "measured_rad")
    for joint, name in enumerate(JOINT_NAMES):
        for leg, colour in enumerate(COLOURS):
            at = 3 * leg + joint
            axes[joint].plot(times_s, degrees(wanted_rad[:, at]), color=colour, lw=0.7, ls="--")
            axes[joint].plot(times_s, degrees(measured_rad[:, at]), color=colour, lw=1, label=LEG_NAMES[leg])
        axes[joint].set_ylabel(f"{name}, deg\n(wanted dashed)")


def _draw_load(record: Record, axis: Any) -> None:
    times_s, load = _curves(record, "/load", "load")
    for joint, name in enumerate(JOINT_NAMES):
        axis.plot(times_s, abs(load[:, joint::3]).max(axis=1), lw=1, label=name)
    axis.set_ylabel("largest load\n1 = stall")


def _draw_attitude(record: Record, axis: Any) -> None:
    from numpy import degrees, nan, where

    for name in ("roll_rad", "pitch_rad"):
        times_s, angle_rad = _curves(record, "/attitude", name)
        _, known = _curves(record, "/attitude", "known")
        axis.plot(times_s, where(known > 0, degrees(angle_rad), nan), label=name[:-4])
    axis.set_ylabel("attitude, deg")


def _draw_stability(record: Record, axis: Any) -> None:
    times_s, margin_m = _curves(record, "/stability", "margin_m")
    axis.plot(times_s, 1000 * margin_m, lw=1, label="margin")
    axis.axhline(0.0, color="tab:red", lw=0.8)
    axis.set_ylabel("stability\nmargin, mm")


def _draw_health(record: Record, axis: Any) -> None:
    for name, label in (("temperature_C", "hottest joint, C"), ("voltage_V", "battery, V")):
        times_s, values = _curves(record, "/health", name)
        axis.plot(times_s, values.max(axis=1), label=label)
    axis.set_ylabel("health")


def _draw_timing(record: Record, axis: Any) -> None:
    for name in ("late_ms", "busy_ms"):
        axis.plot(*_curves(record, "/timing", name), lw=0.8, label=name)
    axis.set_ylabel("timing, ms")
    axis.set_xlabel("time, s")


def _changes(record: Record) -> list[tuple[str, float]]:
    """Return the states in order, and when each began, s."""
    changes: list[tuple[str, float]] = []
    for state, at_s in zip(record.of("/state").columns["state"].all, record.times_s("/state"), strict=True):
        if not changes or changes[-1][0] != state:
            changes.append((state, at_s))
    return changes


def _name_states(changes: list[tuple[str, float]], duration_s: float, axis: Any) -> None:
    """Write the states above an axis; states in quick succession share a line, which is cut if it is long."""
    lines: list[tuple[str, float]] = []
    for state, at_s in changes:
        if not lines or at_s - lines[-1][1] >= CLOSE * duration_s:
            lines.append((state, at_s))
        elif len(lines[-1][0]) < LONGEST_NAME:
            lines[-1] = (f"{lines[-1][0]}, {state}", lines[-1][1])
    for text, at_s in lines:
        shown = plain(text[:LONGEST_NAME])
        where = axis.get_xaxis_transform()
        axis.text(at_s, 1.02, shown, transform=where, fontsize=8, rotation=30, parse_math=False)
