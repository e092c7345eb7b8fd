"""Which joints and which inertial sensor a command talks to: real, emulated servos, or simulated without a bus."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from ..calibration.data import default_path, load_calibration, nominal, servo_of
from ..errors import UserError
from ..imu.attitude import Attitude
from ..imu.simulated import SimulatedImu
from ..robot_file import find
from ..robot_model import Robot
from .base import Bus

PUT_BACK_S = 0.01  # the loop waits for the answer


@dataclass(frozen=True)
class Hardware:
    """What a robot is driven through, neither of them opened yet.

    ``put_back`` lifts a simulated robot and puts it down seated; with a real one that is left to a person.
    """

    bus: Bus
    attitude: Attitude
    put_back: Callable[[], object] = lambda: None


@contextmanager
def hardware(
    robot: Robot,
    which: str = "real",
    port: str | None = None,
    calibration: Path | None = None,
    source: str | None = None,
) -> Iterator[Hardware]:
    """Yield a robot's joints and sensor, not yet opened; what runs beside them ends with the block.

    ``which``: ``real``, ``emulated`` (servos behind a pseudo-terminal, in a process of their own) or ``simulated``.
    ``source`` is the name or file that the robot was loaded from, which the emulator loads again.
    """
    makers = {"real": _real, "emulated": _emulated, "simulated": _simulated}
    with ExitStack() as stack:
        yield makers[which](stack, robot, port, calibration, source or robot.name)


def _simulated(stack: ExitStack, robot: Robot, port: str | None, calibration: Path | None, source: str) -> Hardware:
    from .simulated import SimulatedBus

    bus = SimulatedBus(robot)
    return Hardware(bus, Attitude(robot, SimulatedImu(robot, bus.plant.inertial)), bus.plant.put_back)


def _emulated(stack: ExitStack, robot: Robot, port: str | None, calibration: Path | None, source: str) -> Hardware:
    from ..emulator.process import Emulator, EmulatorImu, Late
    from ..servos.bus import ServoBus
    from ..servos.port import ServoPort

    servo_of(robot)
    options = ["--robot", str(find(source))]
    if calibration is not None:
        options += ["--truth", str(calibration)]
    emulator = stack.enter_context(Emulator(*options))
    data = load_calibration(calibration, robot) if calibration is not None else nominal(robot)
    bus = ServoBus(robot, data, ServoPort(emulator.port, baud(robot)))

    def put_back() -> None:
        with suppress(Late):  # a busy emulator does it all the same, a little later
            emulator.ask("put_back", PUT_BACK_S)

    return Hardware(bus, Attitude(robot, EmulatorImu(emulator)), put_back)


def _real(stack: ExitStack, robot: Robot, port: str | None, calibration: Path | None, source: str) -> Hardware:
    from ..imu.mpu6050 import Mpu6050
    from ..servos.bus import ServoBus
    from ..servos.port import ServoPort

    servo_of(robot)
    data = load_calibration(calibration or default_path(robot), robot)
    bus = ServoBus(robot, data, ServoPort(port or device(robot), baud(robot)))
    return Hardware(bus, Attitude(robot, Mpu6050(robot)))


def baud(robot: Robot) -> int:
    """Return the servo bus's rate."""
    if robot.bus.kind != "dynamixel":
        raise UserError(f"{robot.name} has no servo bus")
    return robot.bus.baud


def device(robot: Robot) -> str:
    """Return the servo bus's port."""
    if robot.bus.kind != "dynamixel":
        raise UserError(f"{robot.name} has no servo bus")
    return robot.bus.port
