"""The crawl's map, pose loop, goals and beginning against their float twins. Bounds in mm and mrad.

Where its feet and its body go, and when, is the machine's: test_crawl_machine.py.
"""

import math
import random
from array import array

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.body.leg import LIMIT_CALF, LIMIT_HIP, LIMIT_THIGH
from shared.crawl import contact
from shared.crawl import crawl as core_crawl
from shared.crawl import goals as crawl_goals
from shared.crawl import ground as crawl_ground
from shared.crawl import map as crawl_map
from shared.crawl import pose as crawl_pose
from shared.crawl.state import SHIFT, Crawl
from shared.record import copy, pack, unpack
from shared.sense.legs import Sensing
from tests.float_twin import crawl as twin
from tests.float_twin import crawl_carry as carry
from tests.float_twin.si import leg_si, rad

from .robots import block

RATE = 50
PARAMS = block("caramelo", RATE)
LEGS = [leg_si(PARAMS, leg) for leg in range(4)]
UNIT_M = LEGS[0].unit_m
FINE_M = UNIT_M / 256
MM = 1e-3


@pytest.fixture
def crawl():
    return Crawl(PARAMS)


def setting(which):
    """Return a setting in lu as m."""
    return getattr(PARAMS.crawl, which) * UNIT_M


def fine(metres):
    return round(metres / FINE_M)


def bf(angle_rad):
    return round(angle_rad / (2 * math.pi) * (1 << 24))


def standing(dice):
    """Return four feet near their rest stance, m, on uneven ground."""
    offsets = (0.04, 0.02, 0.02)
    return [[rest + dice.uniform(-off, off) for rest, off in zip((*leg.rest[:2], 0.0), offsets, strict=True)]
            for leg in LEGS]  # fmt: skip


def put(crawl, feet, body_m=(0.0, 0.0, 0.18), angles=(0.0, 0.0, 0.0)):
    """Write feet, body and an even load into the crawl's state."""
    for leg, foot in enumerate(feet):
        crawl.support.stance[leg], crawl.support.share_q12[leg] = 1, 4096
        unpack(crawl.map.feet[leg], [fine(value) for value in foot])
    for pose in (crawl.map.body_pose, crawl.path.wanted, crawl.path.commanded):
        unpack(pose, [fine(value) for value in body_m] + [bf(angle) for angle in angles])


def see(sensing, level_m):
    """Write where the feet are seen, level with the body."""
    for place, foot in zip(sensing.level, level_m, strict=True):
        unpack(place, [round(value / UNIT_M) for value in foot])


# --- map


@pytest.mark.parametrize("seed", range(40))
def test_heading_and_place_are_the_best_fit_of_disturbed_feet(crawl, seed):
    dice = random.Random(seed)
    feet, yaw = standing(dice), dice.uniform(-0.3, 0.3)
    place = [dice.uniform(-0.03, 0.03) for _ in range(2)] + [0.18]
    seen = [twin.turn([foot[i] - place[i] + dice.gauss(0, 0.002) for i in range(3)], -yaw) for foot in feet]
    put(crawl, feet, (0.0, 0.0, 0.17))
    shares = [dice.choice((1.0, 1.0, 0.5)) for _ in range(4)]
    sensing = Sensing()
    see(sensing, seen)
    crawl.support.share_q12[:4] = [round(4096 * share) for share in shares]
    if seed % 2:  # a foot in the air counts nothing
        lifted = dice.randrange(4)
        crawl.support.stance[lifted], shares[lifted] = 0, 0.0
        sensing.level[lifted].x += 3000
    crawl_map.fit_body(crawl, sensing)
    best = twin.heading(seen, feet, shares)
    assert abs(crawl.map.body_pose.yaw / (1 << 24) * 2 * math.pi - best) < 0.5e-3
    exact = twin.body_place(seen, feet, shares, best)
    found = [crawl.map.body_pose[axis] * FINE_M for axis in range(3)]
    assert math.dist(found, exact) < 0.15 * MM


