"""The crawl stage by stage against its float twin: map, pose, swing, goals, handing over. Bounds in mm and mrad."""

import math
import random
from array import array

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared import (
    body,
    contact,
    crawl_even,
    crawl_goals,
    crawl_map,
    crawl_pose,
    footholds,
    handover,
    retreat,
    swing_leg,
)
from shared import crawl as core_crawl
from shared import crawl_layout as at
from shared.command import COMMAND_SIZE
from shared.crawl import Crawl
from shared.planner_layout import LIMIT_FLAGS
from shared.sensing import M_FORCE_Q12, SENSING_SIZE
from tests.float_twin import crawl as twin
from tests.float_twin import crawl_carry as carry
from tests.float_twin import crawl_plan as plan
from tests.float_twin import crawl_swing as swing

from .bars import integers, repeatable
from .robots import block, leg_si, rad

RATE = 50
PARAMS = block("caramelo", RATE)
LEGS = [leg_si(PARAMS, leg) for leg in range(4)]
UNIT_M = LEGS[0].unit_m
FINE_M = UNIT_M / 256
MM = 1e-3


@pytest.fixture
def crawl():
    return Crawl(PARAMS)


def setting(crawl, which):
    """Return a setting in lu as m."""
    return crawl.settings[which] * UNIT_M


def fine(metres):
    return round(metres / FINE_M)


def bf(angle_rad):
    return round(angle_rad / (2 * math.pi) * (1 << 24))


def standing(dice, slope=0.0, uneven=0.02):
    """Return four feet near their rest stance, m, on a slope along x and uneven ground."""
    feet = []
    for leg in LEGS:
        x = leg.hip[0] + leg.rest[0] - leg.hip[0] + dice.uniform(-0.04, 0.04)
        feet.append([x, leg.rest[1] + dice.uniform(-0.02, 0.02), slope * x + dice.uniform(-uneven, uneven)])
    return feet


def put(crawl, feet, body_m=(0.0, 0.0, 0.18), angles=(0.0, 0.0, 0.0)):
    """Write feet, body and an even load into the crawl's state."""
    c = crawl.state
    for leg, foot in enumerate(feet):
        c[at.C_STANDS + leg], c[at.C_SHARE + leg] = 1, 4096
        for axis in range(3):
            c[at.C_FOOT + leg * 3 + axis] = fine(foot[axis])
    for axis in range(3):
        for place in (at.C_BODY, at.C_REF, at.C_CMD):
            c[place + axis] = fine(body_m[axis])
            c[place + 3 + axis] = bf(angles[axis])


# --- map


@pytest.mark.parametrize("seed", range(40))
def test_heading_and_place_are_the_best_fit_of_disturbed_feet(crawl, seed):
    dice = random.Random(seed)
    feet, yaw = standing(dice), dice.uniform(-0.3, 0.3)
    place = [dice.uniform(-0.03, 0.03) for _ in range(2)] + [0.18]
    seen = [twin.turn([foot[i] - place[i] + dice.gauss(0, 0.002) for i in range(3)], -yaw) for foot in feet]
    put(crawl, feet, (0.0, 0.0, 0.17))
    shares = [dice.choice((1.0, 1.0, 0.5)) for _ in range(4)]
    sensing = array("i", [0] * SENSING_SIZE)
    for leg in range(4):
        crawl.state[at.C_SHARE + leg] = round(4096 * shares[leg])
        for axis in range(3):
            sensing.level[leg * 3 + axis] = round(seen[leg][axis] / UNIT_M)
    crawl_map.fit_body(crawl.settings, sensing, crawl.state)
    best = twin.heading(seen, feet, shares)
    assert abs(crawl.state[at.C_BODY + 5] / (1 << 24) * 2 * math.pi - best) < 0.5e-3
    exact = twin.body_place(seen, feet, shares, best)
    found = [crawl.state[at.C_BODY + axis] * FINE_M for axis in range(3)]
    assert math.dist(found, exact) < 0.15 * MM


