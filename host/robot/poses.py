"""Poses of a robot's legs by where their feet are, and of the whole robot with its feet at rest: standing, seated."""

from ..util.errors import UserError
from .kinematics_si import Vector, leg_forward, leg_inverse
from .model import Robot

FOLDS = 24  # angles of a joint that are looked at for folding: steps of 6 deg at most


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


def folded_leg_rad(robot: Robot, leg: int) -> Vector:
    """Return the joints of a leg folded beside a robot that lies on its belly.

    The hip is as far out as it goes; of a grid of thigh and calf angles those that bring the foot nearest to where it
    is at rest along the body, no lower than the belly, where it would lift the robot.
    """
    belly_m = robot.geometry.foot_radius_m - robot.links.trunk.size_m[2] / 2
    rest_m = robot.foot_m(leg, robot.stance.sit_height_m)[0]
    hips, thighs, calves = robot.joint_limits_rad(leg)
    links_m, side = robot.geometry.links_m, robot.side(leg)
    hip = hips[1] if side > 0 else hips[0]

    def off_m(pose: Vector) -> float:
        x_m, _, z_m = leg_forward(links_m, side, pose)
        return abs(x_m - rest_m) + abs(z_m - belly_m) + FOLDS * max(0.0, belly_m - z_m)

    return min(((hip, thigh, calf) for thigh in _between(*thighs) for calf in _between(*calves)), key=off_m)


def _between(low: float, high: float) -> list[float]:
    """Return evenly spaced angles from the lowest to the highest."""
    return [low + (high - low) * i / (FOLDS - 1) for i in range(FOLDS)]
