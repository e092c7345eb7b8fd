"""Stand-ins for a robot's hardware: emulated servos in a process of their own, or the plane's drives without a bus."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from ..bus.dynamixel.bus import ServoBus
from ..bus.dynamixel.calibration.data import load_calibration, nominal, servo_of
from ..bus.dynamixel.port import ServoPort
from ..control.hardware import Hardware, baud
from ..imu.attitude import Attitude
from ..robot.file import find
from ..robot.model import Robot
from .bus import SimulatedBus
from .imu import SimulatedImu
from .servos.process import Emulator, EmulatorImu, Late

PUT_BACK_S = 0.01  # the loop waits for the answer


def simulated(robot: Robot) -> Hardware:
    """Return the plane's drives, which goals reach without any bus."""
    bus = SimulatedBus(robot)
    return Hardware(bus, Attitude(robot, SimulatedImu(robot, bus.plant.inertial)), bus.plant.put_back, turns=False)


@contextmanager
def emulated(robot: Robot, calibration: Path | None, source: str) -> Iterator[Hardware]:
    """Yield servos behind a pseudo-terminal, in a process that ends with the block and loads the robot ``source``."""
    servo_of(robot)
    options = ["--robot", str(find(source))]
    if calibration is not None:
        options += ["--truth", str(calibration)]
    data = load_calibration(calibration, robot) if calibration is not None else nominal(robot)
    with Emulator(*options) as emulator:

        def put_back() -> None:
            with suppress(Late):  # a busy emulator does it all the same, a little later
                emulator.ask("put_back", PUT_BACK_S)

        bus = ServoBus(robot, data, ServoPort(emulator.port, baud(robot)))
        yield Hardware(bus, Attitude(robot, EmulatorImu(emulator)), put_back, turns=False)
