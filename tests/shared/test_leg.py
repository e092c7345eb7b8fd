"""shared/body/leg.py and shared/body/reach.py against the float leg: foot error, limits, unreachable feet."""

import math
import random
from array import array
from statistics import median_high

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from shared.body.feet import Feet
from shared.body.leg import LIMIT_CALF, LIMIT_HIP, LIMIT_THIGH, leg_forward, leg_inverse, limit_legs
from shared.body.reach import INSIDE_HIP, TOO_FAR, TOO_NEAR, reach_foot, scale_down
from shared.record import pack, unpack
from tests.float_twin import leg as twin
from tests.float_twin import reach as twin_reach
from tests.float_twin.si import leg_si, rad

from .bars import INT16, LARGEST, WORD, integers
from .robots import KNEES, NAMES, block, unlimited

BLOCKS = {name: unlimited(block(name)) for name in NAMES}
LEGS = st.integers(0, 3)
ROBOTS = st.sampled_from(NAMES)


def zeros():
    return array("i", [0] * 12)


def reachable_feet(si, count, seed):
    """Return ``count`` feet in m: half all over the leg's shell by volume, half close to one of its borders."""
    dice = random.Random(seed)
    near, far = twin_reach.nearest_and_farthest(si.l1, si.l2, si.l3)
    feet = []
    while len(feet) < count:
        way = len(feet) % 4
        radius = far * dice.random() ** (1 / 3)
        if way == 1:
            radius = far - dice.random() ** 3 * 0.01 * far
        elif way == 2:
            radius = near + dice.random() ** 3 * 0.03 * far
        direction = [dice.gauss(0, 1) for _ in range(3)]
        if way == 3:  # a foot that just clears the hip offset
            direction[0] = radius
            around = si.l1 + dice.random() ** 3 * 0.03 * far
            turned = dice.uniform(-math.pi, math.pi)
            foot = direction[0], around * math.cos(turned), around * math.sin(turned)
        else:
            foot = twin_reach.scaled(direction, radius / math.hypot(*direction))
        if twin_reach.clamp(foot, si.l1, si.l2, si.l3)[1] == 0:
            feet.append(foot)
    return feet


def solved(params, leg, foot):
    """Return reach_foot's flags, the foot it gives, lu, and the angles that put the leg's foot there, brad."""
    feet, reached, joints = Feet(), Feet(), zeros()
    unpack(feet.legs[leg], foot)
    flags = reach_foot(params, leg, feet, reached)
    leg_inverse(params, leg, reached, joints)
    return flags, pack(reached.legs[leg]), list(joints[leg * 3 : leg * 3 + 3])


def off_m(si, joints, foot):
    """Return how far the float leg's foot is from one in lu under the integer angles."""
    exact = twin.forward([rad(q) for q in joints], si.side_l1, si.l2, si.l3)
    return math.dist([v * si.unit_m for v in foot], exact)


