"""The trot's rules against their float twin, and what the whole gait does on a robot with perfect servos."""

import math
import random
from array import array

import pytest

from shared.body.params import Params
from shared.gait import steps as s
from shared.gait.gaits import TROT
from shared.gait.table import compile_gait
from shared.planner import command as c
from shared.planner import status as n
from shared.record import copy, pack, unpack
from shared.sense import legs as sensing
from shared.trot import ground, navigate, sway, tipping, trot
from shared.trot.navigate import Navigation
from tests.float_twin import trot as twin

from .robots import block, rad
from .walker import Walker

PARAMS = block("caramelo")
UNIT_M = 2.0 ** -PARAMS.length_shift
LEG_M = PARAMS.leg_length * UNIT_M
LF_M = UNIT_M / 256
YAW = 2.0**-18


def holding(made, *values):
    """Return a record with these values in it."""
    unpack(made, values)
    return made


def test_errors_to_the_reference_add_up_and_turn_with_the_robot():
    dice, nav, exact = random.Random(1), Navigation(), (0.0, 0.0, 0.0)
    for _ in range(3000):
        speed = array("i", [dice.randint(-60000, 60000), dice.randint(-30000, 30000), dice.randint(-2000, 2000)])
        moved, turned = (dice.randint(-60000, 60000), dice.randint(-30000, 30000)), dice.randint(-2500, 2500)
        navigate.follow_reference(PARAMS, speed, *moved, turned, 1, nav)
        told = speed[0] * LF_M, speed[1] * LF_M, speed[2] * YAW
        exact = twin.follow(exact, told, [v * LF_M for v in moved], turned * YAW, LEG_M / 6)
        exact = tuple(exact)
        assert [v * LF_M for v in (nav.x, nav.y)] == pytest.approx(exact[:2], abs=1.5e-3)
        assert nav.yaw * YAW == pytest.approx(exact[2], abs=1e-3)
        exact = nav.x * LF_M, nav.y * LF_M, nav.yaw * YAW


def test_without_yaw_the_heading_is_not_held():
    nav = holding(Navigation(), 0, 0, 5000)
    navigate.follow_reference(PARAMS, array("i", [0, 0, 2000]), 0, 0, 900, 0, nav)
    assert nav.yaw == 0


def test_corrections_are_small_shares_of_the_speed_and_sway_is_no_error():
    drive, speed = array("i", [0] * 3), array("i", [30000, 0, 0])
    navigate.hold(PARAMS, speed, 0, holding(Navigation(), 1 << 20, 1 << 21, 90000), drive)
    assert drive[0] == 36000
    assert drive[1] == PARAMS.speed_max[1] * 2 // 5
    assert 0 < drive[2] <= PARAMS.speed_max[2] * 3 // 4
    navigate.hold(PARAMS, speed, 1000, holding(Navigation(), 0, -256000, 0), drive)
    assert list(drive) == [30000, 0, 0]
    navigate.hold(PARAMS, array("i", [0, 0, 0]), 0, holding(Navigation(), 256 << 8, 0, 0), drive)
    assert drive[0] == pytest.approx(0.5 * (256 << 8) / 50, abs=20)


def test_smooth_is_smoothstep_and_diagonal_is_a_line():
    assert all(abs(sway.smooth_q12(k, 50) - 4096 * twin.smooth(k / 50)) <= 6 for k in range(-5, 60))
    assert sway.smooth_q12(1, 0) == 4096
    dice = random.Random(2)
    for _ in range(300):
        feet = array("i", [dice.randint(-20000, 20000) for _ in range(12)])
        ahead, x = dice.randint(-2000, 2000), dice.randint(-2000, 2000)
        if abs(feet[6] - feet[3]) < 12000:
            continue
        exact = twin.line_at((feet[3] - ahead, feet[4]), (feet[6] - ahead, feet[7]), x)
        if abs(exact) < 65535 and abs(x - feet[3] + ahead) < 1.9 * abs(feet[6] - feet[3]):
            assert abs(sway.diagonal_y(feet, 1, 2, ahead, x) - exact) <= 16


def test_sway_goes_to_the_line_within_its_limit_and_not_in_the_plane():
    planar = Params()
    copy(PARAMS, planar)
    planar.lateral_q12 = 0
    most = PARAMS.leg_length * 3 >> 4
    assert sway.next_sway(PARAMS, 100, 2000, 500) == 1600
    assert sway.next_sway(PARAMS, 0, 60000, 0) == most
    assert sway.next_sway(PARAMS, 0, -60000, 0) == -most
    assert sway.next_sway(planar, 0, 2000, 500) == 0


