"""The robots the core is tested with, as its blocks of integers and, from those, as SI numbers.

The two robot files and what they stretch to: both knees, a leg of 1 m, unequal links, no hip offset.
"""

import math
from types import SimpleNamespace

from host.robot.file import find, read_toml
from host.robot.model import Robot
from host.robot.scale import BRAD_PER_RAD, core_params

KNEES = ("full-elbow", "full-knee", "elbow-knee", "knee-elbow")

# The crawl's numbers by what the float twin calls them
CRAWL_LENGTHS = {
    "stride": "stride",
    "height": "height",
    "tall": "heavy_height",
    "reach": "reach",
    "reach_swing": "swing_reach",
    "near": "folded",
    "margin": "margin",
    "ahead": "heavy_forward",
    "com_z": "com_z",
    "lift_front": "front_lift",
    "lift_rear": "hind_lift",
    "near_print": "near_foothold",
    "deepest": "deepest",
    "hit": "riser_lag",
    "high": "edge_height",
    "void": "drop_depth",
    "advance": "edge_advance",
    "advance_void": "drop_advance",
    "back": "edge_retreat",
    "hit_back": "riser_retreat",
    "shin": "shin_lift",
    "shin_raise": "shin_clear",
    "too_high": "highest_contact",
    "clear": "clear_ground",
    "arm_x": "half_length",
    "arm_y": "half_width",
    "raised": "clear_contact",
    "warp_max": "warp_max",
    "limit": "position_limit",
}
CRAWL_FINE = {
    "body_v": "body_speed",
    "v_up": "lift_speed",
    "a_up": "lift_acceleration",
    "brake": "lift_brake",
    "v_top": "top_speed",
    "move_pace": "swing_speed",
    "v_tare": "hang_speed",
    "a_down": "lower_acceleration",
    "v_front": "front_lower_speed",
    "v_rear": "hind_lower_speed",
    "v_slow": "near_speed",
    "v_quick": "fast_speed",
    "warp": "warp_gain",
    "warp_v": "warp_speed",
}
CRAWL_TICKS = {
    "body_ticks": "body_ticks",
    "settle": "settle_ticks",
    "share_ticks": "share_ticks",
    "move_ticks": "swing_ticks",
    "tare_ticks": "hang_ticks",
    "tare_skip": "hang_skip_ticks",
    "touch_ticks": "contact_ticks",
    "hit_after": "riser_skip_ticks",
    "hit_lag": "swing_lag_ticks",
    "late": "goal_lag_ticks",
    "warp_ticks": "warp_ticks",
}
CRAWL_GAINS = {
    "tare_in": "tare_in_q15",
    "tare_slow": "tare_slow_q15",
    "tare_fast": "tare_fast_q15",
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


def unlimited(params):
    """Return a robot with the reach of its legs as if the calves bent without limits."""
    for leg in params.legs:
        links = leg.thigh_length, leg.calf_length
        leg.longest = math.isqrt(leg.hip_length**2 + (links[0] + links[1]) ** 2)
        leg.shortest = math.ceil(math.hypot(leg.hip_length, links[0] - links[1]))
    return params


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
    of = params.gains
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


def crawl_si(params):
    """Return what the float crawl needs, in m, rad and ticks, speeds per tick, forces in own weights."""
    unit_m = 2.0 ** -params.length_shift
    crawl, legs = params.crawl, [leg_si(params, leg) for leg in range(4)]
    values = {}
    scales = ((CRAWL_LENGTHS, unit_m), (CRAWL_FINE, unit_m / 256), (CRAWL_TICKS, 1), (CRAWL_GAINS, 1 / 32768))
    for names, scale in scales:
        for name, place in names.items():
            values[name] = getattr(crawl, place) * scale
    return SimpleNamespace(
        **values,
        com_x=params.com_x * unit_m,
        pace=crawl.stride * unit_m / 4,
        rebase=params.leg_length * unit_m / 2,
        share=4096 // crawl.share_ticks / 4096,
        acceleration=crawl.body_acceleration * unit_m / params.rate_hz**2,
        planar=params.lateral_q12 == 0,
        hips=[leg.hip for leg in legs],
        sides=[leg.side_l1 for leg in legs],
        line=[legs[2 + side].rest[1] for side in range(2)],
    )
