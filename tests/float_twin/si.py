"""A robot's block of integers (shared/body/params.py) as the SI numbers that the float twins take."""

import math

from shared.record import pack

BRAD_PER_RAD = 65536 / (2 * math.pi)


class Plain:
    """An object that is nothing but its attributes."""

    def __init__(self, **values):
        for name in values:
            setattr(self, name, values[name])


def rad(angle_brad):
    """Return an angle in rad."""
    return angle_brad / BRAD_PER_RAD


def leg_si(params, leg):
    """Return what the float leg needs, in m, as the integers say it; and the unit."""
    unit_m = 2.0 ** -params.length_shift
    base = params.legs[leg]
    return Plain(
        unit_m=unit_m,
        side_l1=base.hip_length * unit_m,
        l1=abs(base.hip_length) * unit_m,
        l2=base.thigh_length * unit_m,
        l3=base.calf_length * unit_m,
        knee=base.knee,
        hip=[base.hip[axis] * unit_m for axis in range(3)],
        rest=[base.rest[axis] * unit_m for axis in range(3)],
        low=[rad(base.lowest[joint]) for joint in range(3)],
        high=[rad(base.highest[joint]) for joint in range(3)],
    )


def planner_si(params):
    """Return what the float planner needs, per tick where the block has it per tick."""
    unit_m = 2.0 ** -params.length_shift
    speed_unit, rate, of = (unit_m / 256, unit_m / 256, 2.0**-18), params.rate_hz, params.gains
    pose_unit = [unit_m] * 3 + [rad(1)] * 3
    gains = of.kp_q12 / 4096, of.ki_q16 / 65536 * rate, of.kd_q10 / 1024 / rate
    return Plain(
        rate_hz=rate,
        delay_ticks=params.delay_ticks,
        unit_m=unit_m,
        leg_m=params.leg_length * unit_m,
        legs=[leg_si(params, leg) for leg in range(4)],
        speed_unit=speed_unit,
        pose_unit=pose_unit,
        speed_max=scaled(params.speed_max, speed_unit),
        speed_slew=scaled(params.speed_slew, speed_unit),
        pose_max=scaled(params.pose_max, pose_unit),
        pose_slew=scaled(params.pose_slew, pose_unit),
        joint_speed_slow=rad(params.joint_speed_slow),
        joint_speed_max=[rad(top) for top in pack(params.joint_speed_max)],
        coupled=params.coupled,
        sit_z=params.sit_z * unit_m,
        stride=params.stride_max * unit_m,
        gains=gains + (rad(params.integral_max), rad(params.balance_max), rate),
    )


def scaled(record, units):
    """Return a record's values, each times its unit."""
    return [value * unit for value, unit in zip(pack(record), units)]
