"""The record of a simulated joint as one picture: position, velocity, currents, torque, temperature over time."""

from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING

from shared.wire import names as w

from ...util.files import atomic_path
from ...util.pictures import make_figure

FAULTY = (w.STATE_FAULT_REACTION, w.STATE_FAULT)
LEAST_SPAN = (2.0, 0.2, 0.2, 0.2, 1.0)  # deg, rad/s, A, N m, K: what stands still is drawn as a line, not as its noise

if TYPE_CHECKING:
    from .result import Result


def draw(result: "Result", path: Path) -> None:
    """Write the picture of a scenario."""
    t, limit = result.bench.trace, result.bench.bldc.drive.current_limit_A
    figure = make_figure(10, 10)
    position, speed, current, torque, heat = figure.subplots(5, 1, sharex=True)
    figure.suptitle(f"{result.name}: {'ok' if result.ok else 'not achieved'}")
    position.plot(t.time_s, [degrees(x) for x in t.joint_rad], label="joint")
    if result.name in ("step", "glitches", "sine"):
        position.plot(t.time_s, [degrees(x) for x in t.goal_rad], "--", label="set-point")
    position.set_ylabel("position, deg")
    speed.plot(t.time_s, t.speed_rad_s, label="joint")
    speed.set_ylabel("velocity, rad/s")
    current.plot(t.time_s, t.peak_A, color="0.7", label="largest phase current")
    current.plot(t.time_s, t.current_A, label="q current")
    current.plot(t.time_s, t.limit_A, "--", color="tab:red", label="limit left")
    current.set_ylim(-1.15 * limit, 1.25 * limit)
    current.set_ylabel("current, A")
    torque.plot(t.time_s, t.torque_Nm, label="at the joint")
    torque.set_ylabel("torque, N m")
    heat.plot(t.time_s, t.winding_C, label="winding")
    heat.set_ylabel("temperature, degrees C")
    heat.set_xlabel("time since power-on, s")
    faulty = next((at for at, state in zip(t.time_s, t.state, strict=True) if state in FAULTY), None)
    for axes, least in zip((position, speed, current, torque, heat), LEAST_SPAN, strict=True):
        if faulty is not None:
            axes.axvline(faulty, color="tab:red", linestyle=":", label="fault")
        low, high = axes.get_ylim()
        wider = max(0.0, least - (high - low)) / 2
        axes.set_ylim(low - wider, high + wider)
        axes.ticklabel_format(useOffset=False)
        axes.grid(alpha=0.3)
        axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")
    with atomic_path(path) as draft:
        figure.savefig(draft, dpi=110)
