"""Converts SI into the core's integers and back; nothing else does.

A ``Scale`` belongs to one robot at one planner rate: the length unit is the robot's own
(2^-length_shift m), speeds are per tick. Angles are 1/65536 turn everywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, degrees, floor, isqrt, pi, sqrt

from shared.body.params import LEGS, LF_BITS, Params
from shared.record import pack
from shared.sense.attitude import Attitude, attitude_reset
from sim2d.model import GRAVITY_M_S2

from ..util.errors import UserError
from .crawl_tuning import fill_crawl
from .drives import STIFFNESS_KEYS, joint_drives
from .mass import com_at_rest_m
from .model import JOINT_NAMES, Robot
from .poses import folded_leg_rad
from .statics import push_on_two_N, torques_Nm
from .trot_tuning import fill_trot

BRAD_PER_RAD = 65536 / (2 * pi)
Q8, Q10, Q12, Q15, Q16, Q30 = 1 << 8, 1 << 10, 1 << 12, 1 << 15, 1 << 16, 1 << 30
YAW18 = 1 << 18
# Limits of the core's fields, from the docstrings of shared/gait/steps.py and shared/num/pid.py.
LARGEST_SPEED = (1 << 19) - 1
LARGEST_GAIN = (1 << 15) - 1

# Readings of a sensor at rest differ less than this: ten times an MPU6050's noise (product specification 3.4, 6.1, 6.2)
REST_DEG_S, REST_G = 0.5, 0.027
FALLEN_S = 0.1  # a robot tilted for this long has fallen
AVERAGE_S = 0.2  # time over which the odometry's speeds and the felt weight are averaged (chosen)
FASTEST_TILT_RAD_S = 10.0  # of a falling body (one that tips over on a leg of 0.24 m ends at 9)


def brad(angle_rad: float) -> int:
    """Return an angle in 1/65536 turn, not wrapped."""
    return round(angle_rad * BRAD_PER_RAD)


def rad(angle_brad: int) -> float:
    """Return an angle in rad."""
    return angle_brad / BRAD_PER_RAD


@dataclass(frozen=True)
class Scale:
    """Conversions of one robot at one planner rate."""

    length_shift: int
    rate_hz: int

    def lu(self, length_m: float) -> int:
        """Return a length in length units."""
        return round(length_m * (1 << self.length_shift))

    def metres(self, length_lu: float) -> float:
        """Return length units in m."""
        return length_lu / (1 << self.length_shift)

    def lf_per_tick(self, speed_m_s: float) -> int:
        """Return a speed in 1/256 length units per tick."""
        return round(speed_m_s * (1 << (self.length_shift + LF_BITS)) / self.rate_hz)

    def metres_per_second(self, speed_lf_per_tick: float) -> float:
        """Return a speed in m/s."""
        return speed_lf_per_tick * self.rate_hz / (1 << (self.length_shift + LF_BITS))

    def yaw18_per_tick(self, turn_rad_s: float) -> int:
        """Return a turning speed in 2^-18 rad per tick."""
        return round(turn_rad_s * YAW18 / self.rate_hz)

    def rad_per_second(self, turn_yaw18_per_tick: float) -> float:
        """Return a turning speed in rad/s."""
        return turn_yaw18_per_tick * self.rate_hz / YAW18


def scale_of(robot: Robot, rate_hz: int | None = None) -> Scale:
    """Return the robot's scale at its own rate, or at another."""
    return Scale(robot.length_shift, robot.control.rate_hz if rate_hz is None else rate_hz)


def core_params(robot: Robot, rate_hz: int | None = None, planar: bool = False) -> Params:
    """Return the robot as the core's integers (shared/body/params.py); ``planar``: it neither sways nor turns.

    The loader has checked that its speeds and gains fit (checks.py). UserError if its joints are too soft.
    """
    scale = scale_of(robot, rate_hz)
    params = Params()
    params.rate_hz = scale.rate_hz
    params.average_q10 = floor(1024 / (1 + AVERAGE_S * scale.rate_hz))
    params.length_shift = scale.length_shift
    _speeds(params, robot, scale)
    _pose_limits(params, robot, scale)
    _balance(params, robot, scale.rate_hz)
    params.joint_speed_slow = max(1, floor(robot.stand.joint_rad_s * BRAD_PER_RAD / scale.rate_hz))
    params.sit_z = -scale.lu(robot.stance.sit_height_m)
    params.stride_max = scale.lu(robot.speed_limits.stride_m)
    _joint_speeds(params, robot, scale.rate_hz)
    for leg in range(LEGS):
        _leg(params, robot, scale, leg)
    _compliance(params, robot, scale)
    params.tilt_max, params.tilt_ticks = brad(robot.gait.fallen_rad), max(1, round(FALLEN_S * scale.rate_hz))
    fill_crawl(params, robot)
    fill_trot(params, robot)
    if planar:
        params.lateral_q12 = params.trot.heading_kp_q16 = 0
    return params


