"""The current step against its float twin and in closed loop; what it repairs, limits and refuses."""

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.robot.joint_units import RATE_PER_RAD_S, current_gains
from shared.joint.commutation import fill_sine, lead_angle
from shared.joint.current import (
    STEP_DONE,
    STEP_INPUT,
    STEP_LIMIT,
    STEP_SHAPE,
    STEP_TRIP,
    current_repair,
    current_reset,
    current_step,
    current_sum,
    limit_voltage,
    set_offsets,
)
from shared.joint.feed import feed_bus
from shared.joint.layout import SINE_SIZE, CurrentLoop
from shared.num.fixed import cos_q15, sin_q15
from shared.record import pack
from tests.float_twin import joint_current as twin

from .plant import BLDC, Plant, made

SQRT3 = math.sqrt(3)


def at_24_V(rotor=0):
    blocks = made()
    current_reset(blocks.loop, rotor)
    feed_bus(blocks.loop, blocks.settings, round(24 / blocks.units.volt_per_vu))
    return blocks


@pytest.fixture
def blocks():
    blocks = at_24_V()
    blocks.loop.pulse = 0
    blocks.loop.raw[:] = [2048] * 3
    return blocks


def step(loop, rotor, invalid=0):
    code = current_step(rotor, invalid, loop)
    return (code, current_repair(code, rotor, invalid, loop)) if code else (code, code)


def set_currents(blocks, i_d, i_q, rotor):
    """Write the readings for a current vector; return the currents they really stand for, in A."""
    angle = 7 * rotor / 16384 * math.tau
    alpha = i_d * math.cos(angle) - i_q * math.sin(angle)
    beta = i_d * math.sin(angle) + i_q * math.cos(angle)
    count = blocks.units.ampere_per_cu * 6
    phases = (alpha, SQRT3 / 2 * beta - alpha / 2, -SQRT3 / 2 * beta - alpha / 2)
    for k, ampere in enumerate(phases):
        blocks.loop.raw[k] = round(ampere / count) + 2048
    return [(blocks.loop.raw[k] - 2048) * count for k in range(3)]


def test_duties_within_a_thousandth_over_full_speed_and_current(blocks):
    """Every bus voltage, rotor angle, speed and current, with and without the voltage limit."""
    rng = random.Random(3)
    loop, units = blocks.loop, blocks.units
    kp, ki = current_gains(BLDC)
    worst, seen = 0.0, set()
    for _ in range(6000):
        bus, rotor = rng.randint(18 * 256, 30 * 256), rng.randrange(16384)
        feed_bus(loop, blocks.settings, bus)
        exact = twin.CurrentLoop(kp, ki / BLDC.drive.current_loop_hz, bus * units.volt_per_vu, 7, 0.0)
        i_q, w = rng.uniform(-2.2, 2.2), rng.uniform(-264, 264)
        i_ref = max(-2.0, min(2.0, i_q + rng.choice((0, 0.05, 0.3, 2)) * rng.uniform(-1, 1)))
        limit = loop.voltage_limit
        volts = w * BLDC.motor.torque_constant_Nm_A / 1.5 + 1.2 * i_q
        loop.feed_q = max(-limit, min(limit, round(volts / units.volt_per_vu)))
        loop.feed_d = max(-limit, min(limit, round(-w * 7 * 0.6e-3 * i_q / units.volt_per_vu)))
        loop.reference_q = round(i_ref / units.ampere_per_cu)
        loop.integral_d, loop.integral_q = rng.randint(-2000000, 2000000), rng.randint(-2000000, 2000000)
        loop.rotor, loop.masked = rotor, 0
        exact.feed_d, exact.feed_q = loop.feed_d * units.volt_per_vu, loop.feed_q * units.volt_per_vu
        exact.q_ref = loop.reference_q * units.ampere_per_cu
        exact.integral_d = loop.integral_d / 8192 * units.volt_per_vu
        exact.integral_q = loop.integral_q / 8192 * units.volt_per_vu
        phases = set_currents(blocks, 0.0, i_q, rotor)
        first, last = step(loop, rotor)
        assert last == STEP_DONE
        seen.add(first)
        exact.step(rotor / 16384 * math.tau, *phases)
        for k, expected in enumerate((exact.duty_a, exact.duty_b, exact.duty_c)):
            worst = max(worst, abs(loop.duty[k] / loop.period - expected))
    assert seen == {STEP_DONE, STEP_LIMIT, STEP_SHAPE}
    assert worst < 0.001