def test_tipping_moves_the_centre_of_mass_against_it():
    dice = random.Random(3)
    for one in (0, 1):
        for _ in range(100):
            feet = array("i", [15000, -15000, 0, 15000, 15000, 0, -15000, -15000, 0, -15000, 15000, 0])
            turned = [dice.randint(-4000, 4000) for _ in range(2)]
            tip = holding(tipping.Tipping(), 0, 0, 0, 0, 8)
            tipping.tip_add(tip, *turned)
            exact = twin.tip_forward(feet[3 * one : 3 * one + 2], feet[9 - 3 * one : 11 - 3 * one], turned)
            exact = twin.clip(exact, math.radians(1.5) / YAW)
            assert abs(tipping.tip_learn(PARAMS, feet, one, 3 - one, tip) - exact) <= 3
            step = exact * YAW * LEG_M / 10 / LF_M
            side = 1 if one == 0 else -1
            assert pack(tip) == pytest.approx([0, 0, step, side * step, 8], rel=2e-3, abs=5)


def test_the_first_swings_teach_four_times_as_much():
    feet, tip, steps = array("i", [15000, -15000, 0] + [0] * 6 + [-15000, 15000, 0]), tipping.Tipping(), []
    for _ in range(10):
        before = tip.com_x
        tipping.tip_add(tip, 0, 4000)
        tipping.tip_learn(PARAMS, feet, 0, 3, tip)
        steps.append(tip.com_x - before)
    assert steps[:8] == [steps[0]] * 8
    assert steps[0] == pytest.approx(4 * steps[9], abs=4)
    tipping.tip_reset(tip, 1)
    assert pack(tip) == [0] * 5


def test_twist_is_the_fourth_way_that_tilt_and_height_do_not_see():
    dice, state = random.Random(4), sensing.Sensing()
    for _ in range(300):
        feet = [[dice.randint(-20000, 20000) for _ in range(3)] for _ in range(4)]
        state.level[:] = [v for foot in feet for v in foot]
        roll, pitch = dice.randint(-4000, 4000), dice.randint(-4000, 4000)
        assert abs(ground.twist(state, roll, pitch) - twin.twist(feet, rad(roll), rad(pitch))) <= 8
    believed = 0
    for _ in range(200):
        believed = ground.follow_twist(PARAMS, believed, 1000)
    assert believed >> 8 == pytest.approx(1000, abs=12)
    for _ in range(400):
        believed = ground.follow_twist(PARAMS, believed, 100000)
    assert believed >> 8 == PARAMS.leg_length // 12


def test_footholds_go_to_the_twisted_ground_and_swings_aim_there():
    steps = s.Steps()
    s.steps_reset(PARAMS, steps)
    rest = steps.legs[0].z
    steps.legs[1].ticks = 5
    for _ in range(50):
        ground.press_feet(PARAMS, steps, 700)
    assert [leg.z - rest for leg in steps.legs] == [700, 0, -700, 700]
    assert [leg.to_z - rest for leg in steps.legs] == [700, -700, -700, 700]


@pytest.mark.parametrize(("tilt_deg", "behind_m", "speed_m_s"), [(0, 0, 0), (3, 0, 0.05), (9, 0, 0), (0, 0.02, 0.05)])
def test_lift_grows_with_tilt_and_lag(tilt_deg, behind_m, speed_m_s):
    tilt = round(math.radians(tilt_deg) / rad(1)) << 4
    speed = round(speed_m_s / 50 / LF_M)
    exact = twin.extra_lift(LEG_M, math.radians(tilt_deg), behind_m, speed_m_s, 0.12)
    got = ground.extra_lift(PARAMS, tilt, round(behind_m / LF_M), speed) * UNIT_M
    assert got == pytest.approx(exact, abs=0.1e-3)


def test_a_tilt_is_remembered_for_two_seconds():
    rough = ground.roughness(PARAMS, 0, -900, 1000)
    assert rough >> 4 == 1000
    for _ in range(100):
        rough = ground.roughness(PARAMS, rough, 0, 0)
    assert (rough >> 4) / 1000 == pytest.approx(math.exp(-1), abs=0.02)


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
@pytest.mark.parametrize("rate_hz", [20, 50, 500])
def test_segments_are_as_long_as_the_speed_wants_and_the_body_moves_by_its_cycle(name, rate_hz):
    params = block(name, rate_hz)
    gait = compile_gait(TROT, params)
    for part in (0.0, 0.5, 0.75, 1.0, 2.0):
        speed = array("i", [round(params.fast_speed * part), 0, 0])
        half = trot.retime(params, gait, speed)
        share = max(0.0, min(1.0, 2 * part - 1))
        body = params.body_slow + (params.body_fast - params.body_slow) * share
        swing = params.swing_slow + (params.swing_fast - params.swing_slow) * share
        ticks = [row.ticks for row in gait.rows[:4]]
        assert ticks == pytest.approx([body, swing, body, swing], abs=0.51)
        assert gait.cycle == 2 * half == sum(ticks)
        assert sum(row.advance_q4 for row in gait.rows[:4]) == 16 * sum(ticks)
        assert gait.stance_q10[0] == 1024 * sum(ticks) - 512 * ticks[1]


