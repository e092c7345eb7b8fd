"""A picture of a record: states, joint angles wanted and measured, loads, attitude, heat, timing."""

from math import degrees
from pathlib import Path
from typing import Any

from ..files import atomic_path
from ..robot_model import JOINT_NAMES, LEG_NAMES
from .reader import Record

COLOURS = ("tab:blue", "tab:orange", "tab:green", "tab:red")


def plot_png(record: Record, path: Path) -> None:
    """Draw a record into a PNG file."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(7, 1, figsize=(11, 17), sharex=True, layout="constrained")
    figure.suptitle(f"{record.about.get('robot', 'robot')}: {record.duration_s:.1f} s, {record.path.name}")
    _draw_joints(record, axes[:3])
    _draw_load(record, axes[3])
    _draw_attitude(record, axes[4])
    _draw_health(record, axes[5])
    _draw_timing(record, axes[6])
    for each in axes:
        _mark_states(record, each)
        each.grid(alpha=0.3)
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
    axes[0].legend(ncols=4, loc="upper right")


def _draw_load(record: Record, axis: Any) -> None:
    loads = _series(record, "/load", "load")
    for joint, name in enumerate(JOINT_NAMES):
        axis.plot(_times(record, "/load"), [max(abs(x) for x in row[joint::3]) for row in loads], lw=1, label=name)
    axis.set_ylabel("largest load\n1 = stall")
    axis.legend(ncols=3, loc="upper right")


def _draw_attitude(record: Record, axis: Any) -> None:
    for name in ("roll_rad", "pitch_rad"):
        axis.plot(
            _times(record, "/attitude"), [degrees(x) for x in _series(record, "/attitude", name)], label=name[:-4]
        )
    axis.set_ylabel("attitude, deg")
    axis.legend(ncols=2, loc="upper right")


def _draw_health(record: Record, axis: Any) -> None:
    times = _times(record, "/health")
    axis.plot(times, [max(row) for row in _series(record, "/health", "temperature_C")], label="hottest joint, C")
    axis.plot(times, [max(row) for row in _series(record, "/health", "voltage_V")], label="battery, V")
    axis.set_ylabel("health")
    axis.legend(ncols=2, loc="upper right")


def _draw_timing(record: Record, axis: Any) -> None:
    for name in ("late_ms", "busy_ms"):
        axis.plot(_times(record, "/timing"), _series(record, "/timing", name), lw=0.8, label=name)
    axis.set_ylabel("timing, ms")
    axis.set_xlabel("time, s")
    axis.legend(ncols=2, loc="upper right")


def _mark_states(record: Record, axis: Any) -> None:
    before = ""
    for row in record.of("/state"):
        state, at_s = row.values["state"], (row.time_ns - record.start_ns) / 1e9
        if state != before:
            axis.axvline(at_s, color="0.6", lw=0.6)
            axis.text(at_s, 1.0, f" {state}", transform=axis.get_xaxis_transform(), fontsize=7, va="top", rotation=90)
        before = state
