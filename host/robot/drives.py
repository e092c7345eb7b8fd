"""A robot's motor drives as linear laws seen from their joints: stall torque, stiffness, damping, armature."""

from math import pi

from sim2d.model import ServoModel

from .actuators import Bldc, PdJoint, Servo
from .model import Robot

STIFFNESS_KEYS = {  # by kind of actuator: the key that makes its joints stiffer
    "servo": "actuator.duty_per_rad",
    "bldc": "actuator.drive.position_bandwidth_hz",
    "pd": "actuator.stiffness_Nm_rad",
}


def joint_drives(robot: Robot) -> tuple[ServoModel, ServoModel, ServoModel]:
    """Return the drives of hip, thigh and calf as linear laws seen from their joints."""
    drive, ratio = robot.actuator, robot.calf_drive.ratio
    if isinstance(drive, Servo):
        return servo_model(drive, 1.0), servo_model(drive, 1.0), servo_model(drive, ratio)
    if isinstance(drive, PdJoint):
        return pd_model(drive, 1.0), pd_model(drive, 1.0), pd_model(drive, ratio)
    return joint_model(drive, 1.0), joint_model(drive, 1.0), joint_model(drive, ratio)


def servo_model(servo: Servo, ratio: float) -> ServoModel:
    """Return a servo behind a rod that turns the joint ``ratio`` times as far.

    Torque at the joint is the motor's divided by the ratio, stiffness and damping by its square.
    """
    nominal = servo.nominal
    return ServoModel(
        stall_torque_Nm=nominal.stall_Nm / ratio,
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
    """Return the linear law of a brushless joint in impedance mode, a spring (joint_gains.impedance_gains).

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
        speed_loop=True,
    )


def pd_model(drive: PdJoint, ratio: float) -> ServoModel:
    """Return a foreign joint behind a belt or rod that turns the joint ``ratio`` times as far.

    Its stiffness and damping are given at the joint itself.
    """
    return ServoModel(
        stall_torque_Nm=drive.torque_Nm / ratio,
        stiffness_Nm_rad=drive.stiffness_Nm_rad,
        damping_Nms_rad=drive.damping_Nms_rad,
        armature_kgm2=drive.armature_kg_m2 / ratio**2,
        coulomb_Nm=drive.coulomb_Nm / ratio,
        nominal_voltage_V=drive.voltage_V,
        speed_loop=True,
    )


def friction_bands(robot: Robot) -> tuple[tuple[float, float, float], float]:
    """Return how far friction holds hip, thigh and calf back as they turn: unloaded, rad, and per sag under a load.

    A motor that turns a load L gives (L (1 + l) + f) / (1 - m) where it goes against it and (L (1 - l) - f) / (1 + m)
    where it goes with it, by M6 (arXiv 2410.08650) once Stribeck has faded: f is dry, m and l are the shares of motor
    and load. Half of their difference is (f + (m + l) L) / (1 - m^2). A servo's stall torque is its data sheet's,
    behind the friction at rest.
    """
    drive, behind = robot.actuator, 1.0
    motor = load = 0.0
    if isinstance(drive, Servo):
        dry_Nm, motor, load = drive.coulomb_Nm, drive.friction.load_motor, drive.friction.load_external
        behind -= motor + drive.friction.load_motor_stribeck
    elif isinstance(drive, Bldc):
        dry_Nm, motor = drive.motor.coulomb_Nm * drive.gear.ratio, 1.0 - drive.gear.efficiency
    else:
        dry_Nm = drive.coulomb_Nm
    share = behind / (1.0 - motor**2)
    hip, thigh, calf = (dry_Nm / ratio * share / joint.stiffness_Nm_rad
                        for ratio, joint in zip((1.0, 1.0, robot.calf_drive.ratio), joint_drives(robot), strict=True))
    return (hip, thigh, calf), (motor + load) * share
