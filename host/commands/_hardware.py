"""Which hardware a command drives: the real robot, emulated servos, or the simulated joints without a bus."""

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

from ..control.hardware import Hardware, real
from ..imu.attitude import Attitude
from ..imu.choose import open_source
from ..robot.model import Robot


def kind_of_hardware(robot: Robot, sim: bool, direct: bool) -> str:
    """Return what --sim and --direct ask for: a robot without a servo bus has none to emulate."""
    if not sim:
        return "real"
    return "emulated" if robot.bus.kind == "dynamixel" and not direct else "simulated"


@contextmanager
def hardware(
    robot: Robot,
    which: str = "real",
    port: str | None = None,
    calibration: Path | None = None,
    source: str | None = None,
    imu: str | None = None,
    space: bool = False,
) -> Iterator[Hardware]:
    """Yield a robot's joints and sensor, not yet opened; emulators that run beside them end with the block.

    ``which``: ``real``, ``emulated`` or ``simulated``. ``source`` is the name or file that the robot was loaded from.
    ``imu`` names another inertial sensor than the usual one (host/imu/choose.py); ``space``: the simulation runs in
    three dimensions.
    """
    with ExitStack() as stack:
        if which == "real":
            parts = real(robot, port, calibration)
        else:
            from ..sim.hardware import emulated, simulated  # needs the simulator's libraries

            if which == "simulated":
                parts = simulated(robot, space)
            else:
                parts = stack.enter_context(emulated(robot, calibration, source or robot.name, space))
        yield parts if imu is None else replace(parts, attitude=Attitude(robot, open_source(robot, imu)))
