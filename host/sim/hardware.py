"""Stand-ins for a robot's hardware: emulated servos in a process of their own, or the plane's drives without a bus."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..bus.dynamixel.bus import ServoBus
from ..bus.dynamixel.calibration.data import load_calibration, nominal, servo_of
from ..bus.dynamixel.link import serial_bus
from ..bus.dynamixel.port import ServoPort
from ..control.hardware import Hardware, Stage
from ..imu.attitude import Attitude
from ..robot.file import find
from ..robot.model import Robot
from .bus import SimulatedBus
from .imu import SimulatedImu
from .servos.process import Emulator, EmulatorImu, Late
from .stage import ground, profiles

PUT_BACK_S = 0.01  # the loop waits for the answer


def simulated(robot: Robot, space: bool = False, clock: Callable[[], float] = time.monotonic) -> Hardware:
    """Return the drives of the plane, or of three dimensions, which goals reach without any bus."""
    plant = stage = None
    if space:
        from .space.plant import SpacePlant

        plant = there = SpacePlant(robot)
        stage = Stage(profiles(), lambda name: there.set_ground(ground(name)), there.place)
    bus = SimulatedBus(robot, clock, plant)
    attitude = Attitude(robot, SimulatedImu(robot, bus.plant.inertial))
    return Hardware(bus, attitude, bus.plant.put_back, turns=space, simulated=True, stage=stage)


@contextmanager
def emulated(robot: Robot, calibration: Path | None, source: str, space: bool = False) -> Iterator[Hardware]:
    """Yield servos behind a pseudo-terminal, in a process that ends with the block and loads the robot ``source``.

    ``space``: they move the robot in three dimensions.
    """
    servo_of(robot)
    options = ["--robot", str(find(source)), "--plant", "space" if space else "ground"]
    options.append("--honest" if robot.simulation.honest else "--simple")
    if calibration is not None:
        options += ["--truth", str(calibration)]
    data = load_calibration(calibration, robot) if calibration is not None else nominal(robot)
    with Emulator(*options) as emulator:

        def put_back() -> None:
            with suppress(Late):  # a busy emulator does it all the same, a little later
                emulator.ask("put_back", PUT_BACK_S)

        bus = ServoBus(robot, data, ServoPort(emulator.port, serial_bus(robot).baud))
        sensor = EmulatorImu(emulator)
        stage = None
        if space:
            stage = Stage(profiles(), sensor.choose, lambda: sensor.place)
        yield Hardware(bus, Attitude(robot, sensor), put_back, turns=space, simulated=True, stage=stage)
