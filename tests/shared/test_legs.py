"""All four legs at once: the same numbers as leg by leg, over joints and feet of any size, for every test robot."""

import random

import pytest

from shared.body.feet import Feet
from shared.body.leg import leg_forward, leg_inverse
from shared.body.legs import LegsWork, legs_forward, legs_inverse, reach_feet
from shared.body.reach import reach_foot
from shared.num.fixed import arctans_brad18, atan2_brad18, round_roots, round_sqrt
from shared.record import pack, unpack

from .robots import KNEES, NAMES, block

CASES = [(name, knees) for name in NAMES for knees in KNEES]


@pytest.mark.parametrize(("name", "knees"), CASES)
def test_forward_is_that_of_each_leg(name, knees):
    params, waves, rng = block(name, knees=knees), [0] * 24, random.Random(1)
    for _ in range(200):
        joints, feet, one = [rng.randrange(-70000, 70000) for _ in range(12)], Feet(), Feet()
        legs_forward(params, joints, waves, feet)
        for leg in range(4):
            leg_forward(params, leg, joints, one)
            for axis in range(3):
                assert feet.legs[leg][axis] == one.legs[leg][axis] + params.legs[leg].hip[axis]


@pytest.mark.parametrize(("name", "knees"), CASES)
def test_inverse_is_that_of_each_leg_within_a_brad(name, knees):
    """A brad: of (y, z) beyond 2^23 the angle is rounded otherwise. Feet out of reach are brought into it alike."""
    params, work, rng = block(name, knees=knees), LegsWork(), random.Random(2)
    most = params.legs[0].longest * 5 // 4
    for _ in range(200):
        feet = [rng.randrange(-most, most) for _ in range(12)]
        feet, reached = unpack(Feet(), feet), unpack(Feet(), feet)
        wanted, joints, flags = [0] * 12, [0] * 12, 0
        for leg in range(4):
            flags |= reach_foot(params, leg, reached, reached)
            leg_inverse(params, leg, reached, wanted)
        assert legs_inverse(params, feet, work, joints) == flags
        assert pack(feet) == pack(reached)
        assert max(abs((a - b + 0x8000 & 0xFFFF) - 0x8000) for a, b in zip(joints, wanted, strict=True)) <= 1


@pytest.mark.parametrize("name", NAMES)
def test_feet_are_brought_into_reach_as_each(name):
    params, rng, inside = block(name), random.Random(3), 0
    most = params.legs[0].longest * 9 // 8
    for _ in range(2000):
        feet = [rng.randrange(-most, most) for _ in range(12)]
        feet, reached, flags = unpack(Feet(), feet), unpack(Feet(), feet), 0
        for leg in range(4):
            flags |= reach_foot(params, leg, reached, reached)
        inside += pack(feet.legs[0]) == pack(reached.legs[0])
        assert reach_feet(params, feet, [0] * 8) == flags
        assert pack(feet) == pack(reached)
    assert inside > 100


def spread(rng, bits):
    """Return a number of up to ``bits`` bits, small ones as often as large ones."""
    return rng.choice((-1, 1)) * rng.getrandbits(rng.randint(0, bits))


def test_roots_are_those_of_each():
    rng = random.Random(4)
    values = [spread(rng, 30) for _ in range(4000)] + [0, 1, 2, 3, (1 << 30) - 1, -(1 << 30)]
    roots = [0] * len(values)
    round_roots(values, roots, len(values))
    assert roots == [round_sqrt(value) for value in values]


def test_arctangents_are_those_of_each_within_half_a_brad():
    rng = random.Random(5)
    ys, xs = ([spread(rng, 30) for _ in range(4000)] for _ in range(2))
    angles = [0] * len(ys)
    arctans_brad18(ys, xs, angles, len(ys))
    for y, x, angle in zip(ys, xs, angles, strict=True):
        assert abs((angle - atan2_brad18(y, x) + 0x20000 & 0x3FFFF) - 0x20000) <= 2
    arctans_brad18([0, 0, 5, -5, 0], [0, -3, 5, 0, 7], angles, 5)
    assert angles[:5] == [0, -0x20000, 0x8000, -0x10000, 0]
