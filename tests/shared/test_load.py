"""Sag, foot forces, load sharing and stability of shared/ against the float twin over five robots and all feet."""

import itertools
import math
import random
from array import array
from statistics import median_high

import pytest

from shared.body import compliance, load, stability
from shared.body.feet import Feet
from shared.body.params import Params
from shared.record import copy, pack, unpack
from shared.sense import legs as sensing
from tests.float_twin import load as twin
from tests.float_twin.leg import forward
from tests.float_twin.si import leg_si, rad

from .robots import NAMES, block

BLOCKS = {name: block(name) for name in NAMES}
AROUND = (0, 1, 3, 2)  # FR, FL, RL, RR


def soft(name, coupled):
    """Return a robot's block whose joints give, with its calf's motor on the thigh or on the body."""
    params = Params()
    copy(BLOCKS[name], params)
    params.coupled = coupled
    for joint in range(3):
        if params.sag_q16[joint] == 0:
            params.sag_q16[joint] = round(65536 * 256 / params.stiff_q8[joint])
    return params


def poses(params, count, seed):
    """Yield leg, joints in brad within the limits, bent by at least 15 deg."""
    dice = random.Random(seed)
    for _ in range(count):
        leg = dice.randrange(4)
        base = params.legs[leg]
        joints = [dice.randint(base.lowest[j], base.highest[j]) for j in range(3)]
        if 2730 < abs(joints[2]) < 27000:
            yield leg, joints


@pytest.mark.parametrize(("name", "coupled"), [(name, coupled) for name in NAMES for coupled in (0, 1)])
def test_sag_is_the_transposed_jacobian_over_the_stiffness(name, coupled):
    params, dice, errors = soft(name, coupled), random.Random(5), []
    give = [rad(params.sag_q16[j] / 65536) for j in range(3)]
    for leg, joints in poses(params, 400, 3):
        si = leg_si(params, leg)
        links = [v / si.unit_m for v in (si.side_l1, si.l2, si.l3)]
        feet, goals = Feet(), array("i", [0] * 12)
        unpack(feet.legs[leg], [round(v) for v in forward([rad(q) for q in joints], *links)])
        goals[leg * 3 : leg * 3 + 3] = array("i", joints)
        force = [dice.randint(-600, 600), dice.randint(-600, 600), dice.randint(0, 2000)]
        compliance.sag_leg(params, leg, feet, *force, goals)
        exact = twin.sag([rad(q) for q in joints], [f / 4096 for f in force], coupled, give, *links)
        if max(abs(exact[j] - rad(joints[j])) for j in range(3)) < math.radians(15):
            errors += [abs(rad(goals[leg * 3 + j]) - exact[j]) for j in range(3)]
    assert len(errors) > 300
    assert max(errors) <= rad(8)
    assert median_high(errors) <= rad(1)


@pytest.mark.parametrize(("name", "coupled"), [(name, coupled) for name in NAMES for coupled in (0, 1)])
def test_force_is_found_again_from_the_joint_errors_it_makes(name, coupled):
    """Hold a leg still under a force along it: the goals that sag to the pose tell the force within 2 %."""
    params, dice, found = soft(name, coupled), random.Random(6), 0
    give = [rad(params.sag_q16[j] / 65536) for j in range(3)]
    state = sensing.Sensing()
    for leg, joints in poses(params, 300, 4):
        joints[0] = 0
        si = leg_si(params, leg)
        links = [v / si.unit_m for v in (si.side_l1, si.l2, si.l3)]
        force = dice.randint(200, 2500)
        goal = twin.sag([rad(q) for q in joints], [0, 0, force / 4096], coupled, give, *links)
        if max(abs(goal[j] - rad(joints[j])) for j in range(3)) > math.radians(15):
            continue
        sensing.sensing_reset(state)
        sent, measured = array("i", [0] * 12), array("i", [0] * 12)
        for j in range(3):
            sent[leg * 3 + j] = round(goal[j] / rad(1))
            measured[leg * 3 + j] = joints[j]
        for _ in range(params.delay_ticks + 2):
            sensing.sense_legs(params, measured, 0, 0, sensing.MeasuredFeet(), state)
            sensing.keep_sent(state, sent)
        arms = abs(math.sin(rad(joints[2]))) * min(si.l2, si.l3) / (si.l2 + si.l3)
        assert state.force_q12[leg] == pytest.approx(force, rel=0.02, abs=6 / arms)
        found += 1
    assert found > 100


