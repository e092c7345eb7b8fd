"""Stairs: swings stay high while it climbs, and a foot takes ground that is higher than planned as it is."""

import pytest

from host.robot import trot_tuning as tuning
from host.robot.file import load_robot
from host.robot.scale import core_params
from shared.record import copy, pack
from shared.sense.legs import MeasuredFeet
from shared.sense.odometry import Odometry
from shared.trot.clock import advance_legs
from shared.trot.ground import climbs, slope_ahead_q20
from shared.trot.react import (
    EARLY,
    EARLY_NOW,
    choose_lift,
    count_held_up,
    count_in_row,
    detect_held_up,
    swing_apex,
)
from shared.trot.state import CYCLE_Q20, Trot
from shared.trot.trot import trot_start

from .test_twin import Pair

UNEVEN_Q4 = 1024 << 4  # lu: stairs


@pytest.fixture
def pair():
    one = Pair("caramelo", 50)
    one.walk.state.high_left = one.params.trot.high_distance
    return one


@pytest.mark.parametrize("way", [-1, 0, 1])
def test_it_climbs_where_the_ground_rises_along_the_way(pair, way):
    """Over all slopes that the trot can believe, ahead and back."""
    state = pair.walk.state
    state.foot_speed.x, state.uneven_q4 = way * 1000, UNEVEN_Q4
    for slope_q20 in range(-314573, 314574, 997):
        state.slope_q20.x = slope_q20
        assert slope_ahead_q20(pair.walk) == slope_q20 * (way or 1)
        assert climbs(pair.params, pair.walk) == (slope_q20 * (way or 1) / 2**20 > 0.1)


@pytest.mark.parametrize("share", [0.0, 0.005, 0.007, 0.1])
def test_a_slope_on_which_the_feet_stand_in_their_plane_is_no_climb(pair, share):
    state = pair.walk.state
    state.slope_q20.x, state.uneven_q4 = 1 << 18, round(share * pair.params.leg_length * 16)
    assert climbs(pair.params, pair.walk) == (share > 0.006)


