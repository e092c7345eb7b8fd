"""Stairs: swings stay high while it climbs, and what climbs more than one edge is walked slowly."""

import pytest

from host.robot import trot_tuning as tuning
from host.robot.file import load_robot
from shared.trot.ground import climbs
from shared.trot.react import count_held, lift_on, swing_top, top_speed

from .test_twin import Pair

UNEVEN_Q4 = 1024 << 4  # lu: stairs


@pytest.fixture
def pair():
    one = Pair("caramelo", 50)
    one.walk.state.high_left = one.params.trot.high_way
    return one


@pytest.mark.parametrize("way", [-1, 0, 1])
def test_it_climbs_where_the_ground_rises_along_the_way(pair, way):
    """Over all slopes that the trot can believe, ahead and back."""
    state = pair.walk.state
    state.foot_speed[0], state.uneven_q4 = way * 1000, UNEVEN_Q4
    for slope_q20 in range(-314573, 314574, 997):
        state.slope_q20[0] = slope_q20
        assert climbs(pair.params, pair.walk) == (slope_q20 * (way or 1) / 2**20 > 0.1)


@pytest.mark.parametrize("share", [0.0, 0.005, 0.007, 0.1])
def test_a_slope_on_which_the_feet_stand_in_their_plane_is_no_climb(pair, share):
    state = pair.walk.state
    state.slope_q20[0], state.uneven_q4 = 1 << 18, round(share * pair.params.leg_length * 16)
    assert climbs(pair.params, pair.walk) == (share > 0.006)


def test_swings_stay_high_while_it_climbs_and_no_longer(pair):
    state, setup = pair.walk.state, pair.params.trot
    state.slope_q20[0], state.uneven_q4 = 1 << 18, UNEVEN_Q4
    for _ in range(1000):
        lift_on(pair.params, pair.walk)
    assert state.high_left == setup.high_way
    state.slope_q20[0] = 0
    for _ in range(setup.high_way // setup.high_slowest + 2):
        lift_on(pair.params, pair.walk)
    assert state.high_left == 0
    assert state.lift == setup.low_lift
    assert state.high_gone == 0


def test_one_edge_is_walked_faster_than_stairs(pair):
    state, setup, figures = pair.walk.state, pair.params.trot, pair.twin.f
    slow_m_s = pair.scale.metres_per_second(setup.stairs_speed)
    assert slow_m_s == pytest.approx(tuning.STAIRS_FROUDE * (9.81 * figures.height_m) ** 0.5, rel=0.01)
    state.slope_q20[0], state.uneven_q4 = 1 << 18, UNEVEN_Q4
    gone_m = 0.0
    while top_speed(pair.params, pair.walk) == setup.high_speed:
        lift_on(pair.params, pair.walk)
        gone_m += pair.scale.metres(setup.high_slowest / 256)
    assert gone_m == pytest.approx(tuning.EDGE_LENGTHS * figures.length_m, rel=0.02)
    assert top_speed(pair.params, pair.walk) == setup.stairs_speed
    state.slope_q20[0] = 0
    assert top_speed(pair.params, pair.walk) == setup.high_speed


@pytest.mark.parametrize(("held", "behind", "gone", "slope", "highest"), [
    (1, 0.0, 0.0, 0.0, True),
    (0, 0.03, 1.0, 0.25, True),
    (0, 0.02, 1.0, 0.25, False),
    (0, 0.03, 0.9, 0.25, False),
    (0, 0.03, 1.0, 0.0, False),
])
def test_the_next_swing_is_highest_after_one_held_up_or_on_stairs_late(pair, held, behind, gone, slope, highest):
    """``behind``: of the leg, than usual; ``gone``: share of what one edge takes."""
    state, setup, walk = pair.walk.state, pair.params.trot, pair.walk
    state.slope_q20[0], state.uneven_q4, state.lift = round(slope * 2**20), UNEVEN_Q4, setup.high_lift
    state.high_gone, walk.held[1], walk.usual[1] = round(gone * setup.edge_way), held, 300
    walk.peak[1] = 300 + round(behind * pair.params.leg_length)
    assert swing_top(pair.params, walk, 1) == (setup.highest_lift if highest else setup.high_lift)
    state.high_left = 0
    assert swing_top(pair.params, walk, 1) == setup.high_lift


def test_to_be_held_up_never_becomes_usual(pair):
    for _ in range(100):
        pair.walk.peak[2] = pair.params.leg_length >> 2
        count_held(pair.params, pair.walk, 2)
    assert pair.walk.usual[2] == pair.params.leg_length * 41 >> 10


def test_the_way_with_high_swings_is_as_the_floats_say(pair):
    """A foot is held in its swing, and the ground told to climb; both count the same way with high swings."""
    pair.walk.state.high_left = 0
    for n in pair.walk_with_a_held_foot():
        for name in ("high_left", "high_gone"):
            mine = pair.scale.metres(getattr(pair.walk.state, name) / 256)
            assert mine == pytest.approx(getattr(pair.twin, name), abs=0.001), (n, name)
        if n == 111:
            pair.walk.state.slope_q20[0], pair.twin.slope[0] = 1 << 18, 0.25
            pair.walk.state.uneven_q4, pair.twin.uneven = UNEVEN_Q4, pair.scale.metres(UNEVEN_Q4 / 16)
    assert pair.twin.high_gone > 0.05


@pytest.mark.parametrize(("name", "slow"), [("caramelo", True), ("spotmicro", True), ("parallel", False)])
def test_drives_that_are_too_slow_for_high_swings_walk_them_slowly(name, slow):
    robot = load_robot(name)
    figures = tuning.trot_figures(robot)
    froude = tuning.high_speed_m_s(robot) / (9.81 * figures.height_m) ** 0.5
    assert froude == pytest.approx(tuning.LATE_FROUDE, rel=0.001) if slow else froude > 2 * tuning.LATE_FROUDE
