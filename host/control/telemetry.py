"""The robot's status as plain values for JSON: for pages, scripts and the screen."""

from dataclasses import astuple, dataclass, field
from math import inf, isfinite
from typing import Any

from ..imu.attitude import Attitude
from ..robot.gait_advice import gait_advice
from ..robot.model import Robot
from ..util.version import versions
from .gait_changes import exchange_phase, gait_now, margin_m
from .hardware import Hardware, Place
from .loop import Loop
from .supervisor import Supervisor

LIMITED = 1.001  # of the limit: below it only the core's rounding limits a command


@dataclass(frozen=True)
class StartCheck:
    """One start-up check and its result."""

    name: str
    ok: bool
    result: str


@dataclass
class Extra:
    """Values for the status that the loop itself does not know."""

    checks: list[StartCheck] = field(default_factory=list)
    web: str = ""
    pages: int = 0
    foxglove: str = ""
    scripts: int = 0
    bad_messages: int = 0
    attitude_note: str = ""  # why the attitude is unknown
    readings_missed: int = 0
    log: str = ""
    ground: str = ""  # of a simulation in space
    place: Place | None = None  # on it
    web_counts: dict[str, int] = field(default_factory=dict)

    def look_at(self, attitude: Attitude) -> None:
        """Store why the attitude is unknown, and how many readings were missed."""
        self.attitude_note, self.readings_missed = attitude.fault or attitude.note, attitude.missed


def rounded(values: Any, digits: int) -> list[float | None]:
    """Return floats rounded for sending; None for one that is not finite."""
    return [round(value, digits) if isfinite(value) else None for value in values]


def about(robot: Robot, parts: Hardware) -> dict[str, Any]:
    """Return the values that do not change while the robot runs; ``parts`` are open."""
    speed, body, drive = robot.speed_limits, robot.body_limits, robot.actuator
    return {
        "robot": robot.name,
        "simulated": parts.simulated,
        "grounds": {} if parts.stage is None else {name: list(line) for name, line in parts.stage.grounds.items()},
        "versions": {**versions(), "joints": parts.bus.firmware},
        "low_V": drive.low_V,
        "hot_C": drive.sit_C if isfinite(drive.sit_C) else None,
        "gaits": gait_advice(robot),
        "speed_limits": [speed.vx_m_s, speed.vy_m_s, speed.wz_rad_s],
        "pose_limits": [body.x_m, body.y_m, body.z_m, *(round(angle, 5) for angle in body.angles_rad)],
    }


def _speed(supervisor: Supervisor) -> tuple[float, float, float]:
    """Return the planner's commanded speeds, m/s and rad/s: zeros while the robot does not walk."""
    wish = supervisor.driver.command
    walks = supervisor.armed and supervisor.driver.state == "walking" and wish.mode == "walk"
    return (wish.vx_m_s, wish.vy_m_s, wish.wz_rad_s) if walks else (0.0, 0.0, 0.0)


def slower(supervisor: Supervisor) -> str:
    """Return why the robot walks more slowly than commanded on purpose, "" if it does not."""
    driver, wish = supervisor.driver, supervisor.driver.command
    if not any(_speed(supervisor)):
        return ""
    phase = exchange_phase(driver)
    if phase:
        return f"{phase}: at its own speed"
    asked = abs(wish.vx_m_s), abs(wish.vy_m_s), abs(wish.wz_rad_s)
    most = driver.fastest(wish.gait)
    if asked[0] > LIMITED * most[0]:
        return f"{wish.gait} is limited to {most[0]:.3g} m/s by {driver.speed_limit(wish.gait)[1]}"
    if any(each > LIMITED * limit for each, limit in zip(asked, most, strict=True)):
        return f"{wish.gait} is limited to {most[1]:.3g} m/s sideways and {most[2]:.3g} rad/s"
    return ""


def status(loop: Loop, extra: Extra) -> dict[str, Any]:
    """Return the state, the reason, the driver, the measured values, and the loop's figures."""
    supervisor = loop.supervisor
    arbiter, now_s = supervisor.arbiter, loop.clock()
    return {
        "type": "status",
        "time_s": round(now_s, 4),
        "state": supervisor.state,
        "reason": supervisor.reason(now_s),
        "stop": None if arbiter.stop is None else str(arbiter.stop.client),
        "fault": supervisor.safety.sentence,
        "driver": None if arbiter.driver is None else [arbiter.driver.source, arbiter.driver.number],
        "fresh": arbiter.fresh(now_s),
        "armed": supervisor.armed,
        **_gait(supervisor),
        **_measured(supervisor),
        "obeyed": arbiter.obeyed,
        "refused": arbiter.refused,
        "timing": {
            "rate_hz": supervisor.driver.rate_hz,
            "ticks": loop.pacer.ticks,
            "missed": loop.pacer.missed,
            "steered_at_s": loop.steered_at_s,
            "stopped_at_s": loop.stopped_at_s,
        },
        **vars(extra),
        "place": None if extra.place is None else rounded(extra.place, 4),
        "checks": [f"{each.name}: {each.result}" for each in extra.checks],
    }


def _gait(supervisor: Supervisor) -> dict[str, Any]:
    """Return the gait and the speeds."""
    arbiter, driver = supervisor.arbiter, supervisor.driver
    odometry = driver.odometry
    return {
        "gait": arbiter.gait,
        "walks": gait_now(driver) if driver.state == "walking" else "",
        "remark": supervisor.remark,
        "margin_m": round(margin_m(driver), 4) if supervisor.armed else None,
        "balance": arbiter.balance,
        "speed": rounded(_speed(supervisor), 4),
        "fastest": rounded(supervisor.fastest(), 4),
        "slower": slower(supervisor),
        "odometry": rounded(astuple(odometry)[:6], 4),
        "covariance": rounded(odometry.covariance, 9),
        "swinging": driver.planner.status.swinging,
    }


def _measured(supervisor: Supervisor) -> dict[str, Any]:
    """Return the values of the joints and the bus."""
    measured, counters = supervisor.measured, supervisor.bus.counters
    battery_V = measured.battery_V
    return {
        "attitude_rad": None if supervisor.attitude is None else rounded(supervisor.attitude, 4),
        "battery_V": None if battery_V is None else round(battery_V, 2),
        "joints_rad": rounded(measured.position_rad, 4),
        "load": rounded(measured.load, 3),
        "temperature_C": rounded(measured.temperature_C, 1),
        "silent": [joint for joint, age_s in enumerate(measured.age_s) if age_s == inf],
        "bus_asked": counters.sent,
        "bus_errors": counters.errors,
        "lost_by_joint": list(counters.per_joint_lost),
    }
