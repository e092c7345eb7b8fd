"""The crawl stage by stage against its float twin: map, pose, swing, goals, handing over. Bounds in mm and mrad."""

import math
import random
from array import array

import pytest
from hypothesis import given
from hypothesis import strategies as st

from shared.body.leg import LIMIT_CALF, LIMIT_HIP, LIMIT_THIGH
from shared.crawl import contact, footholds
from shared.crawl import crawl as core_crawl
from shared.crawl import goals as crawl_goals
from shared.crawl import ground as crawl_ground
from shared.crawl import map as crawl_map
from shared.crawl import pose as crawl_pose
from shared.crawl import swing as swing_leg
from shared.crawl.state import HISTORY_TICKS, SHIFT, Crawl
from shared.planner import retreat
from shared.planner.command import Command
from shared.record import copy, pack, unpack
from shared.sense.legs import Sensing
from tests.float_twin import crawl as twin
from tests.float_twin import crawl_carry as carry
from tests.float_twin import crawl_plan as plan
from tests.float_twin import crawl_swing as swing
from tests.float_twin.si import leg_si, rad

from .bars import integers, repeatable
from .robots import block

RATE = 50
PARAMS, PLANAR = block("caramelo", RATE), block("caramelo", RATE)
PLANAR.lateral_q12 = 0
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


def standing(dice, slope=0.0, uneven=0.02):
    """Return four feet near their rest stance, m, on a slope along x and uneven ground."""
    feet = []
    for leg in LEGS:
        x = leg.rest[0] + dice.uniform(-0.04, 0.04)
        feet.append([x, leg.rest[1] + dice.uniform(-0.02, 0.02), slope * x + dice.uniform(-uneven, uneven)])
    return feet


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
    crawl_map.fit_body(crawl, sensing)
    best = twin.heading(seen, feet, shares)
    assert abs(crawl.map.body_pose.yaw / (1 << 24) * 2 * math.pi - best) < 0.5e-3
    exact = twin.body_place(seen, feet, shares, best)
    found = [crawl.map.body_pose[axis] * FINE_M for axis in range(3)]
    assert math.dist(found, exact) < 0.15 * MM


@repeatable(100)
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


@pytest.mark.parametrize("seed", range(60))
def test_even_ground_is_what_lies_on_one_slope(crawl, seed):
    dice = random.Random(seed)
    feet, leg = standing(dice, dice.uniform(-0.2, 0.2), dice.choice((0.0, 0.003, 0.01))), seed % 4
    put(crawl, feet)
    came_from = feet[leg][0] - 0.076, feet[leg][2] - dice.uniform(-0.02, 0.02)
    crawl.swing.departure.x, crawl.swing.target.z = fine(came_from[0]), fine(came_from[1])
    crawl.ground.even_landings = 5
    count = crawl_ground.note_landing(crawl, leg)
    exact, found = twin.uneven(feet, leg, came_from), crawl_ground.unevenness(crawl, leg) * UNIT_M
    assert abs(found - exact) < 0.15 * MM
    if abs(exact - setting("drop_depth") / 3) > 0.2 * MM:
        assert count == (6 if exact < setting("drop_depth") / 3 else 0)


def test_astride_an_edge_is_not_even_although_four_feet_lie_on_a_slope(crawl):
    """Front feet on a step of 40 mm, hind feet below, all on one slope: the last step along it did not rise."""
    feet = [[0.125, -0.1, 0.04], [0.125, 0.1, 0.04], [-0.105, -0.1, 0.0], [-0.105, 0.1, 0.0]]
    put(crawl, feet)
    crawl.swing.departure.x, crawl.swing.target.z = fine(0.125 - 0.076), fine(0.04)
    assert crawl_ground.note_landing(crawl, 0) == 0
    crawl.swing.target.z = fine(0.04 - 0.04 * 76 / 230)
    assert crawl_ground.note_landing(crawl, 0) == 1


