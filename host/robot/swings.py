"""What the way of a foot in the air asks of the drives' speeds, and the most of something that they can do."""

from collections.abc import Callable, Sequence
from itertools import pairwise

from .kinematics_si import Vector, leg_inverse
from .model import Robot

_HALVINGS = 16  # of a range: 1.5e-5 of it is left


def asked_speeds(robot: Robot, way_m: Sequence[tuple[float, float]], time_s: float) -> Vector | None:
    """Return the largest speeds of hip, thigh and calf drive, of their no-load speeds; None beyond reach or limits.

    ``way_m``: x ahead and z up of the foot's rest, at even times over ``time_s``, of a front left leg.
    """
    leg, ratio = 1, robot.calf_drive.ratio
    x, y, z = robot.foot_m(leg, robot.stance.rest_height_m)
    limits, poses = robot.joint_limits_rad(leg), []
    for ahead, up in way_m:
        foot_m = x + ahead, y, z + up
        pose = leg_inverse(robot.geometry.links_m, robot.side(leg), robot.knee_sign(leg), foot_m)
        if pose is None or any(not low <= q <= high for q, (low, high) in zip(pose, limits, strict=True)):
            return None
        hip, thigh, calf = pose
        poses.append((hip, thigh, (calf + thigh if robot.calf_drive.coupled else calf) / ratio))
    step_s = time_s / (len(poses) - 1)
    no_load = robot.actuator.fastest_rad_s * step_s
    hip, thigh, calf = (
        max(abs(after[joint] - before[joint]) for before, after in pairwise(poses)) / no_load
        for joint in range(3)
    )
    return hip, thigh, calf


def most(highest: float, can: Callable[[float], bool]) -> float:
    """Return the largest value within 0 .. ``highest`` that can be done; what more of cannot, less may."""
    if can(highest):
        return highest
    low, high = 0.0, highest
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if can(middle) else (low, middle)
    return low
