"""The robot's values after a tick, as plain numbers."""

from dataclasses import dataclass, field

from ..bus.base import NEVER, UNKNOWN
from ..control.odometry import Odometry
from ..robot.model import JOINT_NAMES as _JOINTS
from ..robot.model import LEG_NAMES as _LEGS

LEG_NAMES = _LEGS
JOINT_NAMES = tuple(f"{leg}_{joint}" for leg in LEG_NAMES for joint in _JOINTS)


@dataclass(frozen=True)
class Sensed:
    """One tick. Lists of twelve are in the order of ``JOINT_NAMES``; lists of four in that of ``LEG_NAMES``.

    ``state``: disarmed, standing up, standing, walking, crawling, lifted, sitting or fault. ``fault``: why the robot
    stopped by itself or was stopped, "" if it was not. ``remark``: other remarks, such as a pose out of
    reach. ``load``: each joint's share of its stall torque, -1 .. 1. ``age_s``: how old position, speed and load are,
    inf for a joint that never answered. ``attitude_rad``: roll and pitch, ``rates_rad_s``: turning speeds about x, y
    and z; None while they are not known. ``swinging``: the legs that are planned to be in the air.
    """

    time_s: float = 0.0
    state: str = "disarmed"
    fault: str = ""
    remark: str = ""
    joints_rad: tuple[float, ...] = UNKNOWN
    speed_rad_s: tuple[float, ...] = UNKNOWN
    goals_rad: tuple[float, ...] = UNKNOWN
    load: tuple[float, ...] = UNKNOWN
    age_s: tuple[float, ...] = NEVER
    attitude_rad: tuple[float, float] | None = None
    rates_rad_s: tuple[float, float, float] | None = None
    swinging: tuple[bool, ...] = (False,) * 4
    temperature_C: tuple[float, ...] = UNKNOWN
    battery_V: float | None = None
    odometry: Odometry = field(default_factory=Odometry)
