"""Where the robot's mass lies in its rest stance, from the links of its file."""

from math import cos, sin

from .kinematics_si import Vector, leg_inverse
from .model import Link, Robot


def com_at_rest_m(robot: Robot) -> Vector:
    """Return the centre of mass in the body frame at rest, m; legs out of reach count as straight down."""
    parts = [(robot.links.trunk.mass_kg, robot.links.trunk.com_m)]
    for leg in range(4):
        side, knee = robot.side(leg), robot.knee_sign(leg)
        pose = leg_inverse(robot.geometry.links_m, side, knee, robot.foot_m(leg, robot.stance.rest_height_m))
        parts += leg_parts(robot, leg, pose or (0.0, 0.0, 0.0))
    mass = sum(part[0] for part in parts)
    x, y, z = (sum(part[0] * part[1][axis] for part in parts) / mass for axis in range(3))
    return x, y, z


def leg_parts(robot: Robot, leg: int, joints_rad: Vector) -> list[tuple[float, Vector]]:
    """Return mass and centre, in the body, of hip, thigh and calf; the files' links are a left elbow leg's."""
    side, knee = robot.side(leg), robot.knee_sign(leg)
    hip, thigh, calf = joints_rad
    l1, l2, _ = robot.geometry.links_m
    knee_at = -l2 * sin(thigh), -l2 * cos(thigh)
    links = robot.links
    places = ((links.hip, 0.0, (0.0, 0.0)), (links.thigh, thigh, (0.0, 0.0)), (links.calf, thigh + calf, knee_at))
    hip_x, hip_y = robot.hip_m(leg)
    parts = []
    for number, (link, angle, origin) in enumerate(places):
        x, down = _turned(link, knee, angle)
        out = side * (link.com_m[1] + (l1 if number else 0.0))
        x, down = origin[0] + x, origin[1] + down
        parts.append(
            (link.mass_kg, (hip_x + x, hip_y + out * cos(hip) - down * sin(hip), out * sin(hip) + down * cos(hip)))
        )
    return parts


def _turned(link: Link, knee: int, angle_rad: float) -> tuple[float, float]:
    """Return x and z of a link's centre from its upper joint, turned about y; x is mirrored for knee legs."""
    x, z = -knee * link.com_m[0], link.com_m[2]
    return x * cos(angle_rad) + z * sin(angle_rad), -x * sin(angle_rad) + z * cos(angle_rad)