def test_sine_table_is_the_sine_and_a_quarter_turn_on_the_cosine():
    loop = CurrentLoop()
    fill_sine(loop)
    assert not any(pack(loop)[:-SINE_SIZE])
    assert all(loop.sine[i] == sin_q15(i * 64) and loop.sine[i + 256] == cos_q15(i * 64) for i in range(1024))


@given(st.integers(-20000, 20000), st.integers(-20000, 20000), st.integers(64, 14000))
def test_limit_voltage_cuts_d_first(d, q, limit):
    loop = CurrentLoop()
    loop.voltage_d, loop.voltage_q, loop.voltage_limit, loop.limit_square = d, q, limit, limit * limit
    limit_voltage(loop)
    expected_d, expected_q = twin.limit_voltage(d, q, limit)
    assert loop.voltage_d == expected_d
    assert abs(loop.voltage_q - expected_q) <= 0.5


def test_integral_does_not_wind_up_behind_the_voltage_limit(blocks):
    loop = blocks.loop
    loop.reference_q = 2979
    loop.feed_q = loop.voltage_limit
    for _ in range(2000):
        assert step(loop, 0)[1] == STEP_DONE
    assert abs(loop.integral_q) <= 8192
    assert loop.limited_steps == 2000


@given(st.lists(st.integers(0, 4095), min_size=3, max_size=3), st.integers(0, 16383), st.integers(-12288, 12288))
def test_any_reading_gives_duties_within_the_period(raw, rotor, wanted):
    loop = at_24_V(rotor).loop
    loop.reference_q = wanted
    for _ in range(4):
        loop.raw[:] = raw
        _, last = step(loop, rotor)
        assert last in (STEP_DONE, STEP_TRIP)
        assert all(0 <= loop.duty[k] <= loop.period for k in range(3))
        assert math.hypot(loop.current_d, loop.current_q) <= 27600


def test_trips_on_over_current_and_writes_equal_duties(blocks):
    loop = blocks.loop
    set_currents(blocks, 0.0, 5.2, 0)
    assert step(loop, 0) == (STEP_TRIP, STEP_TRIP)
    assert loop.tripped == 1
    assert len({loop.duty[k] for k in range(3)}) == 1
    set_currents(blocks, 0.0, 4.8, 0)
    assert step(loop, 0)[1] == STEP_DONE


@pytest.mark.parametrize("jump", [600, 4000, 8000, 15000])
def test_a_rotor_glitch_is_replaced_and_counted(blocks, jump):
    loop = blocks.loop
    assert step(loop, 100) == (STEP_DONE, STEP_DONE)
    assert step(loop, (100 + jump) & 16383) == (STEP_INPUT, STEP_DONE)
    assert (loop.rotor, loop.glitches) == (100, 1)
    assert step(loop, 120, invalid=1) == (STEP_INPUT, STEP_DONE)
    assert (loop.rotor, loop.glitches) == (100, 2)
    assert step(loop, 16000) == (STEP_DONE, STEP_DONE)  # through zero is no jump
    assert loop.rotor == 16000


@pytest.mark.parametrize("phase", [0, 1, 2])
def test_a_phase_without_a_sample_is_rebuilt(blocks, phase):
    loop = blocks.loop
    set_offsets(loop, 2050 << 4, 2040 << 4, 2047 << 4)
    true = (2150, 1990, 1997)
    loop.raw[:] = true
    assert current_sum(loop) == 0
    loop.raw[phase] = 17
    loop.masked = 1 << phase
    assert step(loop, 0)[1] == STEP_DONE
    assert loop.raw[phase] == true[phase]


