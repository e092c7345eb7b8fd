"""Which joints and which inertial sensor a command talks to: servos or joints on CAN, emulated ones, or simulated."""

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from ..calibration.data import default_path, load_calibration, nominal, servo_of
from ..errors import UserError
from ..imu.absent import AbsentImu
from ..imu.attitude import Attitude
from ..imu.choose import I2C, open_source
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
    imu: str | None = None,
) -> Iterator[Hardware]:
    """Yield a robot's joints and sensor, not yet opened; what runs beside them ends with the block.

    ``which``: ``real``, ``emulated`` (servos behind a pseudo-terminal, in a process of their own) or ``simulated``.
    Joints on CAN that ``caramelo joints sim`` simulates are real ones here.
    ``source`` is the name or file that the robot was loaded from, which the emulator loads again. ``imu`` names
    another inertial sensor than the usual one (host/imu/choose.py).
    """
    makers = {"real": _real, "emulated": _emulated, "simulated": _simulated}
    with ExitStack() as stack:
        parts = makers[which](stack, robot, port, calibration, source or robot.name)
        yield parts if imu is None else replace(parts, attitude=Attitude(robot, open_source(robot, imu)))


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


SIMULATED_INTERFACES = ("udp_multicast", "virtual")  # what caramelo joints sim is reached by
ELSEWHERE = "the joints are simulated elsewhere, and their body's sensor is not here: the body is not kept level"


def _real(stack: ExitStack, robot: Robot, port: str | None, calibration: Path | None, source: str) -> Hardware:
    if robot.bus.kind == "can":
        elsewhere = (port or robot.bus.interface).partition(":")[0] in SIMULATED_INTERFACES
        imu = AbsentImu(ELSEWHERE) if elsewhere else open_source(robot, I2C)
        return Hardware(can_joints(robot, port), Attitude(robot, imu))
    from ..servos.bus import ServoBus
    from ..servos.port import ServoPort

    servo_of(robot)
    data = load_calibration(calibration or default_path(robot), robot)
    bus = ServoBus(robot, data, ServoPort(port or device(robot), baud(robot)))
    return Hardware(bus, Attitude(robot, open_source(robot, I2C)))


def can_joints(robot: Robot, port: str | None) -> Bus:
    """Return the joints on CAN; ``port`` INTERFACE:CHANNEL goes before the robot file's own."""
    from ..can.open import open_port
    from ..emulator.plant import seated_pose_rad
    from .can_joints import CanJoints, new_session

    assert robot.bus.kind == "can"
    interface, colon, channel = (port or "").partition(":")
    if port and not (colon and interface and channel):
        raise UserError(f"--port {port}: of joints on CAN it is INTERFACE:CHANNEL, such as socketcan:can0")
    bus_port = open_port(robot.bus, interface or None, channel or None)
    return CanJoints(robot, bus_port, new_session(), seated_pose_rad(robot), threaded=True)


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