@repeatable(100)
@given(st.floats(-0.08, 0.08), st.floats(-0.5, 0.5))
def test_a_round_foot_rolls_on(turned_rad, yaw_rad):
    crawl = Crawl(PARAMS)
    put(crawl, standing(random.Random(1)), angles=(0.0, 0.0, yaw_rad))
    before = list(crawl.state[: at.C_FOOT + 12])
    joints = array("i", [0, round(turned_rad / (2 * math.pi) * 65536), 0] * 4)
    crawl_map.roll_feet(crawl.settings, joints, crawl.state)
    exact = twin.rolled(PARAMS.foot_radius * UNIT_M, 0.0, rad(joints[1]), yaw_rad)
    for leg in range(4):
        moved = [(crawl.state[at.C_FOOT + leg * 3 + i] - before[at.C_FOOT + leg * 3 + i]) * FINE_M for i in range(2)]
        assert math.dist(moved, exact) < 0.02 * MM


def test_only_a_foot_that_carries_is_followed_when_it_slips(crawl):
    put(crawl, standing(random.Random(2)))
    c = crawl.state
    c[at.C_FORCE : at.C_FORCE + 4] = array("i", [1000, 0, 1000, 1000])
    for leg in range(4):
        for axis in range(3):
            c[at.C_SEEN + leg * 3 + axis] = c[at.C_FOOT + leg * 3 + axis]
        c[at.C_SEEN + leg * 3 + 2] += fine(0.02)
    before = [c[at.C_FOOT + leg * 3 + 2] for leg in range(4)]
    crawl_map.follow_slips(crawl.settings, c)
    moved = [(c[at.C_FOOT + leg * 3 + 2] - before[leg]) * FINE_M for leg in range(4)]
    assert moved[1] == 0
    assert all(moved[leg] == pytest.approx(0.02 / 0.2 / RATE, rel=0.06) for leg in (0, 2, 3))


# --- even ground


@pytest.mark.parametrize("seed", range(60))
def test_even_ground_is_what_lies_on_one_slope(crawl, seed):
    dice = random.Random(seed)
    feet, leg = standing(dice, dice.uniform(-0.2, 0.2), dice.choice((0.0, 0.003, 0.01))), seed % 4
    put(crawl, feet)
    came_from = feet[leg][0] - 0.076, feet[leg][2] - dice.uniform(-0.02, 0.02)
    crawl.state[at.C_SOURCE], crawl.state[at.C_TARGET + 2] = fine(came_from[0]), fine(came_from[1])
    crawl.state[at.C_STEPS_EVEN] = 5
    count = crawl_even.count_even(crawl.settings, crawl.state, leg)
    exact, found = twin.uneven(feet, leg, came_from), crawl.state[at.C_EVEN] * UNIT_M
    assert abs(found - exact) < 0.15 * MM
    if abs(exact - setting(crawl, at.K_VOID) / 3) > 0.2 * MM:
        assert count == (6 if exact < setting(crawl, at.K_VOID) / 3 else 0)


def test_astride_an_edge_is_not_even_although_four_feet_lie_on_a_slope(crawl):
    """Front feet on a step of 40 mm, hind feet below, all on one slope: the last step along it did not rise."""
    feet = [[0.125, -0.1, 0.04], [0.125, 0.1, 0.04], [-0.105, -0.1, 0.0], [-0.105, 0.1, 0.0]]
    put(crawl, feet)
    crawl.state[at.C_SOURCE], crawl.state[at.C_TARGET + 2] = fine(0.125 - 0.076), fine(0.04)
    assert crawl_even.count_even(crawl.settings, crawl.state, 0) == 0
    crawl.state[at.C_TARGET + 2] = fine(0.04 - 0.04 * 76 / 230)
    assert crawl_even.count_even(crawl.settings, crawl.state, 0) == 1


@pytest.mark.parametrize("slope", [-0.2, -0.03, 0.03, 0.2])
def test_a_front_foot_expects_its_ground_on_a_slope_it_is_sure_of(crawl, slope):
    """4 mm over the step are level: what sag and odometry err."""
    feet = standing(random.Random(6), slope, 0.0)
    put(crawl, feet)
    rise = slope * (swing.front_target(feet[0][0], feet[1][0], setting(crawl, at.K_STRIDE)) - feet[0][0])
    for landings, exact in ((2, 0.0), (3, rise if abs(rise) > 4 * MM else 0.0)):
        crawl.state[at.C_STEPS_EVEN] = landings
        footholds.aim(crawl.limbs, crawl.settings, crawl.state, 0)
        assert crawl.state[at.C_EXPECT] * FINE_M - feet[0][2] == pytest.approx(exact, abs=0.1 * MM)


