"""The robots the core is tested with, as its blocks of integers and, from those, as SI numbers.

The two robot files and what they stretch to: both knees, a leg of 1 m, unequal links, no hip offset.
"""

import math
from types import SimpleNamespace

from host.robot_file import find, read_toml
from host.robot_model import Robot
from host.scale import BRAD_PER_RAD, core_params
from shared import crawl_layout

KNEES = ("full-elbow", "full-knee", "elbow-knee", "knee-elbow")

# The crawl's settings by what the float twin calls them
CRAWL_LENGTHS = {
    "stride": crawl_layout.K_STRIDE,
    "height": crawl_layout.K_HEIGHT,
    "tall": crawl_layout.K_TALL,
    "reach": crawl_layout.K_REACH,
    "reach_swing": crawl_layout.K_REACH_SWING,
    "near": crawl_layout.K_NEAR,
    "margin": crawl_layout.K_MARGIN,
    "ahead": crawl_layout.K_AHEAD,
    "com_x": crawl_layout.K_COM_X,
    "com_z": crawl_layout.K_COM_Z,
    "lift_front": crawl_layout.K_LIFT_FRONT,
    "lift_rear": crawl_layout.K_LIFT_REAR,
    "near_print": crawl_layout.K_NEAR_PRINT,
    "deepest": crawl_layout.K_DEEPEST,
    "hit": crawl_layout.K_HIT,
    "high": crawl_layout.K_HIGH,
    "void": crawl_layout.K_VOID,
    "advance": crawl_layout.K_ADVANCE,
    "advance_void": crawl_layout.K_ADVANCE_VOID,
    "back": crawl_layout.K_BACK,
    "hit_back": crawl_layout.K_HIT_BACK,
    "shin": crawl_layout.K_SHIN,
    "shin_raise": crawl_layout.K_SHIN_RAISE,
    "too_high": crawl_layout.K_TOO_HIGH,
    "clear": crawl_layout.K_CLEAR,
    "arm_x": crawl_layout.K_ARM_X,
    "arm_y": crawl_layout.K_ARM_Y,
    "raised": crawl_layout.K_RAISE,
}
CRAWL_FINE = {
    "body_v": crawl_layout.K_BODY_V,
    "v_up": crawl_layout.K_V_UP,
    "a_up": crawl_layout.K_A_UP,
    "brake": crawl_layout.K_BRAKE,
    "v_top": crawl_layout.K_V_TOP,
    "move_pace": crawl_layout.K_MOVE_PACE,
    "v_tare": crawl_layout.K_V_TARE,
    "a_down": crawl_layout.K_A_DOWN,
    "v_front": crawl_layout.K_V_FRONT,
    "v_rear": crawl_layout.K_V_REAR,
    "v_slow": crawl_layout.K_V_SLOW,
    "v_quick": crawl_layout.K_V_QUICK,
    "warp": crawl_layout.K_WARP,
    "warp_v": crawl_layout.K_WARP_V,
    "warp_max": crawl_layout.K_WARP_MAX,
    "pace": crawl_layout.K_PACE,
    "rebase": crawl_layout.K_REBASE,
    "limit": crawl_layout.K_LIMIT_X,
}
CRAWL_TICKS = {
    "body_ticks": crawl_layout.K_BODY_TICKS,
    "settle": crawl_layout.K_SETTLE,
    "share_ticks": crawl_layout.K_SHARE_TICKS,
    "move_ticks": crawl_layout.K_MOVE_TICKS,
    "tare_ticks": crawl_layout.K_TARE_TICKS,
    "tare_skip": crawl_layout.K_TARE_SKIP,
    "touch_ticks": crawl_layout.K_TOUCH_TICKS,
    "hit_after": crawl_layout.K_HIT_AFTER,
    "hit_lag": crawl_layout.K_HIT_LAG,
    "late": crawl_layout.K_LATE,
    "warp_ticks": crawl_layout.K_WARP_TICKS,
}
CRAWL_GAINS = {
    "tare_in": crawl_layout.K_TARE_IN,
    "tare_slow": crawl_layout.K_TARE_SLOW,
    "tare_fast": crawl_layout.K_TARE_FAST,
}


