"""What has axes: x forward, y left, z up, and turns about them (ROS REP 103)."""

from ..record import Axes, field, record
from ..runtime import const

POSE_AXES = const(6)


@record
class Pose(Axes):
    """Where a body is in a frame, in the core's units or, where it is said so, in others. It turns as pose.py says."""

    x: int = field("lu", "forward")
    y: int = field("lu", "left")
    z: int = field("lu", "up")
    roll: int = field("brad", "about x")
    pitch: int = field("brad", "about y: nose down")
    yaw: int = field("brad", "about z: to the left")
