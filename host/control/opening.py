"""From hardware to a supervisor: opens and checks joints and sensor in order; nothing moves.

The first check that fails ends the start.
"""

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack

from ..bus.base import JOINTS, Bus, Measured
from ..imu.attitude import Attitude
from ..robot.model import Robot
from ..util.errors import NOT_ACHIEVED, UserError
from .hardware import Hardware
from .safety import Safety
from .supervisor import Supervisor
from .telemetry import StartCheck

# Servos report voltage and heat in turns; a second covers several rounds.
SLOW_VALUES_S = 1.0
IMU_READINGS = 5


def open_supervisor(
    stack: ExitStack,
    robot: Robot,
    parts: Hardware,
    told: Callable[[StartCheck], None] = lambda check: None,
    sleep: Callable[[float], None] = time.sleep,
) -> Supervisor:
    """Open the robot's parts until ``stack`` ends, report each check, and return what drives them.

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


def start_checks(
    robot: Robot, bus: Bus, attitude: Attitude | None, sleep: Callable[[float], None]
) -> Iterator[StartCheck]:
    """Yield the checks one by one; ``bus`` is open, and its joints are off."""
    yield StartCheck("robot file", True, f"{robot.name}, {robot.control.rate_hz} Hz, gait {robot.gait.default}")
    measured = _all_values(robot, bus, sleep)
    silent = sum(age_s > SLOW_VALUES_S for age_s in measured.age_s)
    yield StartCheck("joints answer", not silent, f"{JOINTS - silent} of {JOINTS} ({bus.kind})")
    for warning in bus.warnings:
        yield StartCheck("bus", True, f"warning: {warning}")
    safety = Safety(robot)
    safety.update(measured)
    yield StartCheck("no faults", safety.action == "none", safety.sentence or "none")
    volts = measured.battery_V
    yield StartCheck("battery", volts is not None, "no joint reports a voltage" if volts is None else f"{volts:.1f} V")
    yield StartCheck("temperature", True, f"at most {max(measured.temperature_C):.0f} degrees C")
    yield _imu(attitude)


def _all_values(robot: Robot, bus: Bus, sleep: Callable[[float], None]) -> Measured:
    """Read until every value has been reported once, or the time is over."""
    measured, end_s = bus.read(), bus.now() + SLOW_VALUES_S
    while not (measured.complete and max(measured.slow_age_s) < SLOW_VALUES_S) and bus.now() < end_s:
        sleep(1 / robot.control.rate_hz)
        measured = bus.read()
    return measured


def _imu(attitude: Attitude | None) -> StartCheck:
    """Check the attitude; this never ends the start, because a robot without attitude still walks, only less level."""
    if attitude is None:
        return StartCheck("attitude", True, "no sensor: the body is not kept level")
    for _ in range(IMU_READINGS):
        attitude.update()
    return StartCheck("attitude", True, f"fault: {attitude.fault}" if attitude.fault else f"{attitude.source.kind}")
