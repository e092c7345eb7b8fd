"""Where the robot's mass lies in its rest stance, from the links of its file."""

from math import cos, sin

from .kinematics_si import Vector
from .model import Link, Robot
from .poses import leg_to_rad


def com_at_rest_m(robot: Robot) -> Vector:
    """Return the centre of mass in the body frame at rest, m; legs out of reach count as straight down."""
    parts = [(robot.links.trunk.mass_kg, robot.links.trunk.com_m)]
    for leg in range(4):
        parts += leg_parts(robot, leg, rest_leg_rad(robot, leg))
    mass = sum(part[0] for part in parts)
    x, y, z = (sum(part[0] * part[1][axis] for part in parts) / mass for axis in range(3))
    return x, y, z


def rest_leg_rad(robot: Robot, leg: int) -> Vector:
    """Return hip, thigh and calf of a leg at rest, straight down if its foot is out of reach."""
    return leg_to_rad(robot, leg, robot.foot_m(leg, robot.stance.rest_height_m)) or (0.0, 0.0, 0.0)


def leg_inertia_kg_m2(robot: Robot) -> tuple[float, float, float]:
    """Return the inertia that the drives of hip, thigh and calf turn in a raised leg at rest, kg m2 about their axes.

    A thigh moves the calf along as it is bent; if the calf's motor sits on the body and holds it (paper B), the thigh
    only moves the calf's mass at the knee.
    """
    geometry, links = robot.geometry, robot.links
    pose = rest_leg_rad(robot, 0)
    _, thigh_rad, calf_rad = pose
    calf = _about_joint(links.calf)
    thigh = _about_joint(links.thigh)
    if robot.calf_drive.coupled:
        thigh += links.calf.mass_kg * geometry.thigh_m**2
    else:
        knee_x, knee_z = -geometry.thigh_m * sin(thigh_rad), -geometry.thigh_m * cos(thigh_rad)
        x, z = _turned(links.calf, robot.knee_sign(0), thigh_rad + calf_rad)
        thigh += links.calf.inertia_kg_m2[1] + links.calf.mass_kg * ((knee_x + x) ** 2 + (knee_z + z) ** 2)
    hip = links.hip.inertia_kg_m2[0] + links.thigh.inertia_kg_m2[0] + links.calf.inertia_kg_m2[0]
    hip_y = robot.hip_m(0)[1]
    for mass_kg, (_, y, z) in leg_parts(robot, 0, pose):
        hip += mass_kg * ((y - hip_y) ** 2 + z**2)
    return hip, thigh, calf


def _about_joint(link: Link) -> float:
    """Return a thigh's or calf's moment about its upper joint's axis, y, kg m2: parallel-axis theorem."""
    x, _, z = link.com_m
    return link.inertia_kg_m2[1] + link.mass_kg * (x**2 + z**2)


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