@pytest.mark.parametrize("name", NAMES)
def test_level_feet_are_the_measured_legs_turned_by_roll_and_pitch(name):
    params, dice = BLOCKS[name], random.Random(8)
    state = sensing.Sensing()
    for _ in range(200):
        roll, pitch = dice.randint(-8000, 8000), dice.randint(-8000, 8000)
        joints = array("i", [dice.randint(-20000, 20000) for _ in range(12)])
        sensing.sense_legs(params, joints, roll, pitch, sensing.MeasuredFeet(), state)
        a, b = rad(roll), rad(pitch)
        for leg in range(4):
            si = leg_si(params, leg)
            foot = forward([rad(q) for q in joints[leg * 3 : 3 + leg * 3]], si.side_l1, si.l2, si.l3)
            x, y, z = (foot[i] + si.hip[i] for i in range(3))
            x, z = math.cos(b) * x + math.sin(b) * z, -math.sin(b) * x + math.cos(b) * z
            exact = x, math.cos(a) * y - math.sin(a) * z, math.sin(a) * y + math.cos(a) * z
            got = pack(state.level[leg])
            assert math.dist([v * si.unit_m for v in got], exact) <= 12 * si.unit_m + 2e-4 * (si.l1 + si.l2 + si.l3)


def feet_near_rest(params, dice):
    """Return the four feet moved by up to an eighth of the leg from rest, in lu."""
    span = params.leg_length // 8
    rest = [params.legs[leg].rest[i] for leg in range(4) for i in range(3)]
    return unpack(Feet(), [v + dice.randint(-span, span) for v in rest])


def shared_out(feet, weights, com, weight, planar=0):
    """Return what the core makes of it, Q12."""
    state = load.Load()
    assert load.load_share(feet, array("i", weights), *com, weight, planar, state) == 1
    return state.wanted_q12


@pytest.mark.parametrize("name", NAMES)
def test_shares_on_three_and_four_feet_are_the_minimum_norm(name):
    dice = random.Random(9)
    for weights in ([256] * 4, [256, 256, 0, 256], [256, 256, 128, 256], [20, 256, 256, 256]):
        for _ in range(60):
            feet = feet_near_rest(BLOCKS[name], dice)
            corners = [[foot.x, foot.y] for foot in feet.legs]
            com = [dice.randint(-2000, 2000) for _ in range(2)]
            exact = twin.shares(
                [[v / 1e4 for v in c] for c in corners], [w / 256 for w in weights], [v / 1e4 for v in com]
            )
            if min(exact) < 0:
                continue
            got = shared_out(feet, weights, com, 4096)
            assert max(abs(got[k] - 4096 * exact[k]) for k in range(4)) <= 41
            assert sum(got) == pytest.approx(4096, abs=60)


def test_two_feet_share_by_the_lever_along_their_line():
    feet = unpack(Feet(), [15000, -15000, 0, 0, 0, 0, 0, 0, 0, -15000, 15000, 0])
    for part in (0.1, 0.5, 0.8):
        com = round(15000 - 30000 * part), round(-15000 + 30000 * part)
        for off in (-2000, 0, 3000):
            got = shared_out(feet, [256, 0, 0, 256], (com[0] + off, com[1] + off), 8192)
            assert got == pytest.approx([8192 * (1 - part), 0, 0, 8192 * part], abs=60)


def test_in_the_plane_only_x_matters():
    feet = unpack(Feet(), [15000, -15000, 0, 0, 0, 0, 0, 0, 0, -15000, 15000, 0])
    for y in (-9000, 0, 9000):
        assert shared_out(feet, [256, 0, 0, 256], (7500, y), 4096, 1) == pytest.approx([3072, 0, 0, 1024], abs=30)


def test_nobody_stands_nobody_carries_and_no_foot_pulls():
    state = load.Load()
    unpack(state, [5] * len(pack(state)))
    feet = unpack(Feet(), [15000, -15000, 0, 15000, 15000, 0, -15000, -15000, 0, -15000, 15000, 0])
    assert load.load_share(feet, array("i", [0] * 4), 0, 0, 4096, 0, state) == 0
    assert state.wanted_q12 == [0] * 4
    assert min(shared_out(feet, [256] * 4, (30000, 0), 4096)) == 0


@pytest.mark.parametrize("standing", [s for n in (2, 3, 4) for s in itertools.combinations(range(4), n)])
def test_margin_is_the_distance_to_the_nearest_edge(standing):
    dice, params = random.Random(11), BLOCKS["caramelo"]
    weights = array("i", [int(leg in standing) for leg in range(4)])
    order = [leg for leg in AROUND if leg in standing]
    for _ in range(200):
        feet = feet_near_rest(params, dice)
        point = [dice.randint(-16000, 16000) for _ in range(2)]
        exact = twin.margin([(feet.legs[leg].x, feet.legs[leg].y) for leg in order], point)
        assert abs(stability.support_margin(feet, weights, *point) - exact) <= 12


def test_margin_of_one_foot_and_of_none():
    feet = unpack(Feet(), [3000, 4000, 0] * 4)
    assert stability.support_margin(feet, array("i", [0] * 4), 0, 0) == stability.NO_SUPPORT
    assert stability.support_margin(feet, array("i", [1, 0, 0, 0]), 0, 0) == -5000