@pytest.mark.parametrize("slope", [-0.2, -0.03, 0.03, 0.2])
def test_a_front_foot_expects_its_ground_on_a_slope_it_is_sure_of(crawl, slope):
    """4 mm over the step are level: what sag and odometry err."""
    feet = standing(random.Random(6), slope, 0.0)
    put(crawl, feet)
    rise = slope * (swing.front_target(feet[0][0], feet[1][0], setting("stride")) - feet[0][0])
    for landings, exact in ((2, 0.0), (3, rise if abs(rise) > 4 * MM else 0.0)):
        crawl.ground.even_landings = landings
        footholds.aim(crawl, 0)
        assert crawl.swing.ground * FINE_M - feet[0][2] == pytest.approx(exact, abs=0.1 * MM)


# --- pose


@pytest.mark.parametrize("seed", range(40))
def test_the_body_pitches_with_the_slope_of_the_feet(crawl, seed):
    dice = random.Random(seed)
    feet = standing(dice, dice.uniform(-0.5, 0.5))
    put(crawl, feet)
    found = rad(crawl_pose.feet_pitch(crawl.params, crawl.map))
    assert abs(found - twin.slope_pitch(feet, setting("half_length") * 2 / 3)) < 0.4e-3


@pytest.mark.parametrize("seed", range(40))
def test_the_body_goes_over_the_point_as_high_as_its_legs_reach_and_takes_its_time(crawl, seed):
    dice = random.Random(seed)
    feet = standing(dice, dice.uniform(-0.2, 0.2))
    put(crawl, feet)
    wanted = [dice.uniform(-0.04, 0.04), dice.uniform(-0.03, 0.03)]
    crawl.point.x, crawl.point.y = (round(value / UNIT_M) for value in wanted)
    ticks = crawl_pose.plan_body(crawl, -1)
    to = pack(crawl.path.to_pose)
    pitch = twin.slope_pitch(feet, setting("half_length") * 2 / 3)
    com = PARAMS.com_x * UNIT_M, setting("com_z")
    place = wanted[0] - twin.com_ahead(com, pitch), wanted[1]
    assert math.dist((to[0] * FINE_M, to[1] * FINE_M), place) < 0.1 * MM
    sides = [leg.side_l1 for leg in LEGS]
    height = twin.body_height(feet, [leg.hip for leg in LEGS], sides, place, pitch, setting("height"),
                              setting("reach"))
    found = to[2] * FINE_M - twin.middle(feet)[2]
    assert -2.5 * MM < found - height < 0.3 * MM  # the core stops a little lower: it lowers by what the legs miss
    way = math.hypot(to[0] * FINE_M, to[1] * FINE_M)
    seconds = twin.move_seconds(way, to[2] * FINE_M - 0.18, pitch, setting("half_length"), 0.6, 0.06, 0.25)
    assert abs(ticks / RATE - seconds) <= 1.6 / RATE + 0.02 * seconds


@repeatable(400)
@given(st.integers(0, 1 << 20), st.integers(0, 3), st.floats(-0.06, 0.06), st.booleans())
def test_the_mass_goes_to_the_nearest_point_inside_the_support(seed, leg, wanted_m, planar):
    crawl, dice = Crawl(PLANAR if planar else PARAMS), random.Random(seed)
    feet = standing(dice)
    put(crawl, feet)
    wanted = round(wanted_m / UNIT_M)
    crawl_pose.com_target(crawl, leg, wanted)
    exact = plan.com_target(feet, leg, wanted * UNIT_M, setting("margin"), planar)
    assert math.dist([value * UNIT_M for value in pack(crawl.point)], exact) < 0.2 * MM


def test_a_bodys_move_is_the_quintic(crawl):
    put(crawl, standing(random.Random(3)))
    path = crawl.path
    for axis in range(6):
        path.from_pose[axis], path.to_pose[axis] = 1000 * axis, 200000 - 90000 * axis
    path.move_tick, path.move_ticks = 0, 40
    for tick in range(1, 41):
        assert crawl_pose.move_body(path) == 1
        for axis in range(6):
            exact = 1000 * axis + twin.quintic(tick / 40) * (200000 - 91000 * axis)
            assert abs(path.wanted[axis] - exact) <= 0.0025 * 350000
    assert crawl_pose.move_body(path) == 0


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


