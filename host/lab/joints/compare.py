"""Compares position loops in the joint with loops on the host: the same walk with each, and how the joints follow."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from math import degrees, tau

import numpy as np

from ...robot.model import Robot
from ...sim.joints.sim_walk import SimWalk

MOST_LAG_MS = 100
_ROUNDING_S = 1e-6
GAIT, LIFT_M = "paper-trot", 0.02  # a table asks the same of every way to hold a position; low, or motors can't
# Where the loops run, Hz, buses: loops in current mode need the faster cycle (docs/joints.md)
CASES = (
    ("impedance", 200, 1),
    ("joint", 200, 1),
    ("host-velocity", 200, 1),
    ("joint", 400, 2),
    ("host-velocity", 400, 2),
    ("host-current", 400, 2),
)


@dataclass(frozen=True)
class Compared:
    """One walk, until its end or until it was stopped, and why.

    The errors are of all twelve motor angles, the lag is the shift that makes the error least. None: it did not walk.
    """

    loops: str
    rate_hz: int
    buses: int
    walked_s: float
    speed_m_s: float | None
    error_rms_deg: float | None
    error_worst_deg: float | None
    lag_ms: int | None
    error_after_lag_deg: float | None
    lowest_body_m: float | None
    stopped: str

    def as_dict(self) -> dict[str, object]:
        """Return plain values for JSON."""
        return asdict(self)


def with_loops(robot: Robot, loops: str, rate_hz: int, buses: int) -> Robot:
    """Return a robot whose file says so."""
    channel = ",".join(f"can{i}" for i in range(buses))
    bus = robot.bus.model_copy(update={"loops": loops, "rate_hz": rate_hz, "channel": channel})
    return robot.model_copy(update={"bus": bus})


def compare(robot: Robot, loops: str, rate_hz: int, buses: int, seconds: float,
            progress: Callable[[float], None] = lambda walked_s: None) -> Compared:  # fmt: skip
    """Stand up, walk at 0.05 m/s for a time or until the joints' guard stops the robot, and measure."""
    stops: list[str] = []
    with SimWalk(with_loops(robot, loops, rate_hz, buses), report=lambda notice: stops.append(notice.sentence)) as walk:
        walk.arm()
        walk.stand_up()
        body, rows, start_m, start_s = walk.sim.body, [], walk.sim.body.x_m, walk.sim.time_s
        walk.sim.each_ms.append(lambda ms: rows.append((walk.bus.cycle.goals_brad, list(body.angle_rad))))
        walk.driver.set_command(height_m=LIFT_M)
        while not stops and walk.sim.time_s < start_s + seconds - _ROUNDING_S:
            walk.go(1 / walk.driver.rate_hz, gait=GAIT)
            progress(walk.sim.time_s - start_s)
        walked_s, way_m, lowest = walk.sim.time_s - start_s, body.x_m - start_m, walk.lowest_m
    known = [(goals, angles) for goals, angles in rows if goals is not None]
    case, stopped = (loops, rate_hz, buses, round(walked_s, 3)), stops[0] if stops else ""
    if not known:
        return Compared(*case, *(None,) * 6, stopped)
    goals = np.array([row[0] for row in known]) * tau / 65536
    angles = np.array([row[1] for row in known])
    error = goals - angles
    lag, after = least_lag(goals, angles)
    rms, worst = float(np.sqrt(np.mean(error**2))), float(np.max(np.abs(error)))
    figures = (degrees(rms), degrees(worst), lag, degrees(after))
    return Compared(*case, way_m / walked_s, *figures, lowest, stopped)


def least_lag(goals: np.ndarray, angles: np.ndarray) -> tuple[int, float]:
    """Return the lag of the angles behind the goals, ms, and the rms error that then remains."""
    errors = []
    for lag in range(min(MOST_LAG_MS, len(goals) // 2)):
        late = goals[: len(goals) - lag]
        errors.append(float(np.sqrt(np.mean((late - angles[lag:]) ** 2))))
    best = int(np.argmin(errors))
    return best, errors[best]