def test_swings_stay_high_while_it_climbs_and_no_longer(pair):
    state, setup = pair.walk.state, pair.params.trot
    state.slope_q20.x, state.uneven_q4 = 1 << 18, UNEVEN_Q4
    for _ in range(1000):
        choose_lift(pair.params, pair.walk)
    assert state.high_left == setup.high_distance
    state.slope_q20.x = 0
    for _ in range(setup.high_distance // setup.high_slowest + 2):
        choose_lift(pair.params, pair.walk)
    assert state.high_left == 0
    assert state.lift == setup.low_lift


@pytest.mark.parametrize("held", [0, 1])
@pytest.mark.parametrize("high", [0, 1])
def test_the_next_swing_is_highest_after_one_that_was_held_up_while_swings_are_high(pair, held, high):
    state, setup, walk = pair.walk.state, pair.params.trot, pair.walk
    state.lift, state.high_left, walk.held_up[1] = setup.high_lift, high * setup.high_distance, held
    assert swing_apex(pair.params, walk, 1) == (setup.highest_lift if held and high else setup.high_lift)


@pytest.mark.parametrize(("apex", "renewed"), [("low_lift", True), ("high_lift", True), ("highest_lift", False)])
def test_a_held_up_foot_keeps_swings_high_but_not_one_that_is_late_in_the_highest_swing(pair, apex, renewed):
    state, setup, walk = pair.walk.state, pair.params.trot, pair.walk
    state.high_left, state.foot_speed.x, state.swing_q15 = 1, 1000, 20000
    walk.apex[1], walk.residual_x[1] = getattr(setup, apex), -pair.params.leg_length // 4
    detect_held_up(pair.params, walk, 1)
    assert walk.held_up[1]
    assert walk.apex[1] == max(getattr(setup, apex), setup.high_lift)
    assert state.high_left == (setup.high_distance if renewed else 1)


@pytest.mark.parametrize(("swings", "rows"), [
    (((0, 1, 0), (1, 1, 0), (0, 1, 0)), [3, 0]),
    (((2, 1, 0), (3, 1, 0), (0, 1, 0)), [1, 2]),
    (((0, 1, 0), (1, 0, 0), (0, 1, 0)), [1, 0]),
    (((0, 1, 0), (1, 1, -0.03), (0, 1, 0)), [-99, 0]),  # it went down: that is no wall
    (((0, 1, -0.01), (1, 1, 0.3), (0, 1, 0)), [3, 0]),
    (((0, 1, 0),) * 300, [100, 0]),
    (((0, 1, -1), (0, 0, 0), (1, 1, 0)), [1, 0]),
])
@pytest.mark.parametrize("way", [-1, 0, 1])
def test_swings_held_up_in_a_row_are_counted_for_the_front_and_the_hind_feet(pair, way, swings, rows):
    """Each swing: its leg, whether it was held up, the rise of the ground along the way. Nothing holds who stands."""
    state, walk = pair.walk.state, pair.walk
    state.foot_speed.x = way * 1000
    for leg, held, rise in swings:
        walk.held_up[leg], state.slope_q20.x = held, round((way or 1) * rise * 2**20 * 0.99)
        count_in_row(walk, leg)
    assert list(walk.held_up_in_row) == (rows if way else [0, 0])


@pytest.mark.parametrize(("high", "down", "falls", "stood", "met_before", "known", "taken"), [
    (0.06, 0.1, 0.0, 0.5, 0, 100, True),
    (0.06, 0.1, -0.1, 0.5, 0, 100, True),  # the body sinks onto it
    (0.04, 0.1, 0.0, 0.5, 0, 100, False),  # it sags as much
    (0.06, 0.02, 0.0, 0.5, 0, 100, False),  # slow drives are late: it is still at the top of its swing
    (0.06, 0.1, 0.3, 0.5, 0, 100, False),  # the same: it still comes down
    (0.06, 0.1, 0.2, 0.5, 0, 100, True),
    (0.06, 0.1, 0.0, 1.5, 0, 100, False),  # the joints tell of its load by now, not of its landing
    (0.06, 0.1, 0.0, 0.5, EARLY, 100, False),  # once a landing
    (0.06, 0.1, 0.0, 0.5, 0, 1, False),  # nothing is measured yet
])
def test_a_foot_that_lands_high_takes_the_ground_as_it_is(pair, high, down, falls, stood, met_before, known, taken):
    """``high`` above where it was sent, ``down`` from its top, of the leg; ``falls``: of a swing's mean fall.

    ``stood``: of the time in which it may tell.
    """
    state, setup, walk = pair.walk.state, pair.params.trot, pair.walk
    state.known = known
    rest, landed = pair.params.legs[1].rest, walk.measured.legs[1]
    copy(rest, landed)
    landed.z += round(high * pair.params.leg_length)
    walk.apex[1], walk.swing_top[1] = setup.high_lift, landed.z + round(down * pair.params.leg_length)
    walk.before.legs[1].z = landed.z + round(falls * setup.high_lift * 512 / setup.swing_q8)
    walk.residual_z[1], walk.early_contact[1] = round(high * pair.params.leg_length), met_before
    before, after_landing = [pack(foot) for foot in walk.feet.legs], stood > 1
    walk.command.moving = 1
    state.phase_q20 = (CYCLE_Q20 >> 1) + round(stood * setup.landing_q20) - setup.phase_step_q20
    advance_legs(pair.params, walk, 0)
    changed = [pack(foot) != was for foot, was in zip(walk.feet.legs, before, strict=True)]
    assert changed == [False, taken, False, False]
    assert walk.early_contact[1] == (EARLY_NOW if taken else 0 if after_landing else met_before)
    if taken:
        assert walk.feet.legs[1].x == rest.x << 8


def test_the_time_in_which_a_landing_is_told_is_an_eighth_of_a_cycle_after_the_bus(pair):
    for delay_s in (0.0, 0.02, 0.06):
        robot = load_robot("caramelo")
        robot = robot.model_copy(update={"bus": robot.bus.model_copy(update={"delay_s": delay_s})})
        params = core_params(robot, 100)
        told = params.trot.landing_q20 / 2**20 * tuning.trot_figures(robot).cycle_s
        assert told == pytest.approx(pair.twin.f.cycle_s / 8 + params.delay_ticks / 100, abs=0.001)


@pytest.mark.parametrize("pushed", [0, 2])
@pytest.mark.parametrize("rate_hz", [50, 500])
def test_a_foot_swings_again_after_it_met_something_however_late_the_bus_is(rate_hz, pushed):
    """At its usual pace and the faster one, whatever tick is the last of the stance that FR and RL begin."""
    robot = load_robot("caramelo")
    robot = robot.model_copy(update={"bus": robot.bus.model_copy(update={"delay_s": 0.5})})
    params, walk = core_params(robot, rate_hz), Trot(MeasuredFeet(), Odometry())
    step = params.trot.phase_step_q20
    for first in range(0, step, step // 20):
        trot_start(params, walk)
        walk.command.moving, walk.early_contact[:], swung = 1, [EARLY, 0, 0, EARLY], 0
        walk.state.phase_q20, walk.state.pushed = first, pushed
        for _ in range(CYCLE_Q20 // step):
            advance_legs(params, walk, 0)
            swung |= walk.state.swinging
        assert swung == 0b1111


@pytest.mark.parametrize(("climbing", "held", "of_speed", "counts"), [
    (0, 1, 1.1, 2), (0, 0, 0.3, 2), (0, 0, 0.4, 0),
    (1, 1, 1.1, 0), (1, 1, 0.9, 2), (1, 0, 0.3, 2), (1, 0, 0.4, 0),
])
@pytest.mark.parametrize("way", [-1, 1])
def test_where_it_climbs_a_swing_that_was_held_up_counts_only_if_it_is_slow(
    pair, way, climbing, held, of_speed, counts
):
    state, walk = pair.walk.state, pair.walk
    state.foot_speed.x, state.measured_speed.x, walk.held_up[2] = way * 1000, round(way * 1000 * of_speed), held
    state.slope_q20.x, state.uneven_q4 = climbing * way << 18, UNEVEN_Q4
    count_held_up(pair.params, walk, 2)
    assert walk.stuck_score[2] == counts


@pytest.mark.parametrize("way", [-1, 1])
@pytest.mark.parametrize(("of_speed", "goes"), [(-1.0, False), (0.0, False), (0.49, False), (0.5, True), (1.0, True)])
def test_a_body_that_is_slow_for_four_cycles_swings_high(pair, way, of_speed, goes):
    """A slow robot stood before an edge for ever: its feet never are far behind."""
    state, walk, twin = pair.walk.state, pair.walk, pair.twin
    state.high_left = 0
    state.foot_speed.x, state.measured_speed.x = way * 1000, round(way * 1000 * of_speed)
    twin.foot_speed[0], twin.measured_speed[0] = way, way * of_speed
    for swing in range(16):
        assert state.high_left == twin.high_left == 0, swing
        count_held_up(pair.params, walk, swing & 3)
        twin.count_slow()
    assert state.high_left == (0 if goes else pair.params.trot.high_distance)
    assert pair.scale.metres(state.high_left / 256) == pytest.approx(twin.high_left, abs=0.001)


def test_a_body_that_is_to_turn_or_go_sideways_is_never_slow(pair):
    state, walk = pair.walk.state, pair.walk
    state.high_left, state.foot_speed.x, state.measured_speed.x = 0, 0, -1000
    for swing in range(100):
        count_held_up(pair.params, walk, swing & 3)
    assert state.high_left == 0


@pytest.mark.parametrize("of_speed", [0.0, 1.0])
def test_a_row_of_slow_swings_ends_with_one_that_is_not_and_with_a_stop(pair, of_speed):
    state, walk = pair.walk.state, pair.walk
    state.high_left = 0
    for swing in range(100):
        ends = swing % 16 == 15
        state.foot_speed.x, state.measured_speed.x = round(of_speed * 1000) if ends else 1000, 1000 if ends else 100
        count_held_up(pair.params, walk, swing & 3)
    assert state.high_left == 0


def test_to_be_held_up_never_becomes_usual(pair):
    for _ in range(100):
        pair.walk.peak_lag[2] = pair.params.leg_length >> 2
        count_held_up(pair.params, pair.walk, 2)
    assert pair.walk.usual_lag[2] == pair.params.leg_length * 41 >> 10


def test_the_way_with_high_swings_is_as_the_floats_say(pair):
    """A foot is held in its swing, and the ground told to climb; both count the same way with high swings."""
    pair.walk.state.high_left = 0
    for n in pair.walk_with_a_held_foot():
        assert pair.scale.metres(pair.walk.state.high_left / 256) == pytest.approx(pair.twin.high_left, abs=0.001), n
        if n == 111:
            pair.walk.state.slope_q20.x, pair.twin.slope[0] = 1 << 18, 0.25
            pair.walk.state.uneven_q4, pair.twin.uneven = UNEVEN_Q4, pair.scale.metres(UNEVEN_Q4 / 16)
    assert pair.twin.high_left > 0.05


@pytest.mark.parametrize(("name", "slow"), [("caramelo", True), ("spotmicro", True), ("parallel", False)])
def test_drives_that_are_too_slow_for_high_swings_walk_them_slowly(name, slow):
    robot = load_robot(name)
    figures = tuning.trot_figures(robot)
    froude = tuning.high_speed_m_s(robot) / (9.81 * figures.height_m) ** 0.5
    assert froude == pytest.approx(tuning.LATE_FROUDE, rel=0.001) if slow else froude > 1.2 * tuning.LATE_FROUDE
    assert slow or tuning.high_speed_m_s(robot) == figures.climbing_m_s