@pytest.mark.parametrize("side", [0, 1])
def test_the_first_footholds_lie_between_hind_and_front_foot(crawl, side):
    feet = standing(random.Random(5 + side))
    put(crawl, feet)
    footholds.footholds_start(crawl)
    hind, front = feet[2 + side], feet[side]
    for place, exact in enumerate(swing.first_footholds((hind[0], hind[2]), (front[0], front[2]), side)):
        foothold = crawl.footholds.sides[side].places[place]
        found = foothold.x * FINE_M, foothold.z * FINE_M
        assert math.dist(found, exact) < 0.01 * MM


@pytest.mark.parametrize("seed", range(40))
def test_a_front_foot_aims_half_a_stride_beyond_the_other(crawl, seed):
    dice = random.Random(seed)
    feet, leg = standing(dice, uneven=0.05), seed % 2
    put(crawl, feet)
    footholds.aim(crawl, leg)
    own, other, stride = feet[leg], feet[1 - leg], setting("stride")
    target = swing.front_target(own[0], other[0], stride)
    assert abs(crawl.swing.target.x * FINE_M - target) < 0.05 * MM
    assert crawl.swing.ground == crawl.map.feet[leg].z
    hit = setting("riser_lag")
    if abs(other[0] - target - hit * 5 / 3) > 0.1 * MM:
        top = swing.front_top(own[2], other[2], other[0], target, setting("front_lift"), hit)
        assert abs(crawl.swing.apex * FINE_M - top) < 0.05 * MM


@repeatable(40)
@given(st.floats(0.02, 0.07))
def test_a_foot_goes_up_as_its_twin_and_stops_at_the_top(lift_m):
    c, k = Crawl(PARAMS), PARAMS.crawl
    c.swing.apex, c.swing.leg_length = fine(lift_m), 32767
    units = FINE_M * RATE
    exact = swing.rise(0.0, lift_m, k.lift_speed * units, k.lift_acceleration * units * RATE,
                       k.lift_brake * units * RATE / 2, k.apex_speed * units, 1 / RATE, 60)
    there = 0
    for height in exact:
        there = there or swing_leg.lift_foot(c.params, c.swing)
        assert abs(c.swing.place.z * FINE_M - height) < 0.6 * MM
    assert there == 1
    assert c.swing.place.z == c.swing.apex


@repeatable(100)
@given(st.floats(0.0, 0.08))
def test_a_foot_comes_down_so_that_it_can_slow_down_over_known_ground(above_m):
    c, k = Crawl(PARAMS), PARAMS.crawl
    c.swing.known = 1
    c.swing.place.z = fine(above_m) + (k.near_foothold << 8)
    found = swing_leg.lower_speed(c) * FINE_M * RATE
    brake = k.lower_acceleration * FINE_M * RATE * RATE
    exact = swing.fall_speed(above_m, k.near_speed * FINE_M * RATE, k.known_lower_speed * FINE_M * RATE, brake)
    assert abs(found - exact) < 0.003
    c.swing.known = 0
    assert swing_leg.lower_speed(c) == k.unknown_lower_speed


@repeatable(100)
@given(st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.integers(0, 3))
def test_a_corner_of_the_body_is_pushed_up(nose_up, left_up, leg):
    c = Crawl(PARAMS)
    c.map.body_pose.pitch, c.map.body_pose.roll = bf(-nose_up), bf(left_up)
    exact = swing.corner_lift(nose_up, left_up, setting("half_length"), setting("half_width"), leg)
    assert abs(contact.corner_lift(c, leg) * UNIT_M - exact) < 0.1 * MM


@repeatable(300)
@given(st.floats(0.0, 0.012), st.floats(-0.02, 0.02))
def test_a_foot_on_its_expected_ground_that_pushes_the_body_up_stands(lift_m, off_m):
    near, least = abs(off_m) - setting("drop_depth") / 3, lift_m - setting("stand_lift")
    if abs(near) > 0.05 * MM and abs(least) > 0.05 * MM:
        lift = round(lift_m / UNIT_M)
        assert contact.stands_straight(PARAMS, lift, fine(off_m)) == int(near < 0 < least)


