"""The cascade and the trajectory limiter: parts against their float twins, the whole joint in closed loop."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.robot.joint_units import RATE_PER_RAD_S
from shared.joint import cascade, commutation, feed, profile, report
from shared.joint.commutation import set_commutation
from shared.joint.drive_state import drive_arm
from shared.joint.encoder import home_by_encoder
from shared.wire import names as w
from tests.float_twin import joint_motion as twin

from .plant import BLDC, UPPER_RAD, Plant, made

INT16 = st.integers(-32768, 32767)
RATE = st.integers(-(1 << 19) + 1, (1 << 19) - 1)


def make(**setup):
    blocks = made(**setup)
    blocks.state.bus = 6144
    blocks.state.current_limit = blocks.settings.current_max
    return blocks


MADE = make()


@given(st.integers(-65536, 65536), INT16, INT16)
def test_wire_units(position, velocity, current):
    k, units = MADE.settings, MADE.units
    rc = cascade.position_from_wire(position, k.gear_q8)
    assert abs(rc * units.rad_per_rc - position / 65536 * math.tau) <= units.rad_per_rc
    rate = cascade.rate_from_wire(velocity, k.rate_q8)
    assert rate * units.rad_s_per_rate == pytest.approx(velocity / 4096 * math.tau, rel=1e-4, abs=units.rad_s_per_rate)
    ampere = cascade.current_from_wire(current, k.current_q14) * units.ampere_per_cu
    assert ampere == pytest.approx(current / 4096, rel=2e-4, abs=units.ampere_per_cu)


@given(st.integers(-(1 << 29), (1 << 29) - 1), RATE, st.integers(-24315, 24315), st.integers(0, 12000))
def test_reports_are_the_measured_values_in_the_wires_units(position, rate, current, bus):
    blocks = make(sign=-1)
    loop, k, s, units = blocks.loop, blocks.settings, blocks.state, blocks.units
    s.position, s.velocity, loop.current_q, s.bus = position, rate, current, bus
    angle = position * units.rad_per_rc / math.tau * 65536
    assert abs(report.report_position(k, s) - max(-32767, min(32767, angle))) <= 1
    turns = rate * units.rad_s_per_rate / math.tau * 4096
    assert abs(report.report_velocity(k, s) - max(-32767, min(32767, turns))) <= 2 + abs(turns) * 2e-4
    ampere = -current * units.ampere_per_cu * 4096
    assert abs(report.report_current(loop, k) - max(-32767, min(32767, ampere))) <= 1 + abs(ampere) * 1e-4
    assert abs(report.report_bus(k, s) - min(1023, bus * units.volt_per_vu * 16)) <= 1
    assert report.report_temperature(current) == max(-4095, min(4095, current))


@given(st.integers(0, (1 << 29) - 1), st.integers(1, 65535), st.integers(1, (1 << 18) - 1))
def test_braking_rate(distance, accel, rate_max):
    expected = min(rate_max, twin.braking_speed(distance, accel))
    rate = profile.braking_rate(distance, accel, rate_max)
    assert 0 <= rate <= rate_max
    assert expected - 48 <= rate <= expected + 17


@pytest.mark.parametrize("accel", [20, 500, 1685, 20000])
@pytest.mark.parametrize("target", [1, 100, -28682, 200000])
def test_the_trajectory_reaches_its_target_in_nearly_the_least_time(target, accel):
    s, rate_max, ticks = make().state, 146000, 0
    profile.profile_reset(s, 0, 0)
    while (s.profile != target << 8 or s.profile_rate) and ticks < 20000:
        before = s.profile
        assert abs(profile.profile_step(s, target << 8, 0, accel, rate_max)) <= accel
        assert abs(s.profile - before) <= rate_max
        assert abs(s.profile) <= (abs(target) << 8) + 4 * accel
        ticks += 1
    distance = abs(target) << 8
    least = 2 * math.sqrt(distance / accel)
    if accel * least / 2 > rate_max:
        least = distance / rate_max + rate_max / accel
    assert ticks <= 1.02 * least + 4


@given(st.lists(st.tuples(st.integers(-20000, 20000), st.integers(-3000, 3000)), min_size=1, max_size=40))
def test_the_trajectory_follows_its_twin(targets):
    s, accel, rate_max = make().state, 1685, 146000
    profile.profile_reset(s, 0, 0)
    for target, rate in targets:
        for tick in range(5):
            wanted = (target << 8) + rate * tick
            position, speed = twin.profile(s.profile, s.profile_rate, wanted, rate, accel, rate_max)
            profile.profile_step(s, wanted, rate, accel, rate_max)
            assert abs(s.profile - position) <= 50
            assert abs(s.profile_rate - speed) <= 50


def test_a_moving_target_is_met_and_kept():
    s = make().state
    profile.profile_reset(s, 0, 0)
    for tick in range(400):
        target = 100000 + 5000 * tick
        profile.profile_step(s, target, 5000, 1685, 146000)
    assert (s.profile, s.profile_rate) == (target, 5000)


@given(RATE, st.integers(-3000, 3000))
def test_feed_forward_voltages(rate, current):
    blocks = make()
    loop, settings, state, units = blocks.loop, blocks.settings, blocks.state, blocks.units
    settings.dead = 800
    feed.feed_bus(loop, settings, 6144)
    loop.reference_q, state.rate = current, rate
    feed.feed_voltages(loop, settings, state)
    rad_s, motor = rate / RATE_PER_RAD_S, BLDC.motor
    d, q = twin.feed_voltages(
        rad_s,
        current,
        motor.torque_constant_Nm_A / 1.5,
        rad_s * motor.pole_pairs * motor.inductance_H * units.ampere_per_cu,
        24 * 800 / 32768,
        settings.dead_zone,
        rad_s * motor.pole_pairs * 1.5e-4,
    )
    limit = loop.voltage_limit
    assert max(abs(loop.feed_d), abs(loop.feed_q)) <= limit
    if math.hypot(d, q) / units.volt_per_vu < 0.99 * limit:
        assert abs(loop.feed_d - d / units.volt_per_vu) < 10
        assert abs(loop.feed_q - q / units.volt_per_vu) < 10


@given(RATE, st.integers(0, 65535), st.sampled_from((-1, 1)))
def test_the_angle_is_led_by_the_age_of_its_reading(rate, offset, direction):
    blocks = make()
    loop, settings, state = blocks.loop, blocks.settings, blocks.state
    settings.elec_offset, settings.direction, state.rate = offset, direction, rate
    set_commutation(loop, settings)
    still = loop.electrical_offset
    brad_per_rate = BLDC.motor.pole_pairs * 1e-4 / RATE_PER_RAD_S / math.tau * 65536
    expected = twin.lead_angle(still, rate, brad_per_rate, direction)
    assert commutation.lead_angle(loop, settings, state) == loop.electrical_offset
    assert abs(loop.electrical_offset - expected) <= 1 + abs(rate) / 131072  # age is rounded


@given(st.integers(-(1 << 17), 1 << 17), st.integers(-2000, 2000), st.integers(-40000000, 40000000))
def test_velocity_loop(error, direct, integral):
    blocks = make()
    s, k = blocks.state, blocks.settings
    s.rate_reference, s.velocity_integral = error, integral
    given_cu = cascade.velocity_loop(k, s, direct)
    kp, ki = k.velocity_p / 4096, k.velocity_i / 65536
    expected, grown = twin.velocity_loop(error, integral / 4096, kp, ki, direct, s.current_limit)
    assert abs(given_cu - expected) <= 3
    if abs(given_cu) < s.current_limit - 3:
        assert abs(s.velocity_integral / 4096 - grown) <= 1


@given(INT16, st.integers(0, 32767), st.integers(0, 32767), INT16, INT16, st.integers(-60000, 110000), RATE)
def test_impedance(position, stiffness, damping, velocity, current, at, rate):
    blocks = make()
    b, s, units = blocks.io, blocks.state, blocks.units
    b.position, b.stiffness, b.damping = position, stiffness, damping
    b.velocity, b.current = velocity, current
    s.position, s.velocity = at, rate
    turn = math.tau / units.rad_per_rc
    wanted = max(blocks.settings.position_min / turn, min(blocks.settings.position_max / turn, position / 65536))
    error = max(-0.125, min(0.125, wanted - at / turn))
    slip = velocity / 4096 - rate * units.rad_s_per_rate / math.tau
    damped = max(-8.0, min(8.0, slip))
    expected = twin.impedance(stiffness / 16, damping / 256, error, damped, current / 4096)
    result = cascade.impedance(blocks.settings, s, b) * units.ampere_per_cu
    assert abs(result) <= 8.26
    if abs(expected) < 7.9 and abs(slip) < 2.8:  # the difference of rates is limited to 2.84 turn/s
        assert abs(result - expected) <= 0.02 + stiffness / 16 * 2e-5 + damping / 256 * 2e-3


def test_limit_current_falls_with_the_bus_and_says_why():
    blocks = make()
    s, k = blocks.state, blocks.settings
    top = s.current_limit
    assert cascade.limit_current(k, s, 5000) == top
    assert s.limits == w.LIMIT_CURRENT
    s.limits, s.velocity = 0, 1000
    s.bus = (k.under + k.under_start) // 2
    assert abs(cascade.limit_current(k, s, 5000) - top / 2) <= 1
    assert cascade.limit_current(k, s, -5000) == -top
    assert s.limits == w.LIMIT_UNDER_VOLTAGE | w.LIMIT_CURRENT
    s.limits, s.bus = 0, k.over
    assert cascade.limit_current(k, s, -5000) == 0
    assert cascade.limit_current(k, s, 5000) == top
    assert s.limits & w.LIMIT_OVER_VOLTAGE


@given(st.lists(st.integers(-65535, 65535), min_size=1, max_size=40))
def test_the_accelerations_current_follows_its_twin_and_comes_back_to_nothing(changes):
    blocks = make()
    inertia, fed = blocks.settings.inertia / 256, 0.0
    for change in changes:
        fed = twin.smooth(fed, change * inertia)
        assert abs(cascade.feed_acceleration(blocks.settings, blocks.state, change) - fed) <= 1
    for _ in range(100):
        cascade.feed_acceleration(blocks.settings, blocks.state, 0)
    assert blocks.state.current_reference == 0


@given(
    st.integers(-(1 << 20), 1 << 20),
    st.integers(-(1 << 18), 1 << 18),
    st.integers(-(1 << 18), 1 << 18),
    st.integers(0, 16),
)
def test_the_target_glides_to_its_goal_and_meets_it_exactly(apart, rate, feed, left):
    state = make().state
    state.target, state.target_rate, state.goal_position, state.target_ticks_left = 0, rate, apart, left
    target, speed, last = 0.0, float(rate), 0
    for tick in range(max(1, left)):
        target, speed = twin.glide(target, speed, apart + feed * tick, feed, left - tick)
        state.goal_position = apart + feed * tick
        last = cascade.glide(state, feed)
        assert abs(state.target - target) <= 2 * left + 1
    assert state.target == apart + feed * (max(1, left) - 1)
    assert (state.target_rate, state.target_ticks_left) == (feed, 0)
    assert last == feed or left > 1


def test_a_motion_of_even_acceleration_sent_at_200_hz_has_even_acceleration():
    """Set-points every 5 ms, each with its velocity: unsmoothed every one would be a jump of 5 ms' worth."""
    blocks, rates = make(), []
    accel = 500.0  # rate units a tick, half of what the trajectory may do
    blocks.state.homed = 1
    cascade.cascade_reset(blocks.settings, blocks.state)
    gear = blocks.settings.gear_q8
    for tick in range(150):
        if tick % 5 == 0:
            blocks.io.position = round(accel * tick * tick / 2 / 256 * 1024 / gear)
            blocks.io.velocity = round(accel * tick * 256 / blocks.settings.rate_q8)
            blocks.state.sequence += 1
        cascade.follow_position(blocks.settings, blocks.state, blocks.io)
        rates.append(blocks.state.profile_rate)
    changes = [b - a for a, b in pairwise(rates[20:])]
    assert max(abs(change - accel) for change in changes) < 0.8 * accel  # the wire's steps: 281
    assert sum(abs(change - accel) for change in changes) / len(changes) < 0.25 * accel