def _speeds(params: Params, robot: Robot, scale: Scale) -> None:
    limits = robot.speed_limits
    integers = (scale.lf_per_tick, scale.lf_per_tick, scale.yaw18_per_tick)
    for axis, (key, integer) in enumerate(zip(("vx_m_s", "vy_m_s", "wz_rad_s"), integers, strict=True)):
        params.speed_max[axis] = max(1, integer(getattr(limits, key)))
        params.speed_slew[axis] = max(1, integer(getattr(limits, f"{key}2") / scale.rate_hz))


def _pose_limits(params: Params, robot: Robot, scale: Scale) -> None:
    limits = robot.body_limits
    for axis, length_m in enumerate((limits.x_m, limits.y_m, limits.z_m)):
        params.pose_max[axis] = scale.lu(length_m)
        params.pose_slew[axis] = max(1, scale.lu(limits.shift_m_s / scale.rate_hz))
    for axis, angle_rad in enumerate(limits.angles_rad):
        params.pose_max[3 + axis] = brad(angle_rad)
        params.pose_slew[3 + axis] = max(1, brad(limits.turn_rad_s / scale.rate_hz))


def _balance(params: Params, robot: Robot, rate_hz: int) -> None:
    """Fill in the balance: gains in the form of shared/num/pid.py, and limits."""
    balance = robot.balance
    params.gains.kp_q12 = round(balance.kp * Q12)
    params.gains.ki_q16 = round(balance.ki_1_s / rate_hz * Q16)
    params.gains.kd_q10 = round(balance.kd_s * rate_hz * Q10)
    params.integral_max = brad(balance.integral_limit_rad)
    params.balance_max = brad(balance.output_limit_rad)


def _joint_speeds(params: Params, robot: Robot, rate_hz: int) -> None:
    """Fill in how fast goals may move, and how far a reading may be from the previous one.

    A joint pushed from outside turns faster than its motor does, and a bus may be late by a tick: so twice as far.
    """
    motor_rad_s, ratio = robot.actuator.fastest_rad_s, robot.calf_drive.ratio
    for joint, times in enumerate((1.0, 1.0, ratio)):
        params.joint_speed_max[joint] = _brad_step(motor_rad_s * times, 1 / rate_hz)
    params.joint_speed_safe = min(pack(params.joint_speed_max)) >> int(robot.calf_drive.coupled)
    calf_rad_s = motor_rad_s * (ratio + robot.calf_drive.coupled)
    params.read_step = _brad_step(2 * max(motor_rad_s, calf_rad_s), max(1 / rate_hz, robot.bus.delay_s))
    params.tilt_step = _brad_step(FASTEST_TILT_RAD_S, max(1 / rate_hz, robot.bus.delay_s))


def _brad_step(speed_rad_s: float, time_s: float) -> int:
    """Return how far a speed leads in a time, 1 .. 32767 brad."""
    return min(32767, max(1, floor(speed_rad_s * time_s * BRAD_PER_RAD)))


def _leg(params: Params, robot: Robot, scale: Scale, leg: int) -> None:
    base = params.legs[leg]
    l1, l2, l3 = (scale.lu(length_m) for length_m in robot.geometry.links_m)
    base.hip_length = robot.side(leg) * l1
    base.thigh_length = l2
    base.calf_length = l3
    base.knee = robot.knee_sign(leg)
    base.outer_sq = (l2 + l3) ** 2
    base.inner_sq = (l2 - l3) ** 2
    base.half_diff = (l2 * l2 - l3 * l3) // 2
    base.longest = isqrt(l1 * l1 + (l2 + l3) ** 2)
    base.shortest = ceil(sqrt(l1 * l1 + (l2 - l3) ** 2))
    for joint, (low_rad, high_rad) in enumerate(robot.joint_limits_rad(leg)):
        base.lowest[joint] = ceil(low_rad * BRAD_PER_RAD)
        base.highest[joint] = floor(high_rad * BRAD_PER_RAD)
    for joint, angle_rad in enumerate(folded_leg_rad(robot, leg)):
        base.folded[joint] = min(max(brad(angle_rad), base.lowest[joint]), base.highest[joint])
    hip_m = (*robot.hip_m(leg), 0.0)
    foot_m = robot.foot_m(leg, robot.stance.rest_height_m)
    for axis in range(3):
        base.hip[axis] = scale.lu(hip_m[axis])
        base.rest[axis] = scale.lu(hip_m[axis]) + scale.lu(foot_m[axis])


