"""The robots the core is tested with, as its blocks of integers, and what the float crawl needs of them.

The two robot files and what they stretch to: both knees, a leg of 1 m, unequal links, no hip offset.
"""

import math
from copy import deepcopy
from functools import cache
from types import SimpleNamespace

from host.robot.file import find, load_robot, read_toml
from host.robot.model import Robot
from host.robot.scale import core_params
from shared.body.crawl_setup import CrawlSetup
from tests.float_twin.si import leg_si

KNEES = ("full-elbow", "full-knee", "elbow-knee", "knee-elbow")

# What one of the core's units of the crawl's numbers is to the float twin, times a length unit in m
CRAWL_UNITS = {"lu": 1, "lf / tick": 1 / 256, "lf / tick^2": 1 / 256}
CRAWL_SHARES = {"ticks": 1, "Q15 / tick": 1 / 32768}


def variant(name, **geometry):
    """Return a robot file's robot with other geometry values; whether its stance suits them is not checked."""
    tables = read_toml(find(name))
    tables["geometry"].update(geometry)
    return Robot.model_validate(tables)


def with_trunk_at(name, com_m):
    """Return a robot file's robot with its trunk's centre of mass elsewhere."""
    robot = load_robot(name)
    trunk = robot.links.trunk.model_copy(update={"com_m": com_m})
    return robot.model_copy(update={"links": robot.links.model_copy(update={"trunk": trunk})})


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


def crawl_si(params):
    """Return what the float crawl needs, in m, rad and ticks, speeds per tick, forces in own weights."""
    unit_m = 2.0 ** -params.length_shift
    crawl, legs = params.crawl, [leg_si(params, leg) for leg in range(4)]
    one = CRAWL_SHARES | {unit: share * unit_m for unit, share in CRAWL_UNITS.items()}
    return SimpleNamespace(
        **{name: getattr(crawl, name) * one[place.unit] for name, place in CrawlSetup.FIELDS if place.unit in one},
        com_x=params.com_x * unit_m,
        half_leg=params.leg_length * unit_m / 2,
        share=4096 // crawl.share_ticks / 4096,
        acceleration=crawl.body_acceleration * unit_m / params.rate_hz**2,
        quick_acceleration=crawl.quick_body_acceleration * unit_m / params.rate_hz**2,
        touch=crawl.touch_q12 / 4096,
        peak=crawl.peak_q12 / 4096,
        planar=params.lateral_q12 == 0,
        hips=[leg.hip for leg in legs],
        sides=[leg.side_l1 for leg in legs],
        line=[legs[2 + side].rest[1] for side in range(2)],
    )
