"""Start-up checks, in order, each with its result. The first that fails ends the start: nothing has moved yet."""

import time
from collections.abc import Callable, Iterator

from ..bus.base import JOINTS, Bus, Measured
from ..imu.attitude import Attitude
from ..robot.model import Robot
from .safety import Safety
from .telemetry import StartCheck

# A servo's voltage and heat come in turns; a second is several rounds.
SLOW_VALUES_S = 1.0
IMU_READINGS = 5


def start_checks(
    robot: Robot, bus: Bus, attitude: Attitude | None, sleep: Callable[[float], None] = time.sleep
) -> Iterator[StartCheck]:
    """Yield the checks one by one; ``bus`` is open, and its joints are off."""
    yield StartCheck("robot file", True, f"{robot.name}, {robot.control.rate_hz} Hz, gait {robot.gait.default}")
    measured = _all_values(robot, bus, sleep)
    silent = sum(age_s > SLOW_VALUES_S for age_s in measured.age_s)
    yield StartCheck("joints answer", not silent, f"{JOINTS - silent} of {JOINTS} ({bus.kind})")
    for warning in bus.warnings:
        yield StartCheck("bus", True, f"warning: {warning}")
    yield _health(robot, measured)
    yield _battery(measured)
    yield _temperature(measured)
    yield _imu(attitude)


def _all_values(robot: Robot, bus: Bus, sleep: Callable[[float], None]) -> Measured:
    """Read until everything has been told once, or the time is over."""
    measured, end_s = bus.read(), bus.now() + SLOW_VALUES_S
    while not (measured.complete and max(measured.slow_age_s) < SLOW_VALUES_S) and bus.now() < end_s:
        sleep(1 / robot.control.rate_hz)
        measured = bus.read()
    return measured


def _health(robot: Robot, measured: Measured) -> StartCheck:
    safety = Safety(robot)
    safety.update(measured)
    return StartCheck("no faults", safety.action == "none", safety.sentence or "none")


def _battery(measured: Measured) -> StartCheck:
    volts = measured.battery_V
    return StartCheck("battery", volts is not None, "no joint tells a voltage" if volts is None else f"{volts:.1f} V")


def _temperature(measured: Measured) -> StartCheck:
    return StartCheck("temperature", True, f"at most {max(measured.temperature_C):.0f} degrees C")


def _imu(attitude: Attitude | None) -> StartCheck:
    """A robot without attitude walks, but not as level: the check never ends the start."""
    if attitude is None:
        return StartCheck("attitude", True, "no sensor: the body is not kept level")
    for _ in range(IMU_READINGS):
        attitude.update()
    return StartCheck("attitude", True, f"fault: {attitude.fault}" if attitude.fault else f"{attitude.source.kind}")