@repeatable(100)
@given(integers(0, 3), st.floats(0.0, 0.06), st.floats(0.03, 0.1))
def test_a_riser_is_felt_by_how_late_the_foot_is(leg, behind_m, way_m):
    c, k = Crawl(PARAMS), PARAMS.crawl
    ticks = 24
    c.stage.stage_tick, c.swing.way_ticks, c.swing.target.x, c.swing.departure.x = 20, ticks, fine(way_m), 0
    for place in range(HISTORY_TICKS):
        c.contact.past_x[place] = fine(behind_m)
    late = swing.held_up(behind_m, setting("riser_lag"), way_m, (ticks + 1) / RATE, k.swing_lag_ticks / RATE)
    margin = behind_m - setting("riser_lag") - way_m / ((ticks + 1) / RATE) * k.swing_lag_ticks / RATE
    if abs(margin) > 0.05 * MM:
        assert bool(contact.feel_riser(c, c.map.measured[leg].x)) == late


@pytest.mark.parametrize("tare", [-569, 0, 569])  # as far as it goes, and none
def test_ground_is_felt_after_three_loaded_ticks_of_which_one_is_above_4_newton(crawl, tare):
    """In parts of Caramelo's 21.6 N: 3 N are 569, 4 N are 758. What the hanging leg reads does not count."""

    def felt(*loads):
        crawl.contact.tare_q12, crawl.contact.load_ticks, crawl.contact.peak = tare, 0, 0
        return [contact.feel_ground(crawl.params, crawl.contact, tare + load) for load in loads]

    assert felt(600, 800, 600) == [0, 0, 1]
    assert felt(600, 700, 600, 700) == [0, 0, 0, 0]  # never above 4 N
    assert felt(800, 800, 0, 800, 800) == [0, 0, 0, 0, 0]  # never three in a row


@repeatable(100)
@given(st.lists(st.integers(-4000, 4000), min_size=1, max_size=40), st.integers(1, 32768))
def test_the_tare_follows_but_never_hides_a_contact(forces, gain_q15):
    c, exact, most = Crawl(PARAMS), 0.0, PARAMS.crawl.touch_q12
    for force in forces:
        exact = max(-most, min(most, exact + gain_q15 / 32768 * (force - exact)))
        found = contact.follow_tare(c.params, c.contact, force, gain_q15)
        assert abs(found - exact) <= 1.0  # a share is rounded to whole counts
        assert abs(found) <= most
        exact = float(found)


def test_hind_feet_do_not_know_the_ground_that_no_front_foot_has_stood_on():
    """Two footholds of the right side and three of the left are guessed at the start; what follows is known."""
    c = Crawl(PARAMS)
    footholds.footholds_start(c)
    for side, guessed in ((0, 2), (1, 3)):
        known = []
        for _ in range(5):
            footholds.foothold_add(c.map, c.footholds, side)
            footholds.aim_hind(c, side + 2)
            known.append(c.swing.known)
        assert known == [0] * guessed + [1] * (5 - guessed)
        c.footholds.sides[side].waiting = 0
        footholds.aim_hind(c, side + 2)
        assert c.swing.known == 0


@repeatable(100)
@given(st.floats(-0.002, 0.004), st.integers(20, 500))
def test_backing_off_ends_after_a_third_of_a_leg_or_six_seconds_and_half_a_second_of_standing(back_m, rate_hz):
    params = block("caramelo", rate_hz)
    command, state, told = Command(), retreat.Retreat(), Command()
    ticks = 0
    while not retreat.retreat_step(params, command, -fine(back_m), int(ticks > 0), state, told):
        ticks += 1
        assert told.speed.vx <= 0
        assert ticks < 8 * rate_hz
    by_way = math.ceil(0.3 * 0.24 / back_m) if back_m > 1e-5 else math.inf
    assert abs(ticks - min(by_way, 6 * rate_hz) - rate_hz / 2) <= 3 + 0.001 * ticks


# --- what is carried, and how it begins


@repeatable(60)
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
