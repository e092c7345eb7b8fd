"""shared/num/pid.py, shared/body/balance.py against float controllers: terms, wind-up, limits, the paper's limiter."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.body import balance as b
from shared.body.axes import Pose
from shared.num import pid
from shared.record import pack, unpack
from tests.float_twin.balance import ERROR_MAX_RAD, Balance
from tests.float_twin.pid import Pid
from tests.float_twin.si import planner_si, rad

from .bars import INT16, integers
from .robots import block

GAIN = integers(0, 32767)
LIMIT = integers(0, 16383)


def controller(kp_q12, ki_q16, kd_q10, integral_max, output_max):
    """Return a controller's block and the float controller with the same gains, in brad and ticks."""
    made = pid.Pid()
    unpack(made, (kp_q12, ki_q16, kd_q10, integral_max, output_max, 0, 0, 0))
    return made, Pid(kp_q12 / 4096, ki_q16 / 65536, kd_q10 / 1024, integral_max, output_max, 1)


@settings(max_examples=400)
@given(st.tuples(GAIN, GAIN, GAIN, LIMIT, LIMIT), st.lists(st.tuples(INT16, INT16), min_size=1, max_size=30))
def test_any_controller_is_the_float_one(gains, inputs):
    made, other = controller(*gains)
    for wanted, measured in inputs:
        got, exact = pid.pid_step(made, wanted, measured), other.step(wanted, measured, 8191)
        assert abs(got) <= gains[4]
        assert abs(made.integral_q12) <= gains[3] << 12
        if abs(made.integral_q12 / 4096 - other.integral) > 1:
            return  # at the very edge of the output's limit one of them held its integral and the other did not
        assert abs(got - exact) <= 2


def test_the_paper_gains_follow_the_float_controller_for_long():
    """Caramelo's balance on 20 000 ticks of a wandering tilt."""
    params = block("caramelo")
    made, other = controller(*pack(params.gains), params.integral_max, params.balance_max)
    dice, tilt, worst = random.Random(6), 0, 0
    for _ in range(20000):
        tilt += dice.randint(-60, 60) - (tilt >> 5)
        worst = max(worst, abs(pid.pid_step(made, 0, tilt) - other.step(0, tilt, 8191)))
    assert worst <= 2


def test_derivative_acts_on_the_measurement_only():
    made, _ = controller(0, 0, 1024, 0, 16383)
    assert pid.pid_step(made, 500, 100) == 0
    assert pid.pid_step(made, -8000, 100) == 0
    assert pid.pid_step(made, -8000, 130) == -30


def test_the_integral_holds_while_the_output_is_limited_and_lets_go_at_once():
    made, _ = controller(4096, 2048, 0, 16383, 1000)
    for _ in range(500):
        assert pid.pid_step(made, 3000, 0) == 1000
    assert made.integral_q12 <= 100 << 12
    assert pid.pid_step(made, -200, 0) < 0


def test_without_anti_windup_it_would_not_let_go():
    """The test above can fail: an integral that was allowed to grow keeps the output at its limit."""
    made, _ = controller(4096, 2048, 0, 16383, 1000)
    made.integral_q12 = 16383 << 12
    assert pid.pid_step(made, -200, 0) == 1000


def test_reset_forgets():
    made, _ = controller(4096, 4096, 4096, 16383, 16383)
    first = pid.pid_step(made, 700, 20)
    pid.pid_step(made, 700, 90)
    pid.pid_reset(made)
    assert pid.pid_step(made, 700, 20) == first


def balance_pair():
    """Return Caramelo's balance and its float twin."""
    params = block("caramelo")
    made = b.Balance()
    b.balance_setup(params, made)
    return made, Balance(planner_si(params).gains)


def pose(roll, pitch):
    made = Pose()
    made.roll, made.pitch = roll, pitch
    return made


@settings(max_examples=300)
@given(st.lists(st.tuples(INT16, INT16, INT16, INT16), min_size=1, max_size=30))
def test_the_limiter_holds_the_sum_whatever_is_measured(inputs):
    made, _ = balance_pair()
    limit = made.roll.output_max
    assert limit == round(0.45 * 65536 / math.tau)
    for want_roll, want_pitch, roll, pitch in inputs:
        b.balance_step(made, pose(want_roll, want_pitch), roll, pitch)
        assert abs(made.correction.roll) + abs(made.correction.pitch) <= limit + 1


def test_balance_follows_the_float_one():
    made, other = balance_pair()
    dice, tilt = random.Random(8), [0, 0]
    for _ in range(5000):
        tilt = [t + dice.randint(-150, 150) - (t >> 5) for t in tilt]
        b.balance_step(made, pose(100, -50), *tilt)
        exact = other.step((rad(100), rad(-50)), [rad(t) for t in tilt])
        assert max(abs(rad(pack(made.correction)[i]) - exact[i]) for i in range(2)) <= rad(3)


@pytest.mark.parametrize(("roll", "pitch"), [(5000, 5000), (-5000, 2000), (8000, -8000)])
def test_beyond_the_limit_both_corrections_shrink_alike(roll, pitch):
    made, _ = balance_pair()
    for _ in range(50):
        b.balance_step(made, pose(0, 0), roll, pitch)
    got = made.correction.roll, made.correction.pitch
    assert abs(got[0]) + abs(got[1]) == pytest.approx(made.roll.output_max, abs=2)
    assert (got[0] < 0, got[1] < 0) == (roll > 0, pitch > 0)


def test_a_tilt_is_answered_by_a_pose_against_it():
    made, _ = balance_pair()
    b.balance_step(made, pose(0, 0), 400, -300)
    assert made.correction.roll < 0 < made.correction.pitch


def test_release_fades_the_correction_and_forgets_the_rest():
    made, _ = balance_pair()
    for _ in range(30):
        b.balance_step(made, pose(0, 0), 900, -900)
    before = pack(made.correction)
    b.balance_release(made, 10)
    assert [abs(x) - abs(pack(made.correction)[i]) for i, x in enumerate(before)] == [10, 10]
    for _ in range(1000):
        b.balance_release(made, 10)
    assert made.roll.integral_q12 == made.pitch.integral_q12 == 0
    assert made.correction.roll == made.correction.pitch == 0


def test_error_is_limited_to_an_eighth_of_a_turn():
    assert pytest.approx(math.radians(45), abs=1e-3) == ERROR_MAX_RAD
    made, _ = controller(4096, 0, 0, 0, 16383)
    assert pid.pid_step(made, 30000, -30000) == 8191
