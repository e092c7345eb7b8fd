"""The library's names, each available as `from caramelo import NAME` (docs/python.md)."""

from host.boards.core import use_core

use_core()  # before anything of the core is imported

from host.control.health import Finding  # noqa: E402
from host.control.odometry import Odometry  # noqa: E402
from host.library.errors import BadValue, Error, Fault, NotAchieved  # noqa: E402
from host.library.robot import Robot  # noqa: E402
from host.library.sensed import JOINT_NAMES, LEG_NAMES, Sensed  # noqa: E402
from host.robot.file import find as robot_path  # noqa: E402
from host.robot.file import robot_names  # noqa: E402

__all__ = [
    "JOINT_NAMES",
    "LEG_NAMES",
    "BadValue",
    "Error",
    "Fault",
    "Finding",
    "NotAchieved",
    "Odometry",
    "Robot",
    "Sensed",
    "robot_names",
    "robot_path",
]