def test_levelling_turns_about_the_ground():
    walk = trot.Trot(PARAMS)
    dice = random.Random(5)
    for _ in range(200):
        posed = array("i", [0] * 6)
        roll, pitch = dice.randint(-4000, 4000), dice.randint(-4000, 4000)
        trot.pose_body(PARAMS, walk, roll, pitch, posed)
        height = -PARAMS.legs[0].rest[2]
        assert posed[:3].tolist() == pytest.approx(twin.pivot(height, rad(roll), rad(pitch)), abs=4)


@pytest.fixture(scope="module")
def stander():
    walker = Walker()
    walker.gait("trot")
    walker.stand()
    walker.ticks(100)
    return walker


def test_standing_it_leans_ahead_rises_and_carries_all_its_weight(stander):
    state, load = stander.planner.walk.state, stander.planner.walk.load
    assert state.ahead == PARAMS.body_forward
    assert state.raised == PARAMS.body_raise
    assert sum(load.force_q12) == pytest.approx(state.weight_q12, abs=8)
    assert stander.planner.status.margin * UNIT_M > 0.05


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
@pytest.mark.parametrize("knees", ["full-elbow", "full-knee", "elbow-knee", "knee-elbow"])
def test_it_walks_stops_and_sits_with_every_knee(name, knees):
    walker = Walker(name, 50, knees)
    walker.walk("trot", 0.04, 0.01, 0.05)
    flags, seen = 0, set()
    for _ in range(300):
        flags |= walker.tick()
        seen.add(walker.swinging())
        assert walker.planner.status.margin == walker.planner.walk.state.margin
    assert seen == {0, 6, 9}
    assert flags & ~n.BLIND == 0
    walker.mode(c.MODE_STAND)
    walker.until(n.STANDING)
    walker.ticks(60)
    assert walker.planner.walk.state.sway == 0
    walker.mode(c.MODE_SIT)
    walker.until(n.SEATED)


def test_blind_it_walks_on_expectations_and_says_so():
    walker = Walker()
    walker.walk("trot")
    walker.sensed.valid.joints = walker.sensed.valid.tilt = 0
    assert walker.ticks(200) & (n.BLIND | n.NO_ATTITUDE)
    assert walker.state == n.WALKING
    assert list(walker.planner.drive) == list(walker.planner.speed)
    assert walker.planner.walk.state.weight_q12 == 4096


def test_it_does_not_move_without_a_command_and_starts_slowly():
    walker = Walker()
    walker.walk("trot", 0.0)
    walker.ticks(50)
    assert walker.state == n.STANDING
    asked = walker.speed(0.1)
    walker.ticks(10)
    assert 0 < walker.planner.speed[0] < 0.4 * asked[0] / LF_M
    walker.ticks(300)
    assert walker.planner.speed[0] * LF_M == pytest.approx(asked[0], rel=0.01)


def test_leaving_for_another_gait_gives_back_its_stance():
    walker = Walker()
    walker.walk("trot", 0.05)
    walker.ticks(200)
    walker.gait("even-trot")
    walker.ticks(300)
    state = walker.planner.walk.state
    assert [state.ahead, state.raised, state.sway, state.active] == [0] * 4
    assert max(walker.planner.walk.load.force_q12) == 0


@pytest.mark.parametrize("gait", ["even-trot", "trot"])
def test_a_fallen_robot_sits_down_and_stays_until_told(gait):
    walker = Walker()
    walker.walk(gait)
    walker.ticks(60)
    walker.sensed.tilt[0] = round(math.radians(45) / rad(1))
    limit = PARAMS.tilt_ticks
    assert walker.ticks(limit + 1) & n.FALLEN == 0  # one more: a tilt so sudden is believed the second time
    assert walker.ticks(1) & n.FALLEN
    assert walker.state == n.SITTING
    walker.until(n.SEATED)
    assert walker.ticks(20) & n.FALLEN
    assert walker.state == n.SEATED
    walker.sensed.tilt[0] = 0
    walker.mode(c.MODE_SIT)
    assert walker.ticks(1) & n.FALLEN == 0
    walker.stand()


def test_a_jolt_is_no_fall():
    walker = Walker()
    walker.walk("trot")
    walker.ticks(60)
    for _ in range(10):
        walker.sensed.tilt[1] = round(math.radians(45) / rad(1))
        walker.ticks(PARAMS.tilt_ticks - 1)
        walker.sensed.tilt[1] = 0
        assert walker.ticks(2) & n.FALLEN == 0
    assert walker.state == n.WALKING