@given(RATE)
def test_damping_only_brakes(rate):
    blocks = make()
    blocks.state.velocity = rate
    current = cascade.damping_current(blocks.settings, blocks.state)
    assert current * rate <= 0
    assert abs(current) <= blocks.settings.damp_current


@pytest.mark.parametrize(("position", "current", "given_cu"), [(-60000, -500, 0), (-60000, 500, 500), (120000, 500, 0)])
def test_no_current_pushes_beyond_a_position_limit(position, current, given_cu):
    blocks = make()
    blocks.state.position = position
    assert cascade.guard_position(blocks.settings, blocks.state, current) == given_cu
    assert bool(blocks.state.limits & w.LIMIT_POSITION) == (given_cu == 0)


def armed(mode=w.MODE_POSITION, **plant):
    p = Plant(elec_offset_brad=12345, direction=-1, **plant)
    p.run(3)
    assert home_by_encoder(p.settings, p.state, p.io)
    p.io.mode = mode
    p.io.position = p.wire_position(p.joint_rad())
    p.tick()
    assert drive_arm(p.settings, p.state, p.io, w.MODE_OFF) == w.RESULT_OK
    p.run(5)
    assert p.state.drive_state == w.STATE_OPERATION_ENABLED
    return p


@pytest.mark.parametrize("inertia", [0.003, 0.01, 0.02])
def test_position_step_settles_without_overshoot_within_the_current_limit(inertia):
    p = armed(inertia_kg_m2=inertia)
    start = p.joint_rad()
    p.io.position = p.wire_position(start + 0.5)
    highest, current, seen = 0.0, 0.0, 0
    for _ in range(600):
        p.tick()
        highest = max(highest, p.joint_rad() - start)
        current = max(current, abs(p.i_q))
        seen |= p.state.limits
    assert abs(p.joint_rad() - start - 0.5) < math.radians(0.2)
    assert highest < 0.5 * 1.05
    assert current < 2.0 * 1.05
    assert seen & w.LIMIT_ACCELERATION
    assert p.state.fault_code == 0