# --- pose


@pytest.mark.parametrize("seed", range(40))
def test_the_body_pitches_with_the_slope_of_the_feet(crawl, seed):
    dice = random.Random(seed)
    feet = standing(dice, dice.uniform(-0.5, 0.5))
    put(crawl, feet)
    found = rad(crawl_pose.feet_pitch(crawl.settings, crawl.state))
    assert abs(found - twin.slope_pitch(feet, setting(crawl, at.K_ARM_X) * 2 / 3)) < 0.4e-3


@pytest.mark.parametrize("seed", range(40))
def test_the_body_goes_over_the_point_as_high_as_its_legs_reach_and_takes_its_time(crawl, seed):
    dice = random.Random(seed)
    feet = standing(dice, dice.uniform(-0.2, 0.2))
    put(crawl, feet)
    wanted = [dice.uniform(-0.04, 0.04), dice.uniform(-0.03, 0.03)]
    crawl.point[0], crawl.point[1] = (round(value / UNIT_M) for value in wanted)
    ticks = crawl_pose.plan_body(crawl.limbs, crawl.settings, crawl.state, crawl.point, -1, crawl.pose, crawl.rotation,
                                 crawl.feet, crawl.hip_feet)
    to = [crawl.state[at.C_TO + axis] for axis in range(6)]
    pitch = twin.slope_pitch(feet, setting(crawl, at.K_ARM_X) * 2 / 3)
    com = setting(crawl, at.K_COM_X), setting(crawl, at.K_COM_Z)
    place = wanted[0] - twin.mass_ahead(com, pitch), wanted[1]
    assert math.dist((to[0] * FINE_M, to[1] * FINE_M), place) < 0.1 * MM
    sides = [leg.side_l1 for leg in LEGS]
    height = twin.body_height(feet, [leg.hip for leg in LEGS], sides, place, pitch, setting(crawl, at.K_HEIGHT),
                              setting(crawl, at.K_REACH))
    found = to[2] * FINE_M - twin.middle(feet)[2]
    assert -2.5 * MM < found - height < 0.3 * MM  # the core stops a little lower: it lowers by what the legs miss
    way = math.hypot(*(to[axis] * FINE_M - (0.0, 0.0)[axis] for axis in range(2)))
    seconds = twin.move_seconds(way, to[2] * FINE_M - 0.18, pitch, setting(crawl, at.K_ARM_X), 0.6, 0.06, 0.25)
    assert abs(ticks / RATE - seconds) <= 1.6 / RATE + 0.02 * seconds


@repeatable(400)
@given(st.integers(0, 1 << 20), st.integers(0, 3), st.floats(-0.06, 0.06), st.booleans())
def test_the_mass_goes_to_the_nearest_point_inside_the_support(seed, leg, wanted_m, planar):
    crawl, dice = Crawl(PARAMS), random.Random(seed)
    feet = standing(dice)
    put(crawl, feet)
    crawl.settings[at.K_PLANAR] = int(planar)
    wanted = round(wanted_m / UNIT_M)
    crawl_pose.mass_target(crawl.settings, crawl.state, leg, wanted, crawl.feet, crawl.weights, crawl.point)
    exact = plan.mass_target(feet, leg, wanted * UNIT_M, setting(crawl, at.K_MARGIN), planar)
    assert math.dist([value * UNIT_M for value in crawl.point], exact) < 0.2 * MM


def test_a_bodys_move_is_the_quintic(crawl):
    put(crawl, standing(random.Random(3)))
    c = crawl.state
    for axis in range(6):
        c[at.C_FROM + axis], c[at.C_TO + axis] = 1000 * axis, 200000 - 90000 * axis
    c[at.C_BODY_TICK], c[at.C_BODY_TICKS] = 0, 40
    for tick in range(1, 41):
        assert crawl_pose.move_body(c) == 1
        for axis in range(6):
            exact = 1000 * axis + twin.quintic(tick / 40) * (200000 - 91000 * axis)
            assert abs(c[at.C_REF + axis] - exact) <= 0.0025 * 350000
    assert crawl_pose.move_body(c) == 0


