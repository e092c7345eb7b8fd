"""SVPWM: linear to bus / sqrt 3, within 0.0005 of the closed form, never outside the period; pulses and windows."""

import math
import random

from hypothesis import given
from hypothesis import strategies as st

from shared.joint.feed import feed_bus
from shared.joint.layout import CurrentLoop, JointSettings
from shared.joint.svpwm import shape_pulse, svpwm
from tests.float_twin import joint_current as twin

PERIOD = 4200


def block(bus, period=PERIOD, pulse=0, window=0):
    loop = CurrentLoop()
    settings = JointSettings()
    settings.bus_least = 512
    loop.period, loop.half_period = period, period * 8 + 8
    loop.pulse, loop.window = pulse, window
    feed_bus(loop, settings, bus)
    return loop


def duties(loop):
    return [loop.duty[k] / loop.period for k in range(3)]


def test_ten_thousand_vectors_up_to_the_linear_range():
    rng = random.Random(1)
    worst = 0.0
    for _ in range(10_000):
        bus = rng.randint(2000, 11000)
        loop = block(bus)
        length = loop.voltage_limit * 16 * math.sqrt(rng.random()) if rng.random() < 0.8 else loop.voltage_limit * 16
        turn = rng.random() * math.tau
        alpha, beta = int(length * math.cos(turn)), int(length * math.sin(turn))
        svpwm(loop, alpha, beta)
        expected = twin.svpwm(alpha, beta, bus * 16)
        worst = max(worst, max(abs(a - b) for a, b in zip(duties(loop), expected, strict=True)))
        assert all(0 <= d <= 1 for d in duties(loop))
    assert worst < 0.0005


@given(st.integers(2000, 11000), st.integers(0, 200), st.floats(0, math.tau), st.integers(0, 400))
def test_never_outside_even_for_twice_the_vector(bus, percent, turn, pulse):
    loop = block(bus, pulse=pulse)
    length = loop.voltage_limit * 16 * percent / 100
    svpwm(loop, int(length * math.cos(turn)), int(length * math.sin(turn)))
    for k in range(3):
        duty = loop.duty[k]
        assert duty in (0, PERIOD) or pulse <= duty <= PERIOD - pulse


@given(st.integers(-(1 << 29), 1 << 29), st.integers(0, 500), st.integers(1000, 7000))
def test_shape_pulse_is_the_nearest_that_can_be_made(duty, pulse, period):
    shaped = shape_pulse(duty, pulse, period)
    assert shaped in (0, period) or pulse <= shaped <= period - pulse
    if 0 <= duty <= period:
        assert abs(shaped - duty) <= pulse / 2


def test_masks_the_phases_without_time_for_a_sample():
    loop = block(6144, window=420)
    assert svpwm(loop, 0, 0) == 0
    assert svpwm(loop, loop.voltage_limit * 16, 0) == 0b001
    assert svpwm(loop, -loop.voltage_limit * 16, 0) == 0b110