def foot_errors_m(params, count):
    """Return the distances between wanted feet and those of the integer angles in the float leg."""
    errors = []
    for leg in range(4):
        si = leg_si(params, leg)
        for foot_m in reachable_feet(si, count // 4, 1 + leg):
            foot = [round(v / si.unit_m) for v in foot_m]
            flags, _, joints = solved(params, leg, foot)
            assert flags == 0
            errors.append(off_m(si, joints, foot))
    return errors


@pytest.mark.parametrize("knees", KNEES)
@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_foot_error_over_the_reachable_workspace(name, knees):
    errors = foot_errors_m(unlimited(block(name, knees=knees)), 20000)
    assert len(errors) == 20000
    assert max(errors) <= 0.05e-3
    assert median_high(errors) <= 0.02e-3


@pytest.mark.parametrize(("name", "bar_m"), [("long-leg", 0.2e-3), ("unequal", 0.08e-3), ("no-offset", 0.05e-3)])
def test_foot_error_of_other_legs(name, bar_m):
    assert max(foot_errors_m(BLOCKS[name], 4000)) <= bar_m


def shell_lu(name, leg):
    """Return hip offset, thigh and calf in lu, and the nearest and farthest distance."""
    si = leg_si(BLOCKS[name], leg)
    links = [round(length / si.unit_m) for length in (si.l1, si.l2, si.l3)]
    return links, twin_reach.nearest_and_farthest(*links)


def check_clamp(name, leg, foot):
    """Compare with the float clamp: the same place within 5 lu, the same reasons unless it is a rounding away.

    A foot far out along the hip axis is first brought within reach and rounded there, which turns the ray of one
    that ends close to the axis: then the place is only as good as that ray.
    """
    flags, reached, _ = solved(BLOCKS[name], leg, foot)
    links, (near, far) = shell_lu(name, leg)
    wanted, reasons = twin_reach.clamp(foot, *links)
    distance = math.hypot(*foot)
    around = math.hypot(*foot[1:]) * min(1.0, far / max(distance, 1))
    turned = 0.0
    if distance > far and around < links[0]:
        turned = 4 * links[0] / around if around > 2 else 3 * links[0]
    assert math.dist(reached, wanted) <= 5 + turned
    borderline = min(abs(distance - far), abs(around - links[0]), abs(distance - near)) <= 3
    at_the_end = abs(abs(wanted[0]) - links[1] - links[2]) <= 5 + turned
    if not borderline and not at_the_end:
        assert flags == reasons
    assert near - 5 <= math.hypot(*reached) <= far + 5
    assert math.hypot(*reached[1:]) >= links[0] - 5


@settings(max_examples=1500)
@given(ROBOTS, LEGS, st.tuples(WORD, WORD, WORD))
def test_any_foot_ends_where_the_float_clamp_puts_it(name, leg, foot):
    check_clamp(name, leg, foot)


CLOSE = integers(-40000, 40000)


@settings(max_examples=3000)
@given(ROBOTS, LEGS, st.tuples(CLOSE, st.one_of(CLOSE, integers(-50, 50)), st.one_of(CLOSE, integers(-50, 50))))
@example("caramelo", 0, (0, 0, 0))
@example("unequal", 1, (0, 0, 0))
@example("no-offset", 2, (0, 0, 0))
@example("caramelo", 1, (32080, 0, 0))
@example("caramelo", 1, (-31457, 0, 0))
@example("caramelo", 1, (2, 1, -1))
@example("caramelo", 3, (20000, 3, 0))
def test_feet_round_the_leg_end_where_the_float_clamp_puts_them(name, leg, foot):
    check_clamp(name, leg, foot)


@settings(max_examples=400)
@given(ROBOTS, LEGS, st.tuples(WORD, WORD, WORD))
def test_a_clamped_foot_is_solved_to_itself(name, leg, foot):
    """Never fails, whatever is asked for: the angles put the foot where the clamp says."""
    params, si = BLOCKS[name], leg_si(BLOCKS[name], leg)
    _, reached, joints = solved(params, leg, foot)
    assert off_m(si, joints, reached) <= 5 * si.unit_m + 1.3e-4 * (si.l2 + si.l3)


@settings(max_examples=600)
@given(ROBOTS, LEGS, st.tuples(*[integers(-(1 << 20), 1 << 20)] * 3))
def test_forward_is_the_float_forward(name, leg, angles):
    params, si = BLOCKS[name], leg_si(BLOCKS[name], leg)
    joints, feet = zeros(), Feet()
    joints[leg * 3 : leg * 3 + 3] = array("i", angles)
    leg_forward(params, leg, joints, feet)
    assert off_m(si, angles, pack(feet.legs[leg])) <= 3 * si.unit_m + 4e-5 * (si.l1 + si.l2 + si.l3)


@pytest.mark.parametrize("knees", KNEES)
def test_inverse_undoes_forward(knees):
    """Angles to foot to angles, over the robots' joint limits; and the twin's inverse undoes the twin's forward.

    Where the foot is well below the hip: level with it, the same foot has a second solution close by.
    """
    for name in ("caramelo", "parallel"):
        params, dice = block(name, knees=knees), random.Random(7)
        joints, feet, back = zeros(), Feet(), zeros()
        for turn in range(400):
            leg = turn % 4
            si = leg_si(params, leg)
            angles = [dice.uniform(low, high) for low, high in zip(si.low, si.high, strict=True)]
            foot = twin.forward(angles, si.side_l1, si.l2, si.l3)
            drop = si.l2 * math.cos(angles[1]) + si.l3 * math.cos(angles[1] + angles[2])
            if drop < 0.3 * (si.l2 + si.l3):
                continue
            assert twin.inverse(foot, si.side_l1, si.l2, si.l3, si.knee) == pytest.approx(angles, abs=1e-9)
            joints[leg * 3 : leg * 3 + 3] = array("i", [round(a * 65536 / math.tau) for a in angles])
            leg_forward(params, leg, joints, feet)
            leg_inverse(params, leg, feet, back)
            there_and_back = zip(joints[leg * 3 : leg * 3 + 3], back[leg * 3 : leg * 3 + 3], strict=True)
            assert max(abs(a - b) for a, b in there_and_back) <= 12


@pytest.mark.parametrize(
    ("foot", "reasons"),
    [
        ((0, 6291, -33000), TOO_FAR),
        ((0, 6291, -22000), 0),
        ((0, 6291, -1), 0),
        ((0, 6200, 0), INSIDE_HIP),
        ((10, 0, 0), INSIDE_HIP),
        ((32080, 0, 0), INSIDE_HIP | TOO_FAR),
    ],
)
def test_reasons_of_feet_of_caramelos_left_leg(foot, reasons):
    assert solved(BLOCKS["caramelo"], 1, foot)[0] == reasons


def test_too_near_needs_unequal_links():
    links, (near, _) = shell_lu("unequal", 1)
    assert near > links[0]
    assert solved(BLOCKS["unequal"], 1, (0, links[0] + 40, 0))[0] == TOO_NEAR


@settings(max_examples=400)
@given(ROBOTS, LEGS, st.tuples(*[INT16] * 3))
def test_joint_limits_act_and_are_reported(name, leg, angles):
    params, joints = BLOCKS[name], zeros()
    base = params.legs[leg]
    joints[leg * 3 : leg * 3 + 3] = array("i", angles)
    acted = array("i", [0] * 4)
    limit_legs(params, joints, acted)
    flags = acted[leg]
    for joint, bit in enumerate((LIMIT_HIP, LIMIT_THIGH, LIMIT_CALF)):
        low, high = base.lowest[joint], base.highest[joint]
        assert joints[leg * 3 + joint] == min(max(angles[joint], low), high)
        assert bool(flags & bit) == (not low <= angles[joint] <= high)


@settings(max_examples=400)
@given(integers(-LARGEST, LARGEST), integers(0, 32767), integers(-5, LARGEST))
def test_scale_down_rounds_towards_zero(value, numerator, denominator):
    if abs(value * numerator) < 1 << 30:
        exact = value * numerator / denominator if denominator > 0 else 0
        assert scale_down(value, numerator, denominator) == math.trunc(exact)


def test_left_and_right_legs_mirror():
    """A right foot mirrored on y has the left one's angles, the hip negated."""
    for name in NAMES:
        params = BLOCKS[name]
        for foot in reachable_feet(leg_si(params, 1), 300, 3):
            x, y, z = [round(v / leg_si(params, 1).unit_m) for v in foot]
            (hip, thigh, calf), left = solved(params, 0, (x, -y, z))[2], solved(params, 1, (x, y, z))[2]
            mirrored = [-hip, thigh, calf]
            assert all(abs((a - b + 32768) % 65536 - 32768) <= 1 for a, b in zip(mirrored, left, strict=True))
