"""A picture of a record: states, joint angles wanted and measured, loads, attitude, stability, heat, timing."""

from math import degrees, nan
from pathlib import Path
from typing import Any

from ..files import atomic_path
from ..robot_model import JOINT_NAMES, LEG_NAMES
from .reader import Record

CLOSE = 0.03  # of the picture's width: names of states would lie over each other
COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red")


def plot_png(record: Record, path: Path) -> None:
    """Draw a record into a PNG file."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(8, 1, figsize=(12, 19), sharex=True, layout="constrained")
    figure.suptitle(f"{record.about.get('robot', 'robot')}: {record.duration_s:.1f} s, {record.path.name}")
    _draw_joints(record, axes[:3])
    _draw_load(record, axes[3])
    _draw_attitude(record, axes[4])
    _draw_stability(record, axes[5])
    _draw_health(record, axes[6])
    _draw_timing(record, axes[7])
    _name_states(record, axes[0])
    for each in axes:
        for _, at_s in _changes(record):
            each.axvline(at_s, color="0.6", lw=0.6)
        each.grid(alpha=0.3)
        each.margins(x=0.01)
        if each.get_legend_handles_labels()[0]:
            each.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    with atomic_path(path) as draft:
        figure.savefig(draft, dpi=100)
    pyplot.close(figure)


def _times(record: Record, topic: str) -> list[float]:
    return [(row.time_ns - record.start_ns) / 1e9 for row in record.of(topic)]


def _series(record: Record, topic: str, name: str) -> list[Any]:
    return [row.values[name] for row in record.of(topic)]


def _draw_joints(record: Record, axes: Any) -> None:
    times = _times(record, "/joints")
    wanted, measured = _series(record, "/joints", "wanted_rad"), _series(record, "/joints", "measured_rad")
    for joint, name in enumerate(JOINT_NAMES):
        for leg, colour in enumerate(COLOURS):
            at = 3 * leg + joint
            axes[joint].plot(times, [degrees(row[at]) for row in wanted], color=colour, lw=0.7, ls="--")
            axes[joint].plot(times, [degrees(row[at]) for row in measured], color=colour, lw=1, label=LEG_NAMES[leg])
        axes[joint].set_ylabel(f"{name}, deg\n(wanted dashed)")


def _draw_load(record: Record, axis: Any) -> None:
    loads = _series(record, "/load", "load")
    for joint, name in enumerate(JOINT_NAMES):
        axis.plot(_times(record, "/load"), [max(abs(x) for x in row[joint::3]) for row in loads], lw=1, label=name)
    axis.set_ylabel("largest load\n1 = stall")


def _draw_attitude(record: Record, axis: Any) -> None:
    for name in ("roll_rad", "pitch_rad"):
        angles = [degrees(row.values[name]) if row.values["known"] else nan for row in record.of("/attitude")]
        axis.plot(_times(record, "/attitude"), angles, label=name[:-4])
    axis.set_ylabel("attitude, deg")


def _draw_stability(record: Record, axis: Any) -> None:
    margins_mm = [1000 * metres for metres in _series(record, "/stability", "margin_m")]
    axis.plot(_times(record, "/stability"), margins_mm, lw=1, label="margin")
    axis.axhline(0.0, color="tab:red", lw=0.8)
    axis.set_ylabel("stability\nmargin, mm")


def _draw_health(record: Record, axis: Any) -> None:
    times = _times(record, "/health")
    axis.plot(times, [max(row) for row in _series(record, "/health", "temperature_C")], label="hottest joint, C")
    axis.plot(times, [max(row) for row in _series(record, "/health", "voltage_V")], label="battery, V")
    axis.set_ylabel("health")


def _draw_timing(record: Record, axis: Any) -> None:
    for name in ("late_ms", "busy_ms"):
        axis.plot(_times(record, "/timing"), _series(record, "/timing", name), lw=0.8, label=name)
    axis.set_ylabel("timing, ms")
    axis.set_xlabel("time, s")


def _changes(record: Record) -> list[tuple[str, float]]:
    """Return the states in order, and when each began, s."""
    changes: list[tuple[str, float]] = []
    for row in record.of("/state"):
        if not changes or changes[-1][0] != row.values["state"]:
            changes.append((row.values["state"], (row.time_ns - record.start_ns) / 1e9))
    return changes


def _name_states(record: Record, axis: Any) -> None:
    """Write the states above an axis; those that follow at once are written into one line."""
    lines: list[tuple[str, float]] = []
    for state, at_s in _changes(record):
        if lines and at_s - lines[-1][1] < CLOSE * record.duration_s:
            lines[-1] = (f"{lines[-1][0]}, {state}", lines[-1][1])
        else:
            lines.append((state, at_s))
    for text, at_s in lines:
        axis.text(at_s, 1.02, text, transform=axis.get_xaxis_transform(), fontsize=8, rotation=30)
