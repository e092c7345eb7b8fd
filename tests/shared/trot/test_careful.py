"""Slow on uneven ground: the trot walks with care, in integers and in floats."""

import math
import random

import pytest

from host.robot import trot_tuning as tuning
from host.robot.file import load_robot, robot_names
from host.robot.scale import core_params
from shared.trot.ground import choose_care
from shared.trot.steer import turn_level

from .test_twin import MOST_BRAD, MOST_M, Pair


def roughen(pair, share):
    """Let the feet have stood off their plane by ``share`` of the leg, in both trots."""
    pair.walk.state.uneven_q4 = round(16 * share * pair.params.leg_length)
    pair.twin.uneven = share * pair.twin.leg_m


@pytest.mark.parametrize("name", robot_names())
def test_with_care_is_slow_low_and_uneven_in_both(name):
    """Over speeds, ways, slopes, tilts and grounds, but within 1 % of a limit."""
    pair, rng = Pair(name, 50), random.Random(7)
    state, high = pair.walk.state, pair.params.trot.high_distance
    most_m_s, found = 0.07 * math.sqrt(9.81 * pair.twin.h), set()
    for _ in range(3000):
        share, froude = rng.choice((0.0, 0.0013, 0.00247, 0.00253, 0.01)), rng.choice((0.0, 0.2, 0.99, 1.01, 4.0))
        course, state.high_left = rng.uniform(0, 4), rng.choice((0, 0, high))
        speed_m_s = [froude * most_m_s * way for way in ((1, 0), (-1, 0), (0, 1), (0, -1), (1, 1))[int(course)]]
        tilt, waits = [rng.choice((0.0, 0.05, -0.06, 0.0612, -0.0612)) for _ in range(2)], rng.choice((0, 1, 2, 50))
        state.known = pair.twin.known = rng.choice((0, 1, 100, 100))
        pair.twin.tilt, pair.twin.no_care_s = tilt, waits * pair.twin.dt
        state.tilt_q14.roll, state.tilt_q14.pitch = (round(16384 * part) for part in tilt)
        state.careful = -waits
        slope = [rng.choice((-0.2, -0.101, -0.099, 0.0, 0.05, 0.099, 0.101)) for _ in range(2)]
        roughen(pair, share)
        pair.twin.slope = slope
        state.slope_q20.x, state.slope_q20.y = (round(part * 2**20) for part in slope)
        pair.twin.high_left, pair.twin.foot_speed = float(state.high_left), speed_m_s
        state.foot_speed.x, state.foot_speed.y = map(pair.scale.lf_per_tick, speed_m_s)
        wanted = share > 0.0025 and 0 < froude < 1 and state.high_left == 0 and max(map(abs, slope)) < 0.1
        wanted = wanted and waits < 2 and state.known and max(map(abs, tilt)) < 0.061
        choose_care(pair.params, pair.walk)
        pair.twin.choose_care()
        assert (state.careful > 0) == pair.twin.careful == bool(wanted)
        assert max(0, -state.careful) * pair.twin.dt == pytest.approx(pair.twin.no_care_s)
        found.add(bool(wanted))
    assert found == {False, True}


@pytest.mark.parametrize("rate_hz", [50, 100, 200])
@pytest.mark.parametrize("name", ["caramelo", "parallel"])
@pytest.mark.parametrize("rough", [False, True])
def test_a_walk_with_care_is_the_same_in_both(name, rate_hz, rough):
    """Slowly, on tilts and rates of noise. With care, and only then, swings are higher and all feet stand longer."""
    pair, rng, tilt, paces, tops = Pair(name, rate_hz), random.Random(8), [0, 0], set(), set()
    state, setup = pair.walk.state, pair.params.trot
    for n in range(5 * rate_hz):
        tilt = [max(-100, min(100, t + rng.randint(-5, 5))) for t in tilt]
        roughen(pair, 0.01 if rough else 0.0)
        before = state.phase_q20
        pair.tick((0.05, 0.01, 0.1), tilt, [rng.randint(-200, 200) for _ in range(3)], moving=n > rate_hz // 2)
        if n > 3 * rate_hz:
            paces.add(state.phase_q20 - before & (1 << 20) - 1)
            tops |= {top for top, stands in zip(pair.walk.apex, pair.walk.stance, strict=True) if not stands}
    assert paces == {setup.phase_step_q20} | ({setup.careful_step_q20} if rough else set())
    assert tops == {setup.careful_lift if rough else setup.low_lift}
    assert pair.worst_brad < MOST_BRAD
    assert pair.worst_m < MOST_M


@pytest.mark.parametrize("rate_hz", [20, 50, 500])
@pytest.mark.parametrize("name", robot_names())
def test_its_gains_stay_within_what_the_core_can_multiply(name, rate_hz):
    """Also with the highest gain that a robot file may ask for."""
    robot = load_robot(name)
    own = dict(robot.trot) | {"level_share": tuning.NUMBERS["level_share"].most}
    setup = core_params(robot.model_copy(update={"trot": own}), rate_hz).trot
    assert setup.level_kp_q12 <= setup.careful_kp_q12 < 1 << 17
    assert setup.careful_lead_q12 <= 1 << 13
    assert setup.low_lift <= setup.careful_lift <= setup.high_lift


def test_a_tilt_is_turned_back_as_in_floats():
    """Over all tilts and gains: within 1 of the float, within the limits of both."""
    rng = random.Random(9)
    for _ in range(20000):
        kp_q12, wrong = rng.randrange(1 << 17), rng.randint(-(1 << 30), (1 << 30) - 1) >> rng.randrange(30)
        exact = -max(-8191, min(8191, wrong)) * kp_q12 / 4096
        assert abs(turn_level(kp_q12, wrong) - max(-16383, min(16383, exact))) <= 1