def test_without_two_samples_the_voltage_turns_with_the_rotor(blocks):
    loop = blocks.loop
    loop.voltage_d, loop.voltage_q, loop.masked = 0, 3000, 0b110
    loop.raw[1] = 4095
    integral = loop.integral_q
    assert step(loop, 300) == (STEP_INPUT, STEP_DONE)
    assert (loop.integral_q, loop.voltage_q, loop.rotor) == (integral, 3000, 300)
    angle = 7 * 300 / 16384 * math.tau
    expected = twin.svpwm(-3000 * math.sin(angle), 3000 * math.cos(angle), 6144)
    for k in range(3):
        assert abs(loop.duty[k] / loop.period - expected[k]) < 0.001


@given(st.lists(st.integers(1800 << 4, 2298 << 4), min_size=3, max_size=3))
def test_offsets_are_taken_out(offsets):
    loop = at_24_V().loop
    set_offsets(loop, *offsets)
    loop.raw[:] = [(offset + 8) >> 4 for offset in offsets]
    step(loop, 0)
    assert abs(loop.current_d) <= 7
    assert abs(loop.current_q) <= 7
    assert abs(current_sum(loop)) <= 2


def locked_rotor_step():
    plant = Plant(elec_offset_brad=7000)
    plant.blocked = plant.bridge = True
    feed_bus(plant.loop, plant.settings, 6144)
    plant.loop.reference_q = round(2.0 / plant.units.ampere_per_cu)
    seen = []
    for _ in range(200):
        plant.current_step()
        seen.append(plant.i_q)
    return plant, seen


def test_locked_rotor_step_rises_below_a_millisecond_without_overshoot():
    plant, seen = locked_rotor_step()
    rise = next(i for i, x in enumerate(seen) if x >= 1.8) - next(i for i, x in enumerate(seen) if x >= 0.2)
    assert rise <= 9
    assert max(seen) <= 2.2
    assert seen[-1] == pytest.approx(2.0, rel=0.01)
    assert abs(plant.i_d) < 0.02
    assert plant.trips == 0


@pytest.mark.parametrize("speed", [-250.0, -40.0, 90.0, 250.0])
@pytest.mark.parametrize("direction", [1, -1])
def test_currents_within_one_percent_of_rated_at_any_speed(speed, direction):
    """Closed loop at a held speed; the encoder's answer is one step old, and the angle is led by that."""
    mean_d, error_q = held_speed(speed, direction, led=True)
    assert abs(error_q) < 0.02
    assert abs(mean_d) < 0.02


def test_an_old_angle_that_is_not_led_puts_current_on_the_d_axis():
    mean_d, _ = held_speed(250.0, 1, led=False)
    assert abs(mean_d) == pytest.approx(math.sin(250 * 7 * 1e-4), rel=0.1)


def held_speed(speed, direction, led):
    """Return the mean d current and the q current's mean error after the transient, without feed-forward."""
    plant = Plant(elec_offset_brad=20000, direction=direction)
    plant.bridge = True
    plant.inertia = 1e9
    plant.speed = speed
    feed_bus(plant.loop, plant.settings, 6144)
    plant.loop.reference_q = round(math.copysign(1.0, speed) * direction / plant.units.ampere_per_cu)
    if led:
        plant.state.rate = round(speed * RATE_PER_RAD_S)
        lead_angle(plant.loop, plant.settings, plant.state)
    for _ in range(400):
        plant.current_step()
    mean_d = mean_q = 0.0
    for _ in range(200):
        plant.current_step()
        mean_d += plant.i_d / 200
        mean_q += plant.i_q / 200
    assert plant.trips == 0
    return mean_d, mean_q - plant.loop.reference_q * plant.units.ampere_per_cu