def test_sine_of_two_hertz_is_tracked_within_a_degree():
    p = armed()
    base, total = p.joint_rad(), 0.0
    for i in range(1200):
        phase = 2 * math.tau * i / 1000
        if p.ticks % 5 == 0:
            p.io.position = p.wire_position(base + 0.3 * math.sin(phase))
            p.io.velocity = p.wire_velocity(0.6 * math.tau * math.cos(phase))
        p.tick()
        if i >= 700:
            total += (p.joint_rad() - base - 0.3 * math.sin(phase)) ** 2
    assert math.degrees(math.sqrt(total / 500)) < 1.0


def test_velocity_mode_holds_its_speed_and_slows_down_before_the_limit():
    p = armed(w.MODE_VELOCITY)
    p.io.velocity = p.wire_velocity(3.0)
    speeds, seen = [], 0
    for _ in range(900):
        p.tick()
        speeds.append(p.speed / 22)
        seen |= p.state.limits
    assert speeds[300] == pytest.approx(3.0, rel=0.02)
    assert seen & w.LIMIT_POSITION
    assert p.joint_rad() < UPPER_RAD + math.radians(1)
    assert abs(speeds[-1]) < 0.05
    p.io.velocity = p.wire_velocity(-40.0)
    p.tick()
    assert p.state.limits & w.LIMIT_VELOCITY