def test_the_pose_loop_follows_its_twin_for_five_seconds(crawl):
    dice = random.Random(4)
    put(crawl, standing(dice))
    c, k = crawl.state, crawl.settings
    c[at.C_WEIGHT] = 4096
    for axis in range(6):
        c[at.C_LAGGED + axis] = c[at.C_REF + axis]
    lag, gain = k[at.K_LAG] / 32768, k[at.K_KI] / 32768
    units = (FINE_M,) * 3 + (2 * math.pi / (1 << 24),) * 3
    limits = (k[at.K_LIMIT_X],) * 3 + (k[at.K_LIMIT_A],) * 3
    started = [c[at.C_REF + axis] * units[axis] for axis in range(6)]
    loops = [twin.PoseLoop(started[axis], lag, gain, limits[axis] * units[axis]) for axis in range(6)]
    for tick in range(250):
        for axis in range(6):
            swing_of = 0.02 * math.sin(tick / (20 + 7 * axis))
            c[at.C_REF + axis] = round((0.1 + swing_of) / units[axis])
            c[at.C_BODY + axis] = round((0.1 + 0.9 * swing_of - 0.004) / units[axis])
        crawl_pose.hold_pose(k, c)
        for axis in range(6):
            exact = loops[axis].step(c[at.C_REF + axis] * units[axis], c[at.C_BODY + axis] * units[axis])
            assert abs(c[at.C_CMD + axis] * units[axis] - exact) < 0.05 * MM


# --- swing


@pytest.mark.parametrize("side", [0, 1])
def test_the_first_prints_lie_between_hind_and_front_foot(crawl, side):
    feet = standing(random.Random(5 + side))
    put(crawl, feet)
    footholds.prints_start(crawl.limbs, crawl.state)
    hind, front = feet[2 + side], feet[side]
    for place, exact in enumerate(swing.first_prints((hind[0], hind[2]), (front[0], front[2]), side)):
        print_at = at.C_PRINT + side * 12 + place * 3
        found = crawl.state[print_at] * FINE_M, crawl.state[print_at + 2] * FINE_M
        assert math.dist(found, exact) < 0.01 * MM


@pytest.mark.parametrize("seed", range(40))
def test_a_front_foot_aims_half_a_stride_beyond_the_other(crawl, seed):
    dice = random.Random(seed)
    feet, leg = standing(dice, uneven=0.05), seed % 2
    put(crawl, feet)
    footholds.aim(crawl.limbs, crawl.settings, crawl.state, leg)
    own, other, stride = feet[leg], feet[1 - leg], setting(crawl, at.K_STRIDE)
    target = swing.front_target(own[0], other[0], stride)
    assert abs(crawl.state[at.C_TARGET] * FINE_M - target) < 0.05 * MM
    assert crawl.state[at.C_EXPECT] == crawl.state[at.C_FOOT + leg * 3 + 2]
    hit = setting(crawl, at.K_HIT)
    if abs(other[0] - target - hit * 5 / 3) > 0.1 * MM:
        top = swing.front_top(own[2], other[2], other[0], target, setting(crawl, at.K_LIFT_FRONT), hit)
        assert abs(crawl.state[at.C_TOP] * FINE_M - top) < 0.05 * MM


@repeatable(40)
@given(st.floats(0.02, 0.07))
def test_a_foot_goes_up_as_its_twin_and_stops_at_the_top(lift_m):
    crawl = Crawl(PARAMS)
    c, k = crawl.state, crawl.settings
    c[at.C_TOP], c[at.C_LENGTH] = fine(lift_m), 32767
    units = FINE_M * RATE
    exact = swing.rise(0.0, lift_m, k[at.K_V_UP] * units, k[at.K_A_UP] * units * RATE,
                       k[at.K_BRAKE] * units * RATE / 2, k[at.K_V_TOP] * units, 1 / RATE, 60)
    there = 0
    for height in exact:
        there = there or swing_leg.lift_foot(k, c)
        assert abs(c[at.C_POS + 2] * FINE_M - height) < 0.6 * MM
    assert there == 1
    assert c[at.C_POS + 2] == c[at.C_TOP]


