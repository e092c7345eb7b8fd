"""The place of a robot, by name: its hardware and its clock.

``sim``: the sagittal plane, in simulated time. ``space``: three dimensions (MuJoCo, extra `space`), in simulated time.
``servos``: Dynamixel servos on a serial port. ``can``: brushless joints on a CAN bus.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from ..control.hardware import Hardware, real
from ..imu.absent import AbsentImu
from ..imu.attitude import Attitude
from ..imu.choose import open_source
from ..robot.model import Robot
from .errors import BadValue, shown

PLACES = ("sim", "space", "servos", "can")
BUS_OF = {"servos": "dynamixel", "can": "can"}
NO_IMU = "the robot was opened without an inertial sensor: the body is not kept level"

Pose = tuple[float, float, float]  # x and y in m, yaw in rad


class SimulatedClock:
    """Monotonic seconds that pass only on demand."""

    def __init__(self) -> None:
        self._now_s = time.monotonic()  # so that records show the real date, as on a robot

    def __call__(self) -> float:
        return self._now_s

    def advance(self, seconds: float) -> None:
        """Let time pass."""
        self._now_s += seconds


@dataclass(frozen=True)
class Place:
    """``advance`` lets simulated time pass; None if it passes by itself. ``truth``: where a simulated body is."""

    hardware: Hardware
    clock: Callable[[], float] = time.monotonic
    advance: Callable[[float], None] | None = None
    truth: Callable[[], Pose] | None = None


def find_place(name: object, robot: Robot, port: str | None, calibration: Path | None, imu: str | None,
               honest: bool | None) -> Place:
    """Return a place; BadValue for an unknown name, or if the robot has no such bus.

    ``port`` and ``calibration``: see control/hardware.py; ``imu``: "" for the usual one, None for none, or where it is.
    """
    if not isinstance(name, str) or name not in PLACES:
        raise BadValue(f"place {shown(name)}: allowed {', '.join(PLACES)}")
    if name in BUS_OF:
        if honest is not None:
            raise BadValue(f"place {name!r}: honest is only for sim and space")
        return _real(name, robot, port, calibration, imu)
    if port is not None or calibration is not None or imu != "":
        raise BadValue(f"place {name!r}: port, calibration and imu are only for servos and can")
    return _simulated(robot, name == "space")


def _real(name: str, robot: Robot, port: str | None, calibration: Path | None, imu: str | None) -> Place:
    if robot.bus.kind != BUS_OF[name]:
        others = [place for place, kind in BUS_OF.items() if kind == robot.bus.kind]
        has = f"the joints of {robot.name} are {others[0]!r}" if others else f"{robot.name} is only for sim and space"
        raise BadValue(f"place {name!r}: {has}")
    parts = real(robot, port, calibration)
    if imu is None:
        parts = replace(parts, attitude=Attitude(robot, AbsentImu(NO_IMU)))
    elif imu:
        parts = replace(parts, attitude=Attitude(robot, open_source(robot, imu)))
    return Place(parts)


def _simulated(robot: Robot, space: bool) -> Place:
    from ..sim.bus import SimulatedBus
    from ..sim.hardware import simulated

    clock = SimulatedClock()
    parts = simulated(robot, space, clock)
    assert isinstance(parts.bus, SimulatedBus)
    return Place(parts, clock, clock.advance, parts.bus.plant.pose)