def test_stall_torque_in_current_mode_is_that_of_two_ampere():
    p = armed(w.MODE_CURRENT)
    p.blocked = True
    p.io.current = 3 * 4096
    p.run(200)
    torque = 1.5 * p.pp * p.psi * p.i_q * p.direction * 22
    assert torque == pytest.approx(3.0, rel=0.03)
    assert p.state.limits & w.LIMIT_CURRENT
    assert p.state.fault_code == 0


def test_impedance_mode_is_a_spring():
    p = armed(w.MODE_IMPEDANCE)
    stiffness = 20.0  # N m/rad
    per_turn = stiffness / (p.bldc.motor.torque_constant_Nm_A * 22) * math.tau
    p.io.stiffness, p.io.damping = round(per_turn * 16), round(0.03 * per_turn * 256)
    p.friction = 0.0
    start = p.joint_rad()
    p.load_Nm = 1.0 / 22  # 1 N m at the joint
    p.run(1500)
    assert start - p.joint_rad() == pytest.approx(1.0 / stiffness, rel=0.05)


def test_between_set_points_the_target_moves_on_only_for_a_while():
    p = armed()
    start = p.joint_rad()
    p.io.position = p.wire_position(start)
    p.io.velocity = p.wire_velocity(2.0)
    p.ticks = 0
    p.tick()
    p.run(90, setpoint=False)
    moved = (p.state.target >> 8) * p.units.rad_per_rc - start
    assert moved == pytest.approx(2.0 * 0.010, abs=0.001)
    assert p.joint_rad() - start == pytest.approx(moved, abs=0.002)
