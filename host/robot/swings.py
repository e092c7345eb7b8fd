"""The drive speeds that a foot's way through the air demands, and a search for the most that the drives can do."""

from collections.abc import Callable, Sequence
from itertools import pairwise

from shared.body.params import FL, RL

from .kinematics_si import Vector
from .model import Robot
from .poses import leg_to_rad

_HALVINGS = 16  # of a range: 1.5e-5 of it is left


def leg_of_each_shape(robot: Robot) -> tuple[int, ...]:
    """Return one leg of each shape: front left, and rear left if its knee bends the other way."""
    return (FL,) if robot.knee_sign(FL) == robot.knee_sign(RL) else (FL, RL)


def poses_rad(robot: Robot, leg: int, way_m: Sequence[tuple[float, float]]) -> list[Vector] | None:
    """Return the joints of a leg along a way of its foot, x ahead and z up of rest; None out of reach."""
    x, y, z = robot.foot_m(leg, robot.stance.rest_height_m)
    poses = []
    for ahead, up in way_m:
        pose = leg_to_rad(robot, leg, (x + ahead, y, z + up))
        if pose is None:
            return None
        poses.append(pose)
    return poses


def within_limits(robot: Robot, leg: int, poses: Sequence[Vector]) -> bool:
    """Return whether all joints stay within the limits of a leg."""
    limits = robot.joint_limits_rad(leg)
    return all(low <= q <= high for pose in poses for q, (low, high) in zip(pose, limits, strict=True))


def asked_speeds(robot: Robot, joints_rad: Sequence[Vector], time_s: float) -> Vector:
    """Return the largest speeds of hip, thigh and calf drive, of their no-load speeds, through poses at even times."""
    ratio, coupled = robot.calf_drive.ratio, robot.calf_drive.coupled
    poses = [(hip, thigh, (calf + thigh if coupled else calf) / ratio) for hip, thigh, calf in joints_rad]
    step_s = time_s / (len(poses) - 1)
    no_load = robot.actuator.fastest_rad_s * step_s
    hip, thigh, calf = (
        max(abs(after[joint] - before[joint]) for before, after in pairwise(poses)) / no_load
        for joint in range(3)
    )
    return hip, thigh, calf


def most(highest: float, can: Callable[[float], bool]) -> float:
    """Return the largest possible value within 0 .. ``highest``, where every value below a possible one is possible."""
    if can(highest):
        return highest
    low, high = 0.0, highest
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if can(middle) else (low, middle)
    return low