def variant(name, **geometry):
    """Return a robot file's robot with other geometry values; whether its stance suits them is not checked."""
    tables = read_toml(find(name))
    tables["geometry"].update(geometry)
    return Robot.model_validate(tables)


def robot(name, knees="full-elbow"):
    """Return one of the test robots by its name."""
    geometry = {
        "caramelo": {},
        "parallel": {},
        "long-leg": {"hip_offset_m": 0.12, "thigh_m": 0.50, "calf_m": 0.48},
        "unequal": {"hip_offset_m": 0.05, "thigh_m": 0.20, "calf_m": 0.13},
        "no-offset": {"hip_offset_m": 0.0},
    }[name]
    file = "parallel" if name in ("parallel", "long-leg") else "caramelo"
    return variant(file, knee_configuration=knees, **geometry)


NAMES = ("caramelo", "parallel", "long-leg", "unequal", "no-offset")


def block(name, rate_hz=50, knees="full-elbow"):
    """Return a test robot as the core has it."""
    return core_params(robot(name, knees), rate_hz)


def leg_si(params, leg):
    """Return what the float twin's leg needs, in m, as the integers say it; and the unit."""
    unit_m = 2.0 ** -params.length_shift
    base = params.legs[leg]
    return SimpleNamespace(
        unit_m=unit_m,
        side_l1=base.hip_length * unit_m,
        l1=abs(base.hip_length) * unit_m,
        l2=base.thigh_length * unit_m,
        l3=base.calf_length * unit_m,
        knee=base.knee,
        hip=[v * unit_m for v in base.hip],
        rest=[v * unit_m for v in base.rest],
        low=[rad(v) for v in base.lowest],
        high=[rad(v) for v in base.highest],
    )


def rad(angle_brad):
    """Return an angle in rad."""
    return angle_brad / BRAD_PER_RAD


def distance(a, b):
    """Return how far two points are from each other."""
    return math.dist(a, b)


def planner_si(params):
    """Return what the float planner needs, per tick where the block has it per tick."""
    unit_m = 2.0 ** -params.length_shift
    fine_m, yaw = unit_m / 256, 2.0**-18
    rate = params.rate_hz
    speeds = [*params.speed_max, *params.speed_slew]
    poses = [v * unit_m if i % 6 < 3 else rad(v) for i, v in enumerate([*params.pose_max, *params.pose_slew])]
    of = params.gains[0]
    gains = of.kp_q12 / 4096, of.ki_q16 / 65536 * rate, of.kd_q10 / 1024 / rate
    return SimpleNamespace(
        unit_m=unit_m,
        legs=[leg_si(params, leg) for leg in range(4)],
        speed_unit=(fine_m, fine_m, yaw),
        speed_max=(speeds[0] * fine_m, speeds[1] * fine_m, speeds[2] * yaw),
        speed_slew=(speeds[3] * fine_m, speeds[4] * fine_m, speeds[5] * yaw),
        pose_max=poses[:6],
        pose_slew=poses[6:],
        joint_step=rad(params.joint_step),
        joint_top=[rad(v) for v in params.joint_top],
        coupled=params.coupled,
        sit_z=params.sit_z * unit_m,
        stride=params.stride_max * unit_m,
        gains=(*gains, rad(params.integral_max), rad(params.balance_max), rate),
    )


def crawl_si(params, settings):
    """Return what the float crawl needs, in m, rad and ticks, speeds per tick, forces in own weights."""
    unit_m = 2.0 ** -params.length_shift
    rate = settings[crawl_layout.K_RATE]
    legs = [leg_si(params, leg) for leg in range(4)]
    values = {}
    for names, scale in ((CRAWL_LENGTHS, unit_m), (CRAWL_FINE, unit_m / 256), (CRAWL_TICKS, 1)):
        for name, place in names.items():
            values[name] = settings[place] * scale
    for name, place in CRAWL_GAINS.items():
        values[name] = settings[place] / 32768
    return SimpleNamespace(
        **values,
        share=settings[crawl_layout.K_SHARE] / 4096,
        acceleration=settings[crawl_layout.K_ACC] * unit_m / rate**2,
        planar=bool(settings[crawl_layout.K_PLANAR]),
        hips=[leg.hip for leg in legs],
        sides=[leg.side_l1 for leg in legs],
        line=[legs[2 + side].rest[1] for side in range(2)],
    )