@repeatable(100)
@given(st.floats(0.0, 0.08))
def test_a_hind_foot_comes_down_so_that_it_can_slow_down(above_m):
    crawl = Crawl(PARAMS)
    c, k = crawl.state, crawl.settings
    c[at.C_POS + 2] = fine(above_m) + (k[at.K_NEAR_PRINT] << 8)
    found = swing_leg.fall_speed(k, c, 3) * FINE_M * RATE
    brake = k[at.K_A_DOWN] * FINE_M * RATE * RATE
    exact = swing.fall_speed(above_m, k[at.K_V_SLOW] * FINE_M * RATE, k[at.K_V_REAR] * FINE_M * RATE, brake)
    assert abs(found - exact) < 0.003
    assert swing_leg.fall_speed(k, c, 0) == k[at.K_V_FRONT]


@repeatable(100)
@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.integers(0, 3))
def test_a_corner_of_the_body_is_pushed_up(nose_up, left_up, leg):
    crawl = Crawl(PARAMS)
    c = crawl.state
    c[at.C_BODY + body.POSE_PITCH], c[at.C_BODY + body.POSE_ROLL] = bf(-nose_up), bf(left_up)
    exact = swing.corner_lift(nose_up, left_up, setting(crawl, at.K_ARM_X), setting(crawl, at.K_ARM_Y), leg)
    assert abs(contact.corner_lift(crawl.settings, c, leg) * UNIT_M - exact) < 0.1 * MM


@repeatable(100)
@given(integers(0, 3), st.floats(0.0, 0.06), st.floats(0.03, 0.1))
def test_a_riser_is_felt_by_how_late_the_foot_is(leg, behind_m, way_m):
    crawl = Crawl(PARAMS)
    c, k = crawl.state, crawl.settings
    ticks = 24
    c[at.C_TICK], c[at.C_MOVE_TICKS], c[at.C_TARGET], c[at.C_SOURCE] = 20, ticks, fine(way_m), 0
    for place in range(at.PAST_SIZE):
        c[at.C_PAST + place] = fine(behind_m)
    late = swing.held_up(behind_m, setting(crawl, at.K_HIT), way_m, (ticks + 1) / RATE, k[at.K_HIT_LAG] / RATE)
    margin = behind_m - setting(crawl, at.K_HIT) - way_m / ((ticks + 1) / RATE) * k[at.K_HIT_LAG] / RATE
    if abs(margin) > 0.05 * MM:
        assert bool(contact.feel_riser(k, c, leg)) == late


@pytest.mark.parametrize("tare", [-400, 0, 700])
def test_ground_is_felt_after_three_loaded_ticks_of_which_one_is_above_4_newton(crawl, tare):
    """In parts of Caramelo's 21.6 N: 3 N are 569, 4 N are 758. What the hanging leg reads does not count."""
    c, k = crawl.state, crawl.settings

    def felt(*loads):
        c[at.C_TARE], c[at.C_TOUCHED], c[at.C_PEAK] = tare, 0, 0
        answers = []
        for load in loads:
            c[at.C_FORCE] = tare + load
            answers.append(contact.feel_ground(k, c, 0))
        return answers

    assert felt(600, 800, 600) == [0, 0, 1]
    assert felt(600, 700, 600, 700) == [0, 0, 0, 0]  # never above 4 N
    assert felt(800, 800, 0, 800, 800) == [0, 0, 0, 0, 0]  # never three in a row


@repeatable(100)
@given(st.floats(-0.002, 0.004), st.integers(20, 500))
def test_backing_off_ends_after_a_third_of_a_leg_or_six_seconds_and_half_a_second_of_standing(back_m, rate_hz):
    params = block("caramelo", rate_hz)
    command, state = array("i", [0] * COMMAND_SIZE), array("i", [0] * retreat.RETREAT_SIZE)
    ticks = 0
    while not retreat.retreat_step(params, command, -fine(back_m), int(ticks > 0), state):
        ticks += 1
        assert state.speed[0] <= 0
        assert ticks < 8 * rate_hz
    by_way = math.ceil(0.3 * 0.24 / back_m) if back_m > 1e-5 else math.inf
    assert abs(ticks - min(by_way, 6 * rate_hz) - rate_hz / 2) <= 3 + 0.001 * ticks


# --- what is carried, and how it begins


