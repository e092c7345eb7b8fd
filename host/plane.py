"""A robot file as the sagittal plane sees it: the host's Robot turned into sim2d's PlanarRobot."""

from math import pi

from sim2d.model import Link, PlanarRobot, SensorModel, ServoModel

from .errors import UserError
from .kinematics_si import leg_inverse
from .robot_actuators import Bldc, Servo
from .robot_model import Link as RobotLink
from .robot_model import Robot


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
        stand_pose_rad=tuple(angle for leg in range(4) for angle in rest_pose_rad(robot, leg)),
        calf_on_torso=robot.calf_drive.coupled,
        foot_radius_m=robot.geometry.foot_radius_m,
        foot_friction=robot.geometry.foot_friction if foot_friction is None else foot_friction,
        torso_half_length_m=links.trunk.size_m[0] / 2,
        torso_half_height_m=links.trunk.size_m[2] / 2,
        payload_height_m=links.trunk.payload_m[2],
        sensors=SensorModel(encoder_counts_per_turn=4096, pitch_noise_rad=0.1 * pi / 180),
    )


def rest_pose_rad(robot: Robot, leg: int) -> tuple[float, float, float]:
    """Return hip, thigh and calf of a leg at rest; the loader has checked that they exist."""
    foot_m = robot.foot_m(leg, robot.stance.rest_height_m)
    pose = leg_inverse(robot.geometry.links_m, robot.side(leg), robot.knee_sign(leg), foot_m)
    if pose is None:
        raise UserError(f"{robot.name}: the rest stance is out of reach of leg {leg}")
    return pose


def _link(link: RobotLink) -> Link:
    return Link(link.mass_kg, link.inertia_kg_m2[1], link.com_m[0], link.com_m[2])


def joint_drives(robot: Robot) -> tuple[ServoModel, ServoModel, ServoModel]:
    """Return the drives of hip, thigh and calf as linear laws seen from their joints."""
    drive, ratio = robot.actuator, robot.calf_drive.ratio
    if isinstance(drive, Servo):
        return servo_model(drive, 1.0), servo_model(drive, 1.0), servo_model(drive, ratio)
    return joint_model(drive, 1.0), joint_model(drive, 1.0), joint_model(drive, ratio)


def servo_model(servo: Servo, joint_per_motor: float) -> ServoModel:
    """Return a servo behind a rod that turns the joint ``joint_per_motor`` times as far.

    Torque at the joint is the motor's divided by the ratio, stiffness and damping by its square.
    """
    nominal, ratio = servo.nominal, joint_per_motor
    stall_Nm = nominal.stall_Nm / ratio
    return ServoModel(
        stall_torque_Nm=stall_Nm,
        stiffness_Nm_rad=nominal.stall_Nm * servo.duty_per_rad / ratio**2,
        damping_Nms_rad=nominal.stall_Nm / nominal.no_load_rad_s / ratio**2,
        armature_kgm2=servo.armature_kg_m2 / ratio**2,
        coulomb_Nm=servo.coulomb_Nm / ratio,
        nominal_voltage_V=nominal.voltage_V,
        voltage_points=tuple(
            (point.voltage_V, point.stall_Nm / nominal.stall_Nm, point.no_load_rpm / nominal.no_load_rpm)
            for point in servo.supply
        ),
    )


def joint_model(drive: Bldc, joint_per_motor: float) -> ServoModel:
    """Return a brushless joint's position loop as the plane's linear law, until its own loops drive it.

    Stiffness from the position and velocity bandwidths acting on the rotor's inertia seen at the
    joint; torque limited by the current limit; damping by the velocity loop.
    """
    ratio = drive.gear.ratio / joint_per_motor
    inertia = drive.motor.rotor_inertia_kg_m2 * ratio**2
    velocity_rad_s = 2 * pi * drive.drive.velocity_bandwidth_hz
    position_rad_s = 2 * pi * drive.drive.position_bandwidth_hz
    damping = inertia * velocity_rad_s
    return ServoModel(
        stall_torque_Nm=drive.torque_limit_Nm / joint_per_motor * drive.gear.efficiency,
        stiffness_Nm_rad=damping * position_rad_s,
        damping_Nms_rad=damping,
        armature_kgm2=inertia,
        coulomb_Nm=drive.motor.coulomb_Nm * ratio,
        nominal_voltage_V=drive.drive.bus_voltage_V,
    )
