"""One picture per joint: the measurement, and the motion of a servo with the fitted numbers."""

from pathlib import Path
from typing import Any

import numpy as np

from ..bus.base import JOINT_LABELS
from ..robot.actuators import Servo
from ..util.files import atomic_path
from ..util.pictures import make_figure
from .fit import Fitted, JointFit, kind_of
from .model import Array, Load, friction_Nm
from .sweeping import Trace

SHOWN = (("runs", "run"), ("coasting, torque off while moving", "coast"), ("back and forth", "back"),
         ("steps and chirps", "steps chirp"), ("slow: duty", "slow"))  # fmt: skip


def draw(path: Path, joint: int, servo: Servo, load: Load, traces: list[Trace], fitted: Fitted, words: str) -> None:
    """Draw one joint's sweeps into a PNG file."""
    fit = JointFit(servo, load, traces)
    p = {name: np.array([[value]]) for name, value in fitted.values.items()}
    fit.settle_at(p)
    seen = fit.seen(p)
    figure = make_figure(15, 8.5)
    axes = figure.subplots(2, 3)
    figure.suptitle(f"{JOINT_LABELS[joint]}: {words}\n{_numbers(fitted)}", fontsize=10)
    for (title, names), place in zip(SHOWN, axes.flat, strict=False):
        some = [row for row in seen if kind_of(row[0]) in names.split()]
        _curves(place, title, some, "slow" in names)
    _friction(axes.flat[5], servo, p)
    axes.flat[0].plot([], [], "k.", ms=3, label="measured")
    axes.flat[0].plot([], [], "tab:orange", label="fitted")
    axes.flat[0].legend(loc="upper left")
    with atomic_path(path) as draft:
        figure.savefig(draft, dpi=90, format="png")


def _numbers(fitted: Fitted) -> str:
    v = fitted.values
    return (
        f"stall {v['stall_Nm']:.2f} N m, no load {v['no_load_rad_s']:.2f} rad/s, {v['duty_per_rad']:.2f} duty/rad, "
        f"friction {v['coulomb_Nm']:.3f} + {v['stribeck_Nm']:.3f} N m, play {np.degrees(v['backlash_rad']):.2f} deg, "
        f"armature {v['armature_kg_m2']:.4f} kg m2, delay {1000 * fitted.delay_s:.1f} ms, misfit {fitted.misfit:.2f}"
    )


def _curves(place: Any, title: str, rows: list[tuple[Trace, Array, Array]], duty: bool) -> None:
    for trace, angles, duties in rows:
        times = np.array(trace.asked_s)
        measured, fitted = (np.array(trace.load), duties[0]) if duty else (np.array(trace.position_rad), angles[0])
        scale, zero = (100.0, 0.0) if duty else (np.degrees(1.0), trace.position_rad[0])
        place.plot(times, scale * (measured - zero), "k.", ms=2)
        place.plot(times, scale * (fitted - zero), "tab:orange", lw=0.9)
    place.set_title(title)
    place.set_xlabel("s")
    place.set_ylabel("duty, %" if duty else "turned since the start, deg")
    place.grid(alpha=0.3)


def _friction(place: Any, servo: Servo, p: dict[str, Array]) -> None:
    """Draw friction over speed, without load and with half a newton metre."""
    speed = np.linspace(0, 3, 200)
    for load_Nm in (0.0, 0.25, 0.5):
        most = friction_Nm(p, servo.friction, np.full_like(speed, load_Nm), np.full_like(speed, -load_Nm), speed)
        place.plot(speed, most.reshape(-1), label=f"holding {load_Nm:g} N m")
    place.set_title("friction, fitted")
    place.set_xlabel("rad/s")
    place.set_ylabel("N m")
    place.set_ylim(bottom=0)
    place.legend()
    place.grid(alpha=0.3)