@repeatable(60)
@given(st.integers(0, 1 << 20), st.sampled_from((20, 50, 200)))
def test_the_weight_is_learnt_from_the_feet_that_stand(seed, rate_hz):
    """Within what rounding leaves of a smoothed force: half a unit over its gain."""
    crawl, dice = Crawl(block("caramelo", rate_hz)), random.Random(seed)
    c, k, sensing = crawl.state, crawl.settings, array("i", [0] * SENSING_SIZE)
    c[at.C_WEIGHT_FINE] = 4096 << 8
    exact = carry.Carried(1.0, k[at.K_FORCE] / 32768, k[at.K_WEIGHT] / 32768)
    for tick in range(400):
        if tick % 100 == 0:
            heavy, stands = dice.choice((0.1, 0.25, 0.5, 1.2)), [int(leg != tick // 100) for leg in range(4)]
            c[at.C_STANDS : at.C_STANDS + 4] = stands
        forces = [round(dice.gauss(heavy, 0.2) * 4096) for _ in range(4)]
        sensing[M_FORCE_Q12 : M_FORCE_Q12 + 4] = array("i", forces)
        core_crawl.weigh(k, sensing, c)
        weight, load = exact.step([force / 4096 for force in forces], stands)
        assert abs(c[at.C_WEIGHT] / 4096 - weight) < 0.004
        assert abs(c[at.C_HEAVY] / 4096 - load) < 0.008


@pytest.mark.parametrize("seed", range(20))
def test_a_crawl_begins_under_the_body_on_its_feet(crawl, seed):
    dice = random.Random(seed)
    level = [[x, y, z - 0.18] for x, y, z in standing(dice)]
    tilt, felt = [dice.uniform(-0.1, 0.1) for _ in range(2)], [dice.uniform(0.0, 0.8) for _ in range(4)]
    sensing, joints = array("i", [0] * SENSING_SIZE), array("i")
    for foot, shape in zip(level, LEGS, strict=True):
        angles = twin.leg_joints(foot, [0.0] * 6, shape.hip, shape.side_l1, shape.l2, shape.l3, shape.knee)
        joints.extend(round((angle + dice.uniform(-0.05, 0.05)) / (2 * math.pi) * 65536) for angle in angles)
    for leg in range(4):
        sensing.force_q12[leg] = round(felt[leg] * 4096)
        for axis in range(3):
            sensing.level[leg * 3 + axis] = round(level[leg][axis] / UNIT_M)
    roll, pitch = (round(angle / (2 * math.pi) * 65536) for angle in tilt)
    core_crawl.crawl_start(crawl, sensing, joints, 0, joints, roll, pitch)
    c = crawl.state
    feet, pose, weight = carry.start(level, felt, tilt[1], tilt[0])
    for leg in range(4):
        assert math.dist([v * FINE_M for v in c[at.C_FOOT + leg * 3 :][:3]], feet[leg]) < 0.02 * MM
    for place in (at.C_BODY, at.C_REF, at.C_CMD, at.C_LAGGED, at.C_FROM):
        assert math.dist([v * FINE_M for v in c[place : place + 3]], pose[:3]) < 0.02 * MM
        assert math.dist([v / (1 << 24) * 2 * math.pi for v in c[place + 3 : place + 6]], pose[3:]) < 0.2e-3
    assert abs(c[at.C_WEIGHT] / 4096 - weight) < 1e-3
    assert (c[at.C_PHASE], c[at.C_LEG], list(c[at.C_STANDS : at.C_STANDS + 4])) == (at.SHIFT, 3, [1, 1, 1, 1])
    goals = [0] * 12
    assert crawl_goals.legs_goals(crawl, goals) & LIMIT_FLAGS == 0
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
    c, weight = crawl.state, dice.uniform(0.8, 2.4)
    c[at.C_WEIGHT] = round(weight * 4096)
    for leg, share in enumerate(shares):
        c[at.C_STANDS + leg], c[at.C_SHARE + leg] = int(share > 0), round(share * 4096)
    margin = crawl_goals.share_load(crawl.settings, c, crawl.feet, crawl.weights, crawl.load) * UNIT_M
    com = setting(crawl, at.K_COM_X), setting(crawl, at.K_COM_Z)
    loads, exact = carry.planned_loads(feet, shares, pose, com, weight)
    assert abs(margin - exact) < 0.15 * MM
    if min(loads) >= 0:
        found = [value / 4096 for value in c[at.C_LOAD : at.C_LOAD + 4]]
        assert max(abs(a - b) for a, b in zip(found, loads, strict=True)) < 0.01 * weight + 0.001


@pytest.mark.parametrize("seed", range(40))
def test_all_goals_stance_swing_and_what_is_left_of_a_jump(crawl, seed):
    """Nothing sags without load. A leg that changes goes on from its last goal; the jump fades tick by tick."""
    dice, c, leg = random.Random(seed), crawl.state, seed % 4
    feet, angles = standing(dice), [dice.uniform(-0.1, 0.1) for _ in range(3)]
    place = [dice.uniform(-0.02, 0.02), dice.uniform(-0.02, 0.02), 0.165]
    put(crawl, feet, place, angles)
    commanded = [*place, *angles]
    wanted = [value + dice.uniform(-0.004, 0.004) for value in commanded]
    low = [dice.uniform(-0.004, 0.004) for _ in range(6)]
    for axis in range(6):
        unit = fine if axis < 3 else bf
        c[at.C_REF + axis], c[at.C_LOW + axis] = unit(wanted[axis]), unit(low[axis])
    air, warp = [feet[leg][0], feet[leg][1], feet[leg][2] + 0.02], dice.uniform(-0.01, 0.01)
    c[at.C_POS : at.C_POS + 3] = [fine(value) for value in air]
    c[at.C_WARP], c[at.C_STANDS + leg], c[at.C_LEG] = fine(warp), 0, leg
    stands = [other != leg for other in range(4)]
    exact = carry.goals(feet, stands, air, wanted, low, commanded, warp, LEGS)
    before = [round((angle + 0.03) / (2 * math.pi) * 65536) for angle in exact[leg]]
    c[at.C_GOAL + leg * 3 : at.C_GOAL + leg * 3 + 3] = before
    crawl_goals.bridge(crawl, leg, 1)
    left, goals = 1.0, [0] * 12
    for _ in range(30):
        if crawl_goals.legs_goals(crawl, goals):
            return  # out of reach: another function's matter
        for other in range(4):
            for joint in range(3):
                jump = left * 0.03 if other == leg else 0.0
                assert abs(rad(goals[other * 3 + joint]) - exact[other][joint] - jump) < 2e-3
        assert left < 1.0 or max(abs(a - b) for a, b in zip(goals[leg * 3 :], before, strict=False)) <= 1
        left *= 1 - crawl.settings[at.K_FADE] / 32768


@pytest.mark.parametrize("seed", range(40))
def test_a_leg_puts_its_foot_where_the_map_has_it(crawl, seed):
    """Without load nothing sags, so the angles are the exact leg's under heading, roll and pitch."""
    dice = random.Random(seed)
    feet, angles = standing(dice), [dice.uniform(-0.15, 0.15) for _ in range(3)]
    place = [dice.uniform(-0.02, 0.02), dice.uniform(-0.02, 0.02), 0.165]
    put(crawl, feet, place, angles)
    crawl_goals.take_pose(crawl.state, 0, crawl.pose, crawl.rotation)
    for leg, shape in enumerate(LEGS):
        if crawl_goals.leg_goal(crawl, leg, 0):
            continue  # out of reach: another function's matter
        exact = twin.leg_joints(feet[leg], [*place, *angles], shape.hip, shape.side_l1, shape.l2, shape.l3, shape.knee)
        found = [rad(crawl.joints[leg * 3 + joint]) for joint in range(3)]
        assert max(abs(a - b) for a, b in zip(found, exact, strict=True)) < 2e-3


@pytest.mark.parametrize("seed", range(20))
def test_the_trot_finds_its_feet_where_the_crawl_left_them(crawl, seed):
    dice = random.Random(seed)
    feet, yaw = standing(dice), dice.uniform(-0.4, 0.4)
    place = [dice.uniform(-0.03, 0.03), dice.uniform(-0.03, 0.03), 0.17]
    put(crawl, feet, place, (0.0, 0.0, yaw))
    steps = array("i", [0] * 200)
    handover.steps_from_crawl(PARAMS, crawl.state, 600, -300, steps)
    for leg in range(4):
        first = leg * handover.STEP_SIZE
        found = steps[first + handover.STEP_X] * FINE_M, steps[first + handover.STEP_Y] * FINE_M
        exact = twin.trot_foothold(feet[leg], [*place, 0.0, 0.0, yaw], 600 * UNIT_M, -300 * UNIT_M)
        assert math.dist(found, exact) < 0.1 * MM
