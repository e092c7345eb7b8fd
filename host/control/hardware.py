"""A real robot's hardware: its servos or its joints on CAN, and its inertial sensor, none of them opened yet."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ..bus.base import Bus
from ..imu.absent import AbsentImu
from ..imu.attitude import Attitude
from ..imu.choose import I2C, open_source
from ..robot.model import Robot
from ..robot.poses import seated_pose_rad
from ..util.errors import UserError

SIMULATED_INTERFACES = ("udp_multicast", "virtual")  # those of caramelo joints sim
ELSEWHERE = "another program simulates the joints, and their body's sensor is not here: the body is not kept level"


Place = tuple[float, float, float, float]  # x, y, z of the middle of the hips, m, and yaw, rad


@dataclass(frozen=True)
class Stage:
    """The grounds of a simulated robot, by name, each as the (x, z) of its surface along the way, m.

    ``choose`` puts the robot down, seated, at x = 0 of another ground; ``place`` returns where it is, None if unknown.
    """

    grounds: Mapping[str, Sequence[tuple[float, float]]]
    choose: Callable[[str], None]
    place: Callable[[], Place | None]


@dataclass(frozen=True)
class Hardware:
    """A robot's hardware, none of it opened yet.

    ``put_back`` lifts a simulated robot and puts it down seated; a real one needs a person for that.
    ``turns``: the robot moves in space and its sensor measures its turning; in the plane it never turns.
    ``simulated``: no real robot moves. ``stage``: the grounds to choose from.
    """

    bus: Bus
    attitude: Attitude
    put_back: Callable[[], object] = lambda: None
    turns: bool = True
    simulated: bool = False
    stage: Stage | None = None


def real(robot: Robot, port: str | None, calibration: Path | None) -> Hardware:
    """Return the real robot's parts; joints simulated by ``caramelo joints sim`` count as real here.

    ``port``: a serial port, or INTERFACE:CHANNEL of CAN, instead of the robot file's own; ``calibration``: a file
    instead of the robot's own.
    """
    if robot.bus.kind == "none":
        raise UserError(f'{robot.name}: can only be simulated, not driven (bus.kind = "none")')
    if robot.bus.kind == "can":
        interface = (port or robot.bus.interface).partition(":")[0]
        elsewhere = interface in SIMULATED_INTERFACES
        imu = AbsentImu(ELSEWHERE) if elsewhere else open_source(robot, I2C)
        return Hardware(can_joints(robot, port), Attitude(robot, imu), simulated=elsewhere)
    from ..bus.dynamixel.bus import ServoBus
    from ..bus.dynamixel.calibration.data import default_path, load_calibration, servo_of
    from ..bus.dynamixel.link import serial_bus
    from ..bus.dynamixel.port import ServoPort

    servo_of(robot)
    data = load_calibration(calibration or default_path(robot), robot)
    own = serial_bus(robot)
    bus = ServoBus(robot, data, ServoPort(port or own.port, own.baud))
    return Hardware(bus, Attitude(robot, open_source(robot, I2C)))


def can_joints(robot: Robot, port: str | None) -> Bus:
    """Return the joints on CAN; ``port`` INTERFACE:CHANNEL overrides the robot file's own."""
    from ..bus.can.joints import CanJoints, new_session
    from ..bus.can.open import open_port

    assert robot.bus.kind == "can"
    interface, colon, channel = (port or "").partition(":")
    if port and not (colon and interface and channel):
        raise UserError(f"--port {port}: for joints on CAN give INTERFACE:CHANNEL, such as socketcan:can0")
    bus_port = open_port(robot.bus, interface or None, channel or None)
    return CanJoints(robot, bus_port, new_session(), seated_pose_rad(robot), threaded=True)
