"""Poses of a robot's legs by where their feet are, and of the whole robot with its feet at rest: standing, seated."""

from ..util.errors import UserError
from .kinematics_si import Vector, leg_inverse
from .model import Robot


def leg_to_rad(robot: Robot, leg: int, foot_m: Vector) -> Vector | None:
    """Return hip, thigh and calf with which the foot is there, from the hip's axis; None out of reach."""
    return leg_inverse(robot.geometry.links_m, robot.side(leg), robot.knee_sign(leg), foot_m)


def leg_pose_rad(robot: Robot, leg: int, height_m: float) -> Vector:
    """Return hip, thigh and calf of a leg, its foot at rest, the hips ``height_m`` above it. UserError if too far."""
    pose = leg_to_rad(robot, leg, robot.foot_m(leg, height_m))
    if pose is None:
        raise UserError(f"{robot.name}: a height of {height_m:g} m is out of reach of leg {leg}")
    return pose


def rest_pose_rad(robot: Robot) -> list[float]:
    """Return the twelve angles at rest; the loader has checked that they exist."""
    return [angle for leg in range(4) for angle in leg_pose_rad(robot, leg, robot.stance.rest_height_m)]


def seated_pose_rad(robot: Robot) -> list[float]:
    """Return the twelve angles in which a robot waits: seated."""
    return [angle for leg in range(4) for angle in leg_pose_rad(robot, leg, robot.stance.sit_height_m)]
