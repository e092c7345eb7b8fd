"""What everybody may know about the robot now, as plain values for JSON: for pages, scripts and the screen."""

from dataclasses import dataclass, field
from math import inf, isfinite
from typing import Any

from ..robot.gait_advice import gait_advice
from ..robot.model import Robot
from .gait_changes import gait_now, margin_m
from .loop import Loop
from .supervisor import Supervisor


@dataclass(frozen=True)
class StartCheck:
    """One start-up check and how it went."""

    name: str
    ok: bool
    result: str


@dataclass
class Extra:
    """What the loop itself does not know."""

    checks: list[StartCheck] = field(default_factory=list)
    web: str = ""
    pages: int = 0
    scripts: int = 0
    bad_messages: int = 0
    attitude_note: str = ""  # why the attitude is not known
    readings_missed: int = 0
    log: str = ""
    web_counts: dict[str, int] = field(default_factory=dict)


def rounded(values: Any, digits: int) -> list[float | None]:
    """Return floats short enough to send; None for one that is not finite."""
    return [round(value, digits) if isfinite(value) else None for value in values]


def about(robot: Robot) -> dict[str, Any]:
    """Return what does not change while the robot runs."""
    speed, body = robot.speed_limits, robot.body_limits
    return {
        "robot": robot.name,
        "gaits": gait_advice(robot),
        "speed_limits": [speed.vx_m_s, speed.vy_m_s, speed.wz_rad_s],
        "pose_limits": [body.x_m, body.y_m, body.z_m, *(round(angle, 5) for angle in body.angles_rad)],
    }


def _speed(supervisor: Supervisor) -> tuple[float, float, float]:
    """Return what the planner is told to walk at, m/s and rad/s: nothing while the robot does not walk."""
    wish = supervisor.driver.command
    walks = supervisor.armed and supervisor.driver.state == "walking" and wish.mode == "walk"
    return (wish.vx_m_s, wish.vy_m_s, wish.wz_rad_s) if walks else (0.0, 0.0, 0.0)


def status(loop: Loop, extra: Extra) -> dict[str, Any]:
    """Return the state, the reason, who drives, what is measured, and the loop's figures."""
    supervisor = loop.supervisor
    arbiter, measured, now_s = supervisor.arbiter, supervisor.measured, loop.clock()
    numbers, stop = supervisor.driver.planner.status, arbiter.stop
    battery_V = measured.battery_V
    return {
        "type": "status",
        "time_s": round(now_s, 4),
        "state": supervisor.state,
        "reason": supervisor.reason(now_s),
        "stop": None if stop is None else str(stop.client),
        "fault": supervisor.safety.sentence,
        "driver": None if arbiter.driver is None else [arbiter.driver.source, arbiter.driver.number],
        "fresh": arbiter.fresh(now_s),
        "armed": supervisor.armed,
        "gait": arbiter.gait,
        "walks": gait_now(supervisor.driver) if supervisor.driver.state == "walking" else "",
        "remark": supervisor.remark,
        "margin_m": round(margin_m(supervisor.driver), 4) if supervisor.armed else None,
        "balance": arbiter.balance,
        "speed": rounded(_speed(supervisor), 4),
        "attitude_rad": None if supervisor.attitude is None else rounded(supervisor.attitude, 4),
        "attitude_note": extra.attitude_note,
        "readings_missed": extra.readings_missed,
        "battery_V": None if battery_V is None else round(battery_V, 2),
        "joints_rad": rounded(measured.position_rad, 4),
        "load": rounded(measured.load, 3),
        "temperature_C": rounded(measured.temperature_C, 1),
        "silent": [joint for joint, age_s in enumerate(measured.age_s) if age_s == inf],
        "swinging": numbers.swinging,
        "bus_asked": supervisor.bus.counters.sent,
        "bus_errors": supervisor.bus.counters.errors,
        "obeyed": arbiter.obeyed,
        "refused": arbiter.refused,
        "bad_messages": extra.bad_messages,
        "timing": {
            "rate_hz": supervisor.driver.rate_hz,
            "ticks": loop.pacer.ticks,
            "missed": loop.pacer.missed,
            "steered_at_s": loop.steered_at_s,
            "stopped_at_s": loop.stopped_at_s,
        },
        "checks": [f"{each.name}: {each.result}" for each in extra.checks],
        "log": extra.log,
        "pages": extra.pages,
        "web_counts": extra.web_counts,
        "web": extra.web,
        "scripts": extra.scripts,
    }
