"""New servos to try the set-up with, as they come out of their boxes: id 1 at 57600 baud, none plugged in."""

from collections.abc import Collection

from ...bus.dynamixel import table as t
from ...bus.dynamixel.calibration.data import nominal
from ...bus.dynamixel.link import Link
from ...robot.model import Robot
from ...robot.poses import seated_pose_rad
from ..plant import JointPlant
from .bus import EmulatedBus
from .loopback import LoopbackPort


def unpack(bus: EmulatedBus) -> None:
    """Make the servos of a bus new, and unplug them."""
    for servo in bus.servos:
        for register in t.REGISTERS.values():
            if register.eeprom and register is not t.PROTOCOL:
                servo.put(register, register.initial)
    plug(bus, ())


def plug(bus: EmulatedBus, joints: Collection[int]) -> None:
    """Plug in the servos of these joints and no others; power gone and back restarts a servo."""
    for joint, servo in enumerate(bus.servos):
        servo.missing = joint not in joints
        servo.reboot()


class Tray:
    """Twelve new servos and a port to plug them into. No real time passes."""

    def __init__(self, robot: Robot, protocol: float = 2.0) -> None:
        plant = JointPlant(robot, seated_pose_rad(robot))
        self.bus = EmulatedBus(robot, plant, nominal(robot), protocol)
        unpack(self.bus)
        self.link = Link(LoopbackPort(self.bus, lambda: 0.0), protocol)

    def plug(self, joint: int) -> None:
        """Plug in the servo of one joint alone."""
        plug(self.bus, (joint,))
