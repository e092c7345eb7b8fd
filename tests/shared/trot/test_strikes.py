"""A swing foot that something stops: how far behind it may be, and when it pushes hard; the integers by the floats."""

import random

import pytest

from host.robot.file import load_robot
from shared.body.params import LF_BITS
from shared.record import unpack
from shared.trot.react import detect_held_up, most_behind, strikes

from .test_friction import stood

ROBOTS = ("caramelo", "parallel", "pupper", "unitree-a1")


@pytest.mark.parametrize("name", ROBOTS)
def test_a_strike_is_one_in_floats(name):
    """Over swings, ways, lags and rates; decisions may differ where a push is within 4 lu of what is allowed."""
    twin, params, walk = stood(name)
    rng, metre, struck = random.Random(5), 1 << load_robot(name).length_shift, 0
    for _ in range(4000):
        leg, speed, swing = rng.randrange(4), rng.choice((-400, 400)), rng.choice((13000, 13200, 20000, 26100, 26300))
        behind, *rates = (round(rng.uniform(low, 0.06) * params.leg_length) for low in (-0.02, *[-0.06] * 4))
        walk.state.foot_speed.x, walk.state.swing_q15, walk.residual_rate[:] = speed << LF_BITS, swing, rates
        twin.foot_speed[0], twin.u = speed / metre / twin.dt, swing / 32768
        twin.residual_rate = [rate / metre for rate in rates]
        found = strikes(params, walk, leg, behind)
        struck += found
        assert twin.strikes(leg, (behind + (4 if found else -4)) / metre) == found
    assert struck == 0 if name in ("caramelo", "unitree-a1") else 200 < struck < 3000  # soft legs, and stiff ones


@pytest.mark.parametrize("name", ROBOTS)
def test_how_far_behind_a_foot_may_be_is_that_in_floats(name):
    """Within 4 lu, over swings and lags, whether the foot may be late or not."""
    twin, params, walk = stood(name)
    rng, metre = random.Random(6), 1 << load_robot(name).length_shift
    for _ in range(2000):
        swing, mate_lag, usual = rng.choice((4000, 12000, 14000, 30000)), rng.randint(-400, 900), rng.randint(0, 150)
        moved = [rng.randint(-900, 900) for _ in range(4)]
        walk.state.foot_speed.x, walk.state.swing_q15 = 400 << LF_BITS, swing
        twin.foot_speed[0], twin.u = 400 / metre / twin.dt, swing / 32768
        for leg in range(4):
            walk.before.legs[leg].x, walk.measured.legs[leg].x = 0, moved[leg]
        twin.before, twin.measured = [[0.0]] * 4, [[step / metre] for step in moved]
        for leg in range(4):
            if moved[leg] != 400:
                exact = twin.most_behind(leg, mate_lag / metre, usual / metre) * metre
                assert most_behind(params, walk, leg, mate_lag, usual) == pytest.approx(exact, abs=4)


def stop(params, walk, leg, *, swing_q15, falls=0.024, mate_falls=0.0, way=1):
    """One foot falls behind by parts of the leg a tick, from where it should be; return whether it is held up."""
    walk.held_up[leg], walk.apex[leg] = 0, params.trot.low_lift
    walk.state.foot_speed.x, walk.state.swing_q15 = way * 400 << LF_BITS, swing_q15
    unpack(walk.before, [0] * 12)
    unpack(walk.measured, [way * 500] * 12)  # both go ahead faster than the body: neither is late for its drives' lag
    for at, part in ((leg, falls), (3 - leg, mate_falls)):
        walk.residual_x[at] = walk.residual_rate[at] = -way * round(part * params.leg_length)
    detect_held_up(params, walk, leg)
    return walk.held_up[leg]


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("leg", [0, 1, 2, 3])
def test_a_foot_that_is_stopped_is_held_up_in_the_tick_in_which_that_shows(leg, way):
    """Parallel's drives lag by a tick: a foot that fell behind by 0.024 of the leg in one pushes like one at 0.048."""
    _, params, walk = stood("parallel")
    assert stop(params, walk, leg, swing_q15=20000, way=way)
    assert not stop(params, walk, leg, swing_q15=20000, falls=0.02, way=way)
    assert not stop(params, walk, leg, swing_q15=20000, mate_falls=0.01, way=way)  # its mate as well
    assert not stop(params, walk, leg, swing_q15=12000, way=way)  # the feet may still leave the ground
    assert not stop(params, walk, leg, swing_q15=27000, way=way)  # it has arrived


def test_a_knee_leg_beside_an_elbow_leg_may_just_be_late():
    _, params, walk = stood("parallel")
    for leg, knee in enumerate((1, 1, -1, -1)):
        params.legs[leg].knee = knee
    assert [bool(stop(params, walk, leg, swing_q15=20000)) for leg in range(4)] == [False, False, True, True]


@pytest.mark.parametrize("turn_18", [-2000, 2000])
def test_in_the_plane_a_foot_that_is_told_to_turn_is_not_held_up(turn_18):
    """Turning, a robot in the plane took its feet for held up: it swung high, and now and then began to crawl."""
    _, params, walk = stood("parallel")
    walk.state.turn_18 = turn_18
    assert stop(params, walk, 0, swing_q15=20000, falls=0.05)
    params.lateral_q12 = 0
    assert not stop(params, walk, 0, swing_q15=20000, falls=0.05)
    walk.state.turn_18 = 0
    assert stop(params, walk, 0, swing_q15=20000, falls=0.05)