def _compliance(params: Params, robot: Robot, scale: Scale) -> None:
    """Fill in how far the joints sag under load, in own weights, and where the mass lies."""
    if robot.gait.sag_compensation > most_sag_compensation(robot):
        raise UserError(_too_soft(robot))
    weight_N, stiffnesses = robot.mass_kg * GRAVITY_M_S2, _stiffnesses(robot)
    for joint, (drive, stiffness) in enumerate(zip(joint_drives(robot), stiffnesses, strict=True)):
        damping = drive.damping_Nms_rad / weight_N * (1 << scale.length_shift) / BRAD_PER_RAD * scale.rate_hz
        params.sag_q16[joint] = round(robot.gait.sag_compensation / stiffness * Q16)
        params.stiff_q8[joint] = min(LARGEST_GAIN, round(stiffness * Q8))
        params.damp_q8[joint] = min(LARGEST_GAIN, round(damping * Q8))
    params.coupled = int(robot.calf_drive.coupled)
    com_m = com_at_rest_m(robot)
    params.com_x, params.com_y = scale.lu(com_m[0]), scale.lu(com_m[1])
    params.foot_radius = scale.lu(robot.geometry.foot_radius_m)
    params.delay_ticks = min(15, 1 + floor(robot.bus.delay_s * scale.rate_hz + 1e-9))
    params.leg_length = params.legs[0].thigh_length + params.legs[0].calf_length
    params.lateral_q12 = round(robot.gait.lateral_shift * Q12)


def most_sag_compensation(robot: Robot) -> float:
    """Return the largest gait.sag_compensation that the core's integers hold; the softest joint limits it."""
    return min(_stiffnesses(robot)) * LARGEST_GAIN / Q16


def _stiffnesses(robot: Robot) -> list[float]:
    """Return the stiffness of hip, thigh and calf, in own weights times length units per brad."""
    weight_N, units = robot.mass_kg * GRAVITY_M_S2, 1 << robot.length_shift
    return [drive.stiffness_Nm_rad / weight_N * units / BRAD_PER_RAD for drive in joint_drives(robot)]


def _too_soft(robot: Robot) -> str:
    """Return how the softest joint sags while its leg carries half of the robot, and how much can be compensated."""
    stiffnesses, most = _stiffnesses(robot), most_sag_compensation(robot)
    joint = min(range(len(stiffnesses)), key=stiffnesses.__getitem__)
    drive, value = joint_drives(robot)[joint], robot.gait.sag_compensation
    torque_Nm = abs(torques_Nm(robot, 0, push_on_two_N(robot))[joint])
    sag_deg, share = degrees(torque_Nm / drive.stiffness_Nm_rad), 100 * torque_Nm / drive.stall_torque_Nm
    stiffer = STIFFNESS_KEYS[robot.actuator.kind]
    return (
        f"gait.sag_compensation: value {value:g}: allowed: at most {floor(100 * most) / 100:.2f}: "
        f"the {JOINT_NAMES[joint]} is too soft for {robot.mass_kg:.3g} kg; with half of it on one leg it sags by "
        f"{sag_deg:.1f} deg at {share:.0f} % of its stall torque; a stiffer drive ({stiffer}) or a lighter robot "
        f"allows more"
    )


def attitude_block(robot: Robot, rate_hz: int | None = None) -> Attitude:
    """Return a new attitude filter (shared/sense/attitude.py) with the robot's IMU scales."""
    rate = robot.control.rate_hz if rate_hz is None else rate_hz
    imu = robot.imu
    block = Attitude()
    block.gyro_q30 = round(pi / 180 / imu.gyro_counts_per_deg_s / rate * Q30)
    block.one_g = imu.accel_counts_per_g
    block.trust_q15 = min(LARGEST_GAIN, max(1, round(Q15 / (imu.trust_time_s * rate))))
    # Critically damped: bias' = -missed / (4 trust_time^2), a tick, in counts Q16 of rad Q14.
    learn = degrees(imu.gyro_counts_per_deg_s) / (4 * imu.trust_time_s**2 * rate)
    block.learn_q12 = min(0x3FFFF, round(learn * 4 * Q12))
    block.rest_change[:] = [ceil(REST_DEG_S * imu.gyro_counts_per_deg_s), ceil(REST_G * imu.accel_counts_per_g)]
    block.tolerance = round(imu.tolerance_g * imu.accel_counts_per_g)
    block.align_ticks = min(1024, max(1, round(imu.align_time_s * rate)))
    attitude_reset(block)
    return block


def joints_rad(joints_brad: Sequence[int]) -> list[float]:
    """Return joint angles in rad."""
    return [angle / BRAD_PER_RAD for angle in joints_brad]
