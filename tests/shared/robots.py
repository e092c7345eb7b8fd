"""The robots the core is tested with, as its blocks of integers and, from those, as SI numbers.

The two robot files and what they stretch to: both knees, a leg of 1 m, unequal links, no hip offset.
"""

import math
from copy import deepcopy
from functools import cache
from types import SimpleNamespace

from host.robot.file import find, read_toml
from host.robot.model import Robot
from host.robot.scale import BRAD_PER_RAD, core_params
from shared.body.crawl_setup import CrawlSetup
from shared.record import pack

KNEES = ("full-elbow", "full-knee", "elbow-knee", "knee-elbow")

# What one of the core's units of the crawl's numbers is to the float twin, times a length unit in m
CRAWL_UNITS = {"lu": 1, "lf / tick": 1 / 256, "lf / tick^2": 1 / 256}
CRAWL_SHARES = {"ticks": 1, "Q15 / tick": 1 / 32768}


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
    """Return a test robot as the core has it; each caller may change its own."""
    return deepcopy(_made(name, rate_hz, knees))


@cache
def _made(name, rate_hz, knees):
    """Return the same, which takes many times as long as a copy and is asked for in every example of a test."""
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
    speeds = pack(params.speed_max) + pack(params.speed_slew)
    poses = [v * unit_m if i % 6 < 3 else rad(v) for i, v in enumerate(pack(params.pose_max) + pack(params.pose_slew))]
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
        joint_top=[rad(v) for v in pack(params.joint_top)],
        coupled=params.coupled,
        sit_z=params.sit_z * unit_m,
        stride=params.stride_max * unit_m,
        gains=(*gains, rad(params.integral_max), rad(params.balance_max), rate),
    )


def crawl_si(params):
    """Return what the float crawl needs, in m, rad and ticks, speeds per tick, forces in own weights."""
    unit_m = 2.0 ** -params.length_shift
    crawl, legs = params.crawl, [leg_si(params, leg) for leg in range(4)]
    one = CRAWL_SHARES | {unit: share * unit_m for unit, share in CRAWL_UNITS.items()}
    return SimpleNamespace(
        **{name: getattr(crawl, name) * one[place.unit] for name, place in CrawlSetup.FIELDS if place.unit in one},
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
