"""From hardware to a supervisor: joints and sensor are opened and checked in order; nothing moves."""

import time
from collections.abc import Callable
from contextlib import ExitStack

from ..imu.attitude import Attitude
from ..robot.model import Robot
from ..util.errors import NOT_ACHIEVED, UserError
from .checks import start_checks
from .hardware import Hardware
from .supervisor import Supervisor
from .telemetry import StartCheck


def open_supervisor(
    stack: ExitStack,
    robot: Robot,
    parts: Hardware,
    told: Callable[[StartCheck], None] = lambda check: None,
    sleep: Callable[[float], None] = time.sleep,
) -> Supervisor:
    """Open the robot's parts until ``stack`` ends, tell each check, and return what drives them.

    UserError names the first check that fails.
    """
    stack.enter_context(parts.bus)
    attitude: Attitude | None = parts.attitude
    try:
        parts.attitude.open()
        stack.callback(parts.attitude.close)
    except UserError as error:
        attitude = None
        told(StartCheck("attitude", True, f"note: {error}"))
    for check in start_checks(robot, parts.bus, attitude, sleep):
        told(check)
        if not check.ok:
            raise UserError(f"{check.name}: {check.result}: the robot stays as it is", NOT_ACHIEVED)
    sense = attitude.update if attitude else lambda: None

    def put_back() -> None:
        parts.put_back()
        if attitude is not None:
            attitude.align()

    rates = (lambda: attitude.rates_rad_s) if attitude is not None else (lambda: None)
    return Supervisor(robot, parts.bus, sense, put_back=put_back, rates=rates, planar=not parts.turns)
