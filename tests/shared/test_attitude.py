"""shared/sense/attitude.py against the float filter of the same law, and against motions that are known."""

import itertools
import math
import random
from array import array

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.record import pack
from shared.sense import attitude as a
from tests.float_twin.attitude import of_block, turned_back

from .bars import INT16
from .imu import ONE_G, angles_deg, apart_deg, block, counts, up

LEVEL = counts(0, 0, 0, 0)


def aligned(rate_hz=50, reading=LEVEL, **settings):
    """Return a filter that has just been aligned on one reading, and its twin."""
    made = block(rate_hz, **settings)
    other = of_block(made)
    for _ in range(made.align_ticks):
        step(made, other, reading)
    return made, other


def step(made, other, reading):
    """Give both filters a reading; returns the integers' flags, which must be the twin's."""
    flags = a.attitude_step(made, reading)
    assert flags == other.step(list(reading[:3]), list(reading[3:]))
    return flags


def twin_deg(other):
    return [math.degrees(angle) for angle in other.angles()]


def swaying(rate_hz, seconds, bias, noise):
    """Return (counts, true angles in deg) of a body that sways: roll at 1 Hz, pitch at 1.3 Hz, 15 deg each."""
    dice, size, found = random.Random(2), 0.26, []
    for tick in range(1, int(seconds * rate_hz) + 1):
        now, middle = tick / rate_hz, (tick - 0.5) / rate_hz
        roll, pitch = size * math.sin(math.tau * now), size * math.sin(math.tau * 1.3 * now)
        rates = [size * math.tau * f * math.cos(math.tau * f * middle) for f in (1, 1.3)]
        reading = counts(roll, size * math.sin(math.tau * 1.3 * middle), *rates, bias)
        reading[3:6] = counts(roll, pitch, 0, 0)[3:6]
        for i in range(6):
            reading[i] = max(-32768, min(32767, reading[i] + dice.randint(-noise, noise)))
        found.append((reading, (math.degrees(roll), math.degrees(pitch))))
    return found


@pytest.mark.parametrize(("rate_hz", "true_deg"), [(20, 0.2), (50, 0.05), (100, 0.05), (333, 0.05), (500, 0.05)])
def test_swaying_is_followed_like_the_float_filter_and_the_truth(rate_hz, true_deg):
    bias = (90, -60, 33)
    made, other = aligned(rate_hz, counts(0, 0, 0, 0, bias))
    for reading, truth in swaying(rate_hz, 8 if rate_hz <= 100 else 3, bias, 0):
        assert step(made, other, reading) == 0
        assert apart_deg(angles_deg(made), twin_deg(other)) <= 0.05
        assert apart_deg(angles_deg(made), truth) <= true_deg


@pytest.mark.parametrize("rate_hz", [50, 500])
def test_noise_does_not_part_it_from_the_float_filter(rate_hz):
    made, other = aligned(rate_hz)
    for reading, truth in swaying(rate_hz, 3, (0, 0, 0), 150):
        step(made, other, reading)
        assert apart_deg(angles_deg(made), twin_deg(other)) <= 0.03
        assert apart_deg(angles_deg(made), truth) <= 0.3


@pytest.mark.parametrize("rate_hz", [50, 500])
def test_a_turn_slower_than_the_units_is_not_lost(rate_hz):
    """0.05 deg/s is less than half a unit of 2^-18 rad a tick at 500 Hz; the accelerometer is not believed here."""
    made, _ = aligned(rate_hz, tolerance=0)
    reading = array("i", [7, 0, 0, 0, 0, ONE_G + 100])
    for _ in range(20 * rate_hz):
        assert a.attitude_step(made, reading) == a.ACCEL_REJECTED
    assert angles_deg(made)[0] == pytest.approx(7 / 131 * 20, abs=0.02)


@settings(max_examples=150)
@given(st.floats(-80, 80), st.floats(-170, 170))
def test_alignment_finds_the_attitude_at_rest(roll_deg, pitch_deg):
    reading = counts(math.radians(roll_deg), math.radians(pitch_deg), 0, 0)
    made, other = aligned(50, reading, align_ticks=20)
    seen = math.cos(math.radians(roll_deg))  # close to a roll of 90 degrees the pitch fades
    assert apart_deg(angles_deg(made), (roll_deg, pitch_deg)) <= 0.02 / seen
    assert apart_deg(angles_deg(made), twin_deg(other)) <= 0.01 / seen


def test_alignment_learns_the_gyros_bias():
    made, _ = aligned(50, counts(0, 0, 0, 0, (200, -300, 77)))
    assert list(made.bias) == [200 << 16, -300 << 16, 77 << 16]


@pytest.mark.parametrize("rate_hz", [20, 50, 500])
@pytest.mark.parametrize(("sway_rad", "least_deg", "most_deg"), [(0.02, 1.0, 2.0), (0.0, 0.01, 0.1)])
def test_a_bias_that_comes_as_the_sensor_warms_is_learnt(rate_hz, sway_rad, least_deg, most_deg):
    """1 deg/s in a minute about x and y: a chip that warms by 6 deg C (product specification 3.4, 6.1).

    A body at rest is believed faster than one that sways as it walks.
    """
    made, other = aligned(rate_hz)
    worst = []
    for tick in range(1, 90 * rate_hz + 1):
        bias = round(131 * min(1.0, tick / rate_hz / 60))
        roll, rate = sway_rad * math.sin(math.tau * 2 * tick / rate_hz), sway_rad * math.tau * 2
        step(made, other, counts(roll, 0, rate * math.cos(math.tau * 2 * (tick - 0.5) / rate_hz), 0, (bias, -bias, 0)))
        assert apart_deg(angles_deg(made), twin_deg(other)) <= 0.05
        worst.append(apart_deg(angles_deg(made), (math.degrees(roll), 0)))
    assert least_deg <= max(worst) <= most_deg
    assert worst[-1] <= 0.5
    assert [value / 65536 for value in made.bias] == pytest.approx([131, -131, 0], abs=6)


