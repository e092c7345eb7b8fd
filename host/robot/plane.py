"""A robot file as the sagittal plane sees it: the host's Robot turned into sim2d's PlanarRobot."""

from math import pi

from sim2d.model import Link, PlanarRobot, SensorModel, ServoModel

from .drives import joint_drives
from .model import Link as RobotLink
from .model import Robot
from .poses import rest_pose_rad


def planar_robot(robot: Robot, foot_friction: float | None = None) -> PlanarRobot:
    """Return the plane's robot, with its own foot friction or another.

    The plane has one pair of limits per kind of joint: the widest of all legs; the planner holds the
    legs' own.
    """
    _, thigh_servo, calf_servo = joint_drives(robot)
    links, hips = robot.links, [robot.hip_m(leg)[0] for leg in range(4)]
    limits = [robot.joint_limits_rad(leg) for leg in range(4)]
    return PlanarRobot(
        name=robot.name,
        torso=_link(links.trunk),
        hip_mass_kg=links.hip.mass_kg,
        thigh=_link(links.thigh),
        calf=_link(links.calf),
        hip_x_m=(hips[0], hips[1], hips[2], hips[3]),
        thigh_length_m=robot.geometry.thigh_m,
        calf_length_m=robot.geometry.calf_m,
        thigh_limits_rad=(min(leg[1][0] for leg in limits), max(leg[1][1] for leg in limits)),
        calf_limits_rad=(min(leg[2][0] for leg in limits), max(leg[2][1] for leg in limits)),
        thigh_servo=thigh_servo,
        calf_servo=calf_servo,
        stand_pose_rad=tuple(rest_pose_rad(robot)),
        calf_on_torso=robot.calf_drive.coupled,
        foot_radius_m=robot.geometry.foot_radius_m,
        foot_friction=robot.geometry.foot_friction if foot_friction is None else foot_friction,
        torso_half_length_m=links.trunk.size_m[0] / 2,
        torso_half_height_m=links.trunk.size_m[2] / 2,
        payload_height_m=links.trunk.payload_m[2],
        sensors=SensorModel(encoder_counts_per_turn=4096, pitch_noise_rad=0.1 * pi / 180),
    )


def _link(link: RobotLink) -> Link:
    return Link(link.mass_kg, link.inertia_kg_m2[1], link.com_m[0], link.com_m[2])


def drives(plane: PlanarRobot, voltage_V: float | None) -> tuple[ServoModel, ServoModel, ServoModel]:
    """Return the drives of hip, thigh and calf, seen from their joints, at a supply voltage; None: the nominal one."""
    volts = plane.thigh_servo.nominal_voltage_V if voltage_V is None else voltage_V
    thigh = plane.thigh_servo.at_voltage(volts)
    return thigh, thigh, plane.calf_servo.at_voltage(volts)