@settings(max_examples=100)
@given(st.floats(-0.08, 0.08), st.floats(-0.5, 0.5))
def test_a_round_foot_rolls_on(turned_rad, yaw_rad):
    crawl = Crawl(PARAMS)
    put(crawl, standing(random.Random(1)), angles=(0.0, 0.0, yaw_rad))
    before = [pack(foot) for foot in crawl.map.feet]
    joints = array("i", [0, round(turned_rad / (2 * math.pi) * 65536), 0] * 4)
    crawl_map.roll_feet(crawl, joints)
    exact = twin.rolled(PARAMS.foot_radius * UNIT_M, 0.0, rad(joints[1]), yaw_rad)
    for leg in range(4):
        moved = [(crawl.map.feet[leg][i] - before[leg][i]) * FINE_M for i in range(2)]
        assert math.dist(moved, exact) < 0.02 * MM


def test_only_a_foot_that_carries_is_followed_when_it_slips(crawl):
    put(crawl, standing(random.Random(2)))
    crawl.support.force_q12[:4] = [1000, 0, 1000, 1000]
    before = [foot.z for foot in crawl.map.feet]
    for foot, measured in zip(crawl.map.feet, crawl.map.measured, strict=True):
        copy(foot, measured)
        measured.z += fine(0.02)
    crawl_map.follow_slips(crawl)
    moved = [(foot.z - z) * FINE_M for foot, z in zip(crawl.map.feet, before, strict=True)]
    assert moved[1] == 0
    assert all(moved[leg] == pytest.approx(0.02 / 0.2 / RATE, rel=0.06) for leg in (0, 2, 3))


# --- even ground


def test_astride_an_edge_is_not_even_although_four_feet_lie_on_a_slope(crawl):
    """Front feet on a step of 40 mm, hind feet below, all on one slope: the last step along it did not rise."""
    feet = [[0.125, -0.1, 0.04], [0.125, 0.1, 0.04], [-0.105, -0.1, 0.0], [-0.105, 0.1, 0.0]]
    put(crawl, feet)
    crawl.swing.departure.x, crawl.swing.target.z = fine(0.125 - 0.076), fine(0.04)
    assert crawl_ground.note_landing(crawl, 0) == 0
    crawl.swing.target.z = fine(0.04 - 0.04 * 76 / 230)
    assert crawl_ground.note_landing(crawl, 0) == 1


# --- pose


def test_the_pose_loop_follows_its_twin_for_five_seconds(crawl):
    dice = random.Random(4)
    put(crawl, standing(dice))
    c, k = crawl, crawl.params.crawl
    c.support.weight_q12 = 4096
    for axis in range(6):
        c.path.lagged[axis] = c.path.wanted[axis]
    lag, share, gain = k.lag_q15 / 32768, k.error_q15 / 32768, k.integral_q15 / 32768
    units = (FINE_M,) * 3 + (2 * math.pi / (1 << 24),) * 3
    limits = (k.position_limit << 8,) * 3 + (k.angle_limit << 8,) * 3
    started = [c.path.wanted[axis] * units[axis] for axis in range(6)]
    loops = [twin.PoseLoop(started[axis], lag, share, gain, limits[axis] * units[axis]) for axis in range(6)]
    for tick in range(250):
        for axis in range(6):
            swing_of = 0.02 * math.sin(tick / (20 + 7 * axis))
            c.path.wanted[axis] = round((0.1 + swing_of) / units[axis])
            c.map.body_pose[axis] = round((0.1 + 0.9 * swing_of - 0.004) / units[axis])
        crawl_pose.hold_pose(c)
        for axis in range(6):
            exact = loops[axis].step(c.path.wanted[axis] * units[axis], c.map.body_pose[axis] * units[axis])
            assert abs(c.path.commanded[axis] * units[axis] - exact) < 0.05 * MM


# --- swing


@pytest.mark.parametrize("tare", [-379, 0, 379])  # as far as it goes, and none
def test_ground_is_felt_after_three_loaded_ticks_of_which_one_is_above_2_7_newton(crawl, tare):
    """In parts of Caramelo's 21.6 N: 2 N are 379, 2.7 N are 512. What the hanging leg reads does not count."""

    def felt(*loads):
        crawl.contact.tare_q12, crawl.contact.load_ticks, crawl.contact.peak = tare, 0, 0
        return [contact.feel_ground(crawl.params, crawl.contact, tare + load) for load in loads]

    assert felt(400, 530, 400) == [0, 0, 1]
    assert felt(400, 490, 400, 490) == [0, 0, 0, 0]  # never above 2.7 N
    assert felt(530, 530, 0, 530, 530) == [0, 0, 0, 0, 0]  # never three in a row