def test_after_a_knock_it_is_soon_right_at_rest_and_has_learnt_little():
    """Thrown over by 90 deg within a tick, which no gyroscope tells."""
    made, other = aligned()
    lying, learnt = counts(math.pi / 2, 0, 0, 0), 0
    for _ in range(5 * 50):
        step(made, other, lying)
        learnt = max(learnt, abs(made.bias[0]) / 65536 / 131)
    assert apart_deg(angles_deg(made), twin_deg(other)) <= 0.1
    assert learnt <= 0.1
    assert abs(angles_deg(made)[0] - 90) <= 1


def test_alignment_starts_again_when_the_robot_is_moved():
    made = block(align_ticks=10)
    for _ in range(9):
        assert a.attitude_step(made, LEVEL) == a.ALIGNING
    assert a.attitude_step(made, counts(0, 0, 0.5, 0)) == a.ALIGNING | a.MOVED_WHILE_ALIGNING
    for _ in range(10):
        assert a.attitude_step(made, LEVEL) == a.ALIGNING
    assert a.attitude_step(made, LEVEL) == 0


@pytest.mark.parametrize("push_g", [(0, 0, 0.3), (0, 0, -1), (0.8, 0, 0)])
def test_alignment_away_from_1_g_starts_again(push_g):
    made = block(align_ticks=5)
    flags = [a.attitude_step(made, counts(0, 0, 0, 0, push_g=push_g)) for _ in range(5)]
    assert flags[-1] == a.ALIGNING | a.ACCEL_REJECTED
    assert made.gathered == 0


def test_a_body_that_turns_slowly_is_not_aligned_on():
    """Falling over at 2, then 6 deg/s, as a bias may be; then 2 s at 2 deg/s, which gravity tells."""
    made, other = block(align_ticks=100), of_block(block(align_ticks=100))
    rates = [2] * 6 + [6] * 6 + [2] * 100 + [0] * 101
    pitches = itertools.accumulate(math.radians(rate / 50) for rate in rates)
    readings = [counts(0, pitch, 0, math.radians(rate)) for pitch, rate in zip(pitches, rates, strict=True)]
    flags = [step(made, other, reading) for reading in readings]
    assert [at for at, flag in enumerate(flags) if flag & a.MOVED_WHILE_ALIGNING] == [6, 12, 51, 90, 112]
    assert flags[-1] == a.ALIGNING
    assert made.gathered == 100


def test_readings_away_from_1_g_are_rejected_and_change_nothing():
    made, other = aligned()
    for count in range(1, 101):
        assert step(made, other, counts(0, 0, 0, 0, push_g=(0.7, 0, 0.1))) == a.ACCEL_REJECTED
        assert made.rejected_ticks == count
    assert angles_deg(made) == (0, 0)
    believed = counts(0, 0, 0, 0, push_g=(0.3, 0, 0))
    assert step(made, other, believed) == 0
    assert made.rejected_ticks == 0
    for _ in range(60 * 50):
        step(made, other, believed)
    assert angles_deg(made)[1] == pytest.approx(-math.degrees(math.atan(0.3)), abs=0.5)


def test_a_robot_on_its_back_reads_as_pitched_over():
    made, _ = aligned(50, counts(0, math.pi, 0, 0))
    assert apart_deg(angles_deg(made), (0, 180)) <= 0.01


def test_a_whole_turn_comes_back():
    """Pitch right over, past where angles would be singular, at 180 deg/s."""
    made, other = aligned()
    for tick in range(1, 101):
        step(made, other, counts(0, math.tau * tick / 100, 0, math.pi))
        assert apart_deg(angles_deg(made)[1:], [math.degrees(math.tau * tick / 100)]) <= 0.25
    assert apart_deg(angles_deg(made), (0, 0)) <= 0.25


def test_int16_extremes_keep_every_number_small():
    """Every corner of the input with any trust, from any start: no angle out of range, up stays a direction."""
    corners = list(itertools.product((-32768, 0, 32767), repeat=6))
    random.Random(1).shuffle(corners)
    for trust in (0, 655, 32767):
        made, _ = aligned(trust_q15=trust, tolerance=32767)
        for corner in corners:
            a.attitude_step(made, array("i", corner))
            size = math.hypot(*made.gravity) / 2**22
            assert 0.98 <= size <= 1.02
            assert all(-(1 << 30) <= value < 1 << 30 for value in pack(made))
            assert -16384 <= made.roll <= 16384
            assert -32768 <= made.pitch <= 32767


@settings(max_examples=200)
@given(st.lists(st.tuples(*[INT16] * 6), min_size=5, max_size=25), st.sampled_from((2048, 16384)))
def test_any_readings_are_survived(readings, one_g):
    made = block(one_g=one_g, align_ticks=2)
    for reading in readings:
        a.attitude_step(made, array("i", reading))
        assert -16384 <= made.roll <= 16384


def test_the_length_of_up_stays_1_within_its_error():
    made, _ = aligned()
    for reading, _ in swaying(50, 8, (0, 0, 0), 100):
        a.attitude_step(made, reading)
        assert abs(math.hypot(*made.gravity) / 2**22 - 1) <= 2**-10


def test_twin_turns_up_as_the_body_turns():
    """A body that rolls by 0.1 rad sees up where a body at a roll of 0.1 rad sees it."""
    assert turned_back(up(0, 0), (0.1, 0, 0)) == pytest.approx(up(0.1, 0))
    assert turned_back(up(0, 0), (0, 0.1, 0)) == pytest.approx(up(0, 0.1))
