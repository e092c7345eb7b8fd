"""Poses of single legs from their feet's places, and of the whole robot with its feet at rest: standing, seated."""

from ..util.errors import UserError
from .kinematics_si import Vector, leg_forward, leg_inverse
from .model import Robot

FOLDS = 24  # angles of a joint to try for folding: steps of 6 deg at most


def leg_to_rad(robot: Robot, leg: int, foot_m: Vector) -> Vector | None:
    """Return hip, thigh and calf that put the foot there, seen from the hip's axis; None out of reach."""
    return leg_inverse(robot.geometry.links_m, robot.side(leg), robot.knee_sign(leg), foot_m)


def leg_pose_rad(robot: Robot, leg: int, height_m: float) -> Vector:
    """Return hip, thigh and calf of a leg with its foot at rest, ``height_m`` below the hips. UserError if too far."""
    pose = leg_to_rad(robot, leg, robot.foot_m(leg, height_m))
    if pose is None:
        raise UserError(f"{robot.name}: leg {leg} can't stand at a height of {height_m:g} m")
    return pose


def rest_pose_rad(robot: Robot) -> list[float]:
    """Return the twelve angles at rest; the loader has checked that they exist."""
    return [angle for leg in range(4) for angle in leg_pose_rad(robot, leg, robot.stance.rest_height_m)]


def seated_pose_rad(robot: Robot) -> list[float]:
    """Return the twelve angles in which a robot waits: seated."""
    return [angle for leg in range(4) for angle in leg_pose_rad(robot, leg, robot.stance.sit_height_m)]


def folded_leg_rad(robot: Robot, leg: int) -> Vector:
    """Return the joints of a leg folded beside a robot that lies on its belly.

    The hip is as far out as it goes. Thigh and calf are the angles of a grid that bring the foot nearest its place at
    rest along the body, but no lower than the belly: there it would lift the robot.
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