# --- what is carried, and how it begins


@settings(max_examples=60)
@given(st.integers(0, 1 << 20), st.sampled_from((20, 50, 200)))
def test_the_weight_is_learnt_from_the_feet_that_stand(seed, rate_hz):
    """Within what rounding leaves of a smoothed force: half a unit over its gain."""
    c, dice, sensing = Crawl(block("caramelo", rate_hz)), random.Random(seed), Sensing()
    k = c.params.crawl
    c.support.weight_q20 = 4096 << 8
    exact = carry.Carried(1.0, k.force_q15 / 32768, k.weight_q15 / 32768)
    for tick in range(400):
        if tick % 100 == 0:
            heavy, stands = dice.choice((0.1, 0.25, 0.5, 1.2)), [int(leg != tick // 100) for leg in range(4)]
            c.support.stance[:4] = stands
        forces = [round(dice.gauss(heavy, 0.2) * 4096) for _ in range(4)]
        sensing.force_q12[:] = forces
        core_crawl.update_weight(c.params, sensing, c.support)
        weight, load = exact.step([force / 4096 for force in forces], stands)
        assert abs(c.support.weight_q12 / 4096 - weight) < 0.004
        assert abs(c.support.payload_q12 / 4096 - load) < 0.008


@pytest.mark.parametrize("seed", range(20))
def test_a_crawl_begins_under_the_body_on_its_feet(crawl, seed):
    dice = random.Random(seed)
    level = [[x, y, z - 0.18] for x, y, z in standing(dice)]
    tilt, felt = [dice.uniform(-0.1, 0.1) for _ in range(2)], [dice.uniform(0.0, 0.8) for _ in range(4)]
    sensing, joints = Sensing(), array("i")
    for foot, shape in zip(level, LEGS, strict=True):
        angles = twin.leg_joints(foot, [0.0] * 6, shape)
        joints.extend(round((angle + dice.uniform(-0.05, 0.05)) / (2 * math.pi) * 65536) for angle in angles)
    see(sensing, level)
    sensing.force_q12[:] = [round(force * 4096) for force in felt]
    roll, pitch = (round(angle / (2 * math.pi) * 65536) for angle in tilt)
    core_crawl.crawl_start(crawl, sensing, joints, joints, roll, pitch)
    c = crawl
    feet, pose, weight = carry.start(level, felt, tilt[1], tilt[0])
    for leg in range(4):
        assert math.dist([v * FINE_M for v in pack(c.map.feet[leg])], feet[leg]) < 0.02 * MM
    for found in (c.map.body_pose, c.path.wanted, c.path.commanded, c.path.lagged, c.path.from_pose):
        assert math.dist([v * FINE_M for v in pack(found)[:3]], pose[:3]) < 0.02 * MM
        assert math.dist([v / (1 << 24) * 2 * math.pi for v in pack(found)[3:]], pose[3:]) < 0.2e-3
    assert abs(c.support.weight_q12 / 4096 - weight) < 1e-3
    assert (c.stage.stage, c.stage.leg, list(c.support.stance[:4])) == (SHIFT, 3, [1, 1, 1, 1])
    goals = [0] * 12
    assert crawl_goals.legs_goals(crawl, goals) & (LIMIT_HIP | LIMIT_THIGH | LIMIT_CALF) == 0
    assert max(abs(a - b) for a, b in zip(goals, joints, strict=True)) <= 1  # those sent last


# --- goals


@pytest.mark.parametrize("seed", range(60))
def test_the_planned_loads_are_the_minimum_norm_and_their_margin(crawl, seed):
    """Bars as load_share's own: 1 % of the weight. A foot that would have to pull is another function's matter."""
    dice = random.Random(seed)
    feet, pose = standing(dice), [dice.uniform(-0.02, 0.02), dice.uniform(-0.02, 0.02), 0.18, 0.0]
    pose += [dice.uniform(-0.2, 0.2), 0.0]
    put(crawl, feet, pose[:3], pose[3:])
    shares = [dice.choice((1.0, 1.0, 0.5)) for _ in range(4)]
    if seed % 2:
        shares[dice.randrange(4)] = 0.0
    c, weight = crawl, dice.uniform(0.8, 2.4)
    c.support.weight_q12 = round(weight * 4096)
    for leg, share in enumerate(shares):
        c.support.stance[leg], c.support.share_q12[leg] = int(share > 0), round(share * 4096)
    margin = crawl_goals.plan_loads(c) * UNIT_M
    com = PARAMS.com_x * UNIT_M, setting("com_z")
    loads, exact = carry.planned_loads(feet, shares, pose, com, weight)
    assert abs(margin - exact) < 0.15 * MM
    if min(loads) >= 0:
        found = [value / 4096 for value in c.support.load_q12[:4]]
        assert max(abs(a - b) for a, b in zip(found, loads, strict=True)) < 0.01 * weight + 0.001


@pytest.mark.parametrize("lifts", [1, 0])
@pytest.mark.parametrize("seed", range(40))
def test_all_goals_stance_swing_and_what_is_left_of_a_jump(crawl, seed, lifts):
    """Nothing sags without load. A leg that lifts or lands goes on from its last goal; the jump fades tick by tick."""
    dice, c, leg = random.Random(seed), crawl, seed % 4
    feet, angles = standing(dice), [dice.uniform(-0.1, 0.1) for _ in range(3)]
    place = [dice.uniform(-0.02, 0.02), dice.uniform(-0.02, 0.02), 0.165]
    put(crawl, feet, place, angles)
    commanded = [*place, *angles]
    wanted = [value + dice.uniform(-0.004, 0.004) for value in commanded]
    low = [dice.uniform(-0.004, 0.004) for _ in range(6)]
    for axis in range(6):
        unit = fine if axis < 3 else bf
        c.path.wanted[axis], c.path.deviation[axis] = unit(wanted[axis]), unit(low[axis])
    air, offset = [feet[leg][0], feet[leg][1], feet[leg][2] + 0.02], dice.uniform(-0.01, 0.01)
    unpack(c.swing.place, [fine(value) for value in air])
    c.support.diagonal_offset, c.support.stance[leg], c.stage.leg = fine(offset), 1 - lifts, leg
    stands = [other != leg or not lifts for other in range(4)]
    exact = carry.goals(feet, stands, air, wanted, low, commanded, offset, LEGS)
    before = [round((angle + 0.03) / (2 * math.pi) * 65536) for angle in exact[leg]]
    c.goals[leg * 3 : leg * 3 + 3] = before
    crawl_goals.absorb_jump(crawl, leg, lifts)
    gain = crawl.params.crawl.jump_q15 if lifts else crawl.params.crawl.land_jump_q15
    left, goals = 1.0, [0] * 12
    for _ in range(30):
        if crawl_goals.legs_goals(crawl, goals):
            return  # out of reach: another function's matter
        for other in range(4):
            for joint in range(3):
                jump = left * 0.03 if other == leg else 0.0
                assert abs(rad(goals[other * 3 + joint]) - exact[other][joint] - jump) < 2e-3
        assert left < 1.0 or max(abs(a - b) for a, b in zip(goals[leg * 3 :], before, strict=False)) <= 1
        left *= 1 - gain / 32768


@pytest.mark.parametrize("seed", range(40))
def test_a_leg_puts_its_foot_where_the_map_has_it(crawl, seed):
    """Without load nothing sags, so the angles are the exact leg's under heading, roll and pitch."""
    dice = random.Random(seed)
    feet, angles = standing(dice), [dice.uniform(-0.15, 0.15) for _ in range(3)]
    place = [dice.uniform(-0.02, 0.02), dice.uniform(-0.02, 0.02), 0.165]
    put(crawl, feet, place, angles)
    crawl_goals.take_pose(crawl, 0)
    for leg, shape in enumerate(LEGS):
        if crawl_goals.leg_goal(crawl, leg, 0):
            continue  # out of reach: another function's matter
        exact = twin.leg_joints(feet[leg], [*place, *angles], shape)
        found = [rad(crawl.joints[leg * 3 + joint]) for joint in range(3)]
        assert max(abs(a - b) for a, b in zip(found, exact, strict=True)) < 2e-3
