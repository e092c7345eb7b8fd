"""Commissioning in closed loop on the plain motor: what it finds, what it refuses and why, what it leaves unchanged."""

import cmath
import copy
import functools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.robot.joint_units import RATE_PER_RAD_S
from shared.joint import commission as c
from shared.joint import commission_state as s
from shared.joint import faults as f
from shared.joint.bend import corrected_rotor, fill_bend
from shared.joint.commutation import fill_sine
from shared.joint.drive_state import drive_arm, drive_disarm
from shared.joint.encoder import home_by_encoder
from shared.joint.layout import CurrentLoop
from shared.joint.outer import set_outer_gains
from shared.joint.probe import probe_begin, probe_step
from shared.joint.tick import begin_commission
from shared.joint.winding import winding_inductance, winding_step
from shared.record import pack
from shared.wire import names as w

from .plant import Plant

FULL, VERIFY = s.COMMISSION_FULL, s.COMMISSION_VERIFY


def begun(p, kind):
    p.run(5, setpoint=False)
    begin_commission(p.state, p.commission, kind)
    assert drive_arm(p.settings, p.state, p.io, w.MODE_COMMISSIONING) == w.RESULT_OK
    return p


def finished(p, kind=FULL):
    """Commission ``p`` to the end, and the tick in which a fault is latched."""
    return ended(begun(p, kind))


def ended(p):
    """Go on to the end of commissioning, and the tick in which a fault is latched."""
    while p.commission.phase:
        p.tick(setpoint=False)
    p.tick(setpoint=False)
    return p


@functools.cache
def by_phase():
    """Return a plain joint as it came to each phase of being commissioned: one run that many begin from."""
    p = begun(Plant(commissioned=False), FULL)
    found = {}
    while p.commission.phase:
        if p.commission.phase not in found:
            found[p.commission.phase] = copy.deepcopy(p)
        p.tick(setpoint=False)
    return found


def come_to(phase):
    """Return a plain joint that has just come to a phase of being commissioned."""
    return copy.deepcopy(by_phase()[phase])


def offset_error(p, true):
    return ((p.settings.elec_offset - true + 32768) & 65535) - 32768


@pytest.mark.parametrize(("offset", "direction", "sign"), [(12345, -1, 1), (50000, 1, -1)])
def test_it_finds_everything(offset, direction, sign):
    p = Plant(elec_offset_brad=offset, direction=direction, commissioned=False, sign=sign)
    p.settings.pole_pairs, p.settings.bemf, p.settings.omega_l = 11, 1, 1
    p.loop.kp, p.loop.ki = 400, 60
    p.settings.velocity_p, p.settings.velocity_i, p.settings.inertia, p.settings.accel = 100, 50, 30, 9000
    pose_rad, began_rad = 0.25, p.joint_rad()
    begun(p, FULL)
    p.commission.pose_given, p.commission.pose = 1, round(pose_rad / p.units.rad_per_rc)
    ended(p)
    wanted = Plant().blocks
    assert p.state.fault_code == 0
    assert (p.settings.commissioned, p.settings.direction, p.settings.pole_pairs) == (1, direction, 7)
    assert abs(offset_error(p, offset)) < 182  # 1 electrical degree
    assert p.settings.joint_encoder_sign == sign  # it turns with the rotor here
    assert p.loop.electrical_gain == 28 * direction
    assert p.state.drive_state == w.STATE_SWITCH_ON_DISABLED
    assert p.settings.bemf == pytest.approx(wanted.settings.bemf, rel=0.02)
    assert p.settings.omega_l == pytest.approx(wanted.settings.omega_l, rel=0.04)  # the plant is solved in four steps
    assert (p.loop.kp, p.loop.ki) == pytest.approx((wanted.loop.kp, wanted.loop.ki), rel=0.04)
    for name in ("inertia", "velocity_p", "velocity_i", "accel", "damp"):
        assert getattr(p.settings, name) == pytest.approx(getattr(wanted.settings, name), rel=0.04)
    ampere = p.friction / p.bldc.motor.torque_constant_Nm_A
    assert p.commission.coulomb / 16 * p.units.ampere_per_cu == pytest.approx(ampere, rel=0.05)
    assert p.commission.backlash / 16 < 2  # rc: this motor has none
    home_elsewhere(p)
    assert p.state.position * p.units.rad_per_rc == pytest.approx(
        pose_rad + sign * (p.joint_rad() - began_rad), abs=3e-4
    )


def home_elsewhere(p):
    """Home the joint, turned by hand to another place: by the zeros of both its encoders."""
    p.angle += 0.15 * p.units.gear
    p.read_slow()
    p.state.fraction = p.rotor()
    assert home_by_encoder(p.settings, p.state, p.io) == 1


def test_to_verify_moves_the_joint_by_at_most_an_electrical_turn_and_changes_nothing():
    start, far = Plant().joint_rad(), []

    class Watched(Plant):
        def tick(self, setpoint=True):
            super().tick(setpoint)
            far.append(abs(self.joint_rad() - start))

    p = Watched(elec_offset_brad=900)
    before, gains = pack(p.settings), (p.loop.kp, p.loop.ki)
    begun(p, VERIFY)
    p.run(6000, setpoint=False)
    assert (p.state.fault_code, p.state.drive_state) == (0, w.STATE_SWITCH_ON_DISABLED)
    assert (pack(p.settings), (p.loop.kp, p.loop.ki)) == (before, gains)
    assert math.degrees(max(far)) < 360 / 7 / 22 * 1.2


@pytest.mark.parametrize(
    ("kind", "arrange", "code"),
    [
        (FULL, lambda p: setattr(p, "offsets", [2400, 2048, 2048]), f.FAULT_COMMISSION_OFFSET),
        (FULL, lambda p: setattr(p.settings, "commission_bus_least", 7000), f.FAULT_COMMISSION_BUS),
        (FULL, lambda p: setattr(p, "blocked", True), f.FAULT_COMMISSION_NOT_FREE),
        (VERIFY, lambda p: setattr(p, "blocked", True), f.FAULT_COMMISSION_NOT_FREE),
        (FULL, lambda p: setattr(p, "r", 30.0), f.FAULT_COMMISSION_NO_CURRENT),
        (VERIFY, lambda p: setattr(p, "r", 30.0), f.FAULT_COMMISSION_NO_CURRENT),
        (FULL, lambda p: setattr(p, "l", 3e-5), f.FAULT_COMMISSION_WINDING),
        (FULL, lambda p: setattr(p, "friction", 0.045), f.FAULT_COMMISSION_FRICTION),
        (FULL, lambda p: setattr(p.settings, "velocity_w", 9), f.FAULT_COMMISSION_INERTIA),
        (VERIFY, lambda p: setattr(p, "swapped", True), f.FAULT_COMMISSION_PHASE_ORDER),
        (VERIFY, lambda p: setattr(p.settings, "elec_offset", 9000), f.FAULT_COMMISSION_OFFSET_CHANGED),
    ],
)
def test_refusals_have_a_reason_and_change_nothing(kind, arrange, code):
    p = Plant()
    arrange(p)
    before, gains = pack(p.settings), (p.loop.kp, p.loop.ki)
    finished(p, kind)
    assert p.state.fault_code == code
    assert pack(p.settings) == before
    assert (p.loop.kp, p.loop.ki) == gains
    assert (p.loop.reference_d, p.loop.reference_q, p.loop.probing) == (0, 0, 0)
    assert p.loop.electrical_gain == 4 * p.settings.pole_pairs * p.settings.direction


def refused(prepare, each):
    """Run only the rest phase with readings of our own."""
    p = Plant()
    begin_commission(p.state, p.commission, FULL)
    prepare(p)
    for tick in range(264):
        for k in range(3):
            p.loop.raw[k] = 2048
        each(p, tick)
        c.commission_step(p.loop, p.settings, p.state, p.io, p.commission)
    return p.commission.reason, p.commission.reason_value


def nothing(*_):
    pass


@pytest.mark.parametrize(
    ("prepare", "each", "reason", "value"),
    [
        (nothing, lambda p, t: p.loop.raw.__setitem__(1, 2048 + 15 * (-1) ** t), f.FAULT_COMMISSION_NOISE, 30),
        (nothing, lambda p, t: setattr(p.loop, "rotor", 100 + t % 12), f.FAULT_COMMISSION_ENCODER, 11),
        (lambda p: setattr(p.state, "rate", 9000), nothing, f.FAULT_COMMISSION_MOVING, 9000),
        (lambda p: setattr(p.state, "bus", 100), nothing, f.FAULT_COMMISSION_BUS, 100),
    ],
)
def test_checks_at_rest(prepare, each, reason, value):
    def with_bus(p):
        p.state.bus = 6144
        prepare(p)

    assert refused(with_bus, each) == (reason, value)


@pytest.mark.parametrize(
    ("raws", "reason", "value"),
    [((2400, 2100, 2100), f.FAULT_COMMISSION_SUM, 456), ((2300, 2048, 1796), f.FAULT_COMMISSION_PHASE_OPEN, 2)],
)
def test_phases_that_do_not_add_up_or_carry_nothing_are_refused(raws, reason, value):
    p = Plant()
    p.commission.phase, p.commission.kind, p.commission.phase_ticks = s.PHASE_SETTLE, FULL, 511
    for k, raw in enumerate(raws):
        p.loop.raw[k] = raw
    assert c.commission_step(p.loop, p.settings, p.state, p.io, p.commission) == s.PHASE_IDLE
    assert (p.commission.reason, p.commission.reason_value) == (reason, value)


def ramped(ticks, rc_a_tick):
    """Return a plant whose rotor turned evenly in so many ticks of the ramp, without any current."""
    p = Plant()
    p.commission.phase, p.commission.kind, p.commission.level = s.PHASE_RAMP, FULL, 64
    p.loop.voltage_limit = 1 << 20
    for tick in range(ticks):
        p.commission.phase_ticks = tick
        p.loop.rotor = tick * rc_a_tick & 16383
        winding_step(p.loop, p.settings, p.commission)
    return p


@pytest.mark.parametrize("rc_a_tick", [-60, -5, 5, 60])
def test_the_voltage_waits_while_the_rotor_turns(rc_a_tick):
    """Its back-EMF takes from the current: at that voltage it would be too much once the rotor stands."""
    assert ramped(100, rc_a_tick).commission.level <= 64 + 2  # a first tick knows of no other
    assert ramped(100, rc_a_tick // 20).commission.level > 4 * 64


def test_a_rotor_that_does_not_come_to_rest_is_named():
    p = ramped(8002, 20)
    assert (p.commission.reason, p.commission.reason_value) == (f.FAULT_COMMISSION_MOVING, 20 << 8)


def test_a_joint_encoder_that_does_not_follow_is_refused():
    class Stuck(Plant):
        def read_slow(self):
            super().read_slow()
            self.io.joint_raw = 77

    p = begun(Stuck(), VERIFY)
    p.run(4000, setpoint=False)
    assert p.state.fault_code == f.FAULT_COMMISSION_JOINT_ENCODER


@pytest.mark.parametrize("phase", range(s.PHASE_REST, s.PHASE_PROVE_POSITION + 1))
def test_it_can_be_stopped_in_every_phase_and_leaves_all_as_it_was(phase):
    p = come_to(phase)
    assert p.commission.phase == phase
    before = Plant(commissioned=False)
    p.run(20, setpoint=False)
    drive_disarm(p.state)
    p.tick(setpoint=False)
    assert p.state.drive_state == w.STATE_SWITCH_ON_DISABLED
    assert not p.bridge
    assert (p.loop.electrical_gain, p.loop.reference_d, p.loop.reference_q, p.commission.phase) == (28, 0, 0, 0)
    assert (p.loop.kp, p.loop.ki, p.loop.probing) == (before.loop.kp, before.loop.ki, 0)
    assert (p.loop.alternate_d, p.loop.alternate_q, max(p.loop.bend)) == (0, 0, 0)
    assert pack(p.settings) == pack(before.settings)


@pytest.mark.parametrize(("name", "pull_Nm"), [("a load that pulls one way", 0.006), ("viscous friction", 0.0)])
def test_inertia_and_friction_whatever_pulls(name, pull_Nm):
    """0.006 N m at the rotor are a tenth of what half of the current limit gives."""
    viscous_Nms_rad = 0.0 if pull_Nm else 3e-5

    class Pulled(Plant):
        def move(self, seconds):
            begun = self.commission.phase >= s.PHASE_SPIN
            self.load_Nm = (pull_Nm if begun else 0.0) + viscous_Nms_rad * self.speed
            super().move(seconds)

    p = finished(Pulled(commissioned=False))
    Nm = p.bldc.motor.torque_constant_Nm_A * p.units.ampere_per_cu
    assert p.state.fault_code == 0
    assert p.settings.inertia == pytest.approx(Plant().settings.inertia, rel=0.04)
    assert p.commission.coulomb / 16 * Nm == pytest.approx(p.friction, rel=0.1)
    assert p.commission.viscous / 65536 * Nm * RATE_PER_RAD_S == pytest.approx(viscous_Nms_rad, rel=0.15, abs=2e-6)


class Cogging(Plant):
    """Two waves of cogging, 4 and 1 % of the torque at the current limit, of 42 and 84 a turn."""

    waves = ((42, 0.04, 0.5), (84, 0.01, 2.0))
    acts_from = s.PHASE_RAMP

    def move(self, seconds):
        acts = self.commission.phase >= self.acts_from
        torque = self.bldc.motor.torque_constant_Nm_A * self.bldc.drive.current_limit_A * acts
        self.load_Nm = sum(share * torque * math.sin(order * self.angle + at) for order, share, at in self.waves)
        super().move(seconds)


def off_wave(p, order, share, at):
    """Return how far the wave of that order is found off a cogging, as a share of the torque at the current limit."""
    found = {getattr(p.settings, f"cogging_order_{k}"): k for k in range(3)}
    current, phase = (getattr(p.settings, f"cogging_{name}_{found[order]}") for name in ("current", "phase"))
    found_A = cmath.rect(current / 16 * p.units.ampere_per_cu, phase / 65536 * math.tau)
    return abs(found_A / p.bldc.drive.current_limit_A - cmath.rect(share * p.direction, at))


@pytest.mark.parametrize("direction", [1, -1])
def test_the_waves_of_the_cogging_are_found(direction):
    """Each within 15 % of the strongest: of the weaker one that is 60 %."""
    p = finished(Cogging(commissioned=False, direction=direction))
    assert p.state.fault_code == 0
    for wave in Cogging.waves:
        assert off_wave(p, *wave) < 0.15 * Cogging.waves[0][1]
    assert max(p.loop.wave_order) in (42, 84)  # and it has handed them to the interrupt


@pytest.mark.parametrize(
    ("phase", "part", "factor", "code"),
    [
        (s.PHASE_PROVE_CURRENT, "l", 0.6, f.FAULT_COMMISSION_CURRENT_LOOP),
        (s.PHASE_PROVE_CURRENT, "l", 1.6, f.FAULT_COMMISSION_CURRENT_LOOP),
        (s.PHASE_PROVE_VELOCITY, "inertia", 0.55, f.FAULT_COMMISSION_VELOCITY_LOOP),
        (s.PHASE_PROVE_VELOCITY, "inertia", 1.9, f.FAULT_COMMISSION_VELOCITY_LOOP),
        (s.PHASE_PROVE_POSITION, "inertia", 100.0, f.FAULT_COMMISSION_POSITION_LOOP),
    ],
)
def test_loops_that_are_not_what_was_found_are_named(phase, part, factor, code):
    before = pack(Plant(commissioned=False).settings)
    p = come_to(phase)
    setattr(p, part, getattr(p, part) * factor)
    ended(p)
    assert p.state.fault_code == code
    assert pack(p.settings) == before


def test_cogging_of_more_than_a_quarter_of_the_current_limit_is_named():
    class Rough(Cogging):
        waves = ((14, 0.35, 0.5),)
        acts_from = s.PHASE_CREEP

    assert finished(Rough(commissioned=False)).state.fault_code == f.FAULT_COMMISSION_COGGING


class Loose(Plant):
    """The joint follows the rotor's edge of a play, as one with friction does."""

    slack, at = math.radians(0.1), 0.3 / 22

    def joint_rad(self):
        angle = self.angle / self.units.gear
        self.at = min(angle + self.slack, max(angle - self.slack, self.at))
        return self.at


def test_too_much_play_is_named_at_once():
    p = begun(Loose(commissioned=False), FULL)
    p.slack = math.radians(0.7)
    while p.commission.phase and p.commission.reason == 0:
        p.tick(setpoint=False)
    assert p.commission.phase == s.PHASE_IDLE  # and not 20 s later, after another round
    p.tick(setpoint=False)
    assert p.state.fault_code == f.FAULT_COMMISSION_PLAY


def test_play_is_what_both_ways_differ_by():
    p = finished(Loose(commissioned=False))
    assert math.degrees(p.commission.backlash / 16 * p.units.rad_per_rc) == pytest.approx(0.2, abs=0.01)


def test_play_cannot_be_measured_without_a_joint_encoder():
    p = finished(Plant(commissioned=False, has_joint_encoder=False))
    assert (p.state.fault_code, p.commission.backlash) == (0, -1)


@given(st.integers(16, 0x3FFFF), st.integers(1, 20588))
def test_the_velocity_loops_gains_are_those_of_inertia_and_bandwidth(inertia, w):
    settings = Plant().settings
    before = pack(settings)
    kp = inertia / 4096 * w / 65536
    if set_outer_gains(settings, inertia, w) == 0:
        assert pack(settings) == before
        assert inertia > 0x3FFF0 or not 4.1 < kp * 4096 < 8100 or not 1.1 < kp * w / 4 < 8100
        return
    assert settings.velocity_p == pytest.approx(kp * 4096, abs=0.6 + kp * 4096 * 8 / w)
    assert settings.velocity_i == pytest.approx(settings.velocity_p / 4096 * w / 4, abs=1)
    assert settings.inertia == pytest.approx(inertia / 16, abs=0.6)
    accel = 1.2 * settings.commission_current * 4096 / inertia
    assert settings.accel == pytest.approx(max(16, min(65535, accel)), abs=3)


@pytest.mark.parametrize("phase", [s.PHASE_CREEP, s.PHASE_ROUND])
@pytest.mark.parametrize("how", ["disarmed", "emergency stop", "encoder lost"])
def test_it_can_be_stopped_while_a_field_holds_the_rotor(phase, how):
    p = come_to(phase)
    while p.loop.electrical_gain:
        p.tick(setpoint=False)
    assert (p.commission.phase, p.loop.reference_d) == (phase, p.settings.commission_current)
    before = pack(Plant(commissioned=False).settings)
    if how == "disarmed":
        drive_disarm(p.state)
    elif how == "emergency stop":
        p.io.e_stop = 1
    else:
        p.state.raised = f.FAULT_ENCODER_LOST
    p.tick(setpoint=False)
    assert not p.bridge
    assert (p.loop.electrical_gain, p.loop.reference_d, p.loop.reference_q, p.commission.phase) == (28, 0, 0, 0)
    assert pack(p.settings) == before


def test_an_emergency_stop_ends_it():
    p = come_to(s.PHASE_SPIN)
    p.io.e_stop = 1
    p.tick(setpoint=False)
    assert (p.state.fault_code, p.bridge, p.loop.probing) == (f.FAULT_EMERGENCY_STOP, False, 0)


@given(st.integers(200, 8000), st.integers(40, 4000), st.floats(0.001, 1.7))
def test_the_inductance_of_an_alternating_current(volt, current, x):
    """x = R T / L. Current and resistance are made from the law that the function inverts: 0.7 % and the rounding."""
    resistance = math.tanh(x / 2) * volt / current
    raw = round(resistance * 65536)
    found = winding_inductance(volt << 4, current << 4, raw)
    if raw < 1 or raw > 0x3FFFF or found == 0:
        assert raw < 1 or raw > 0x3FFFF or math.tanh(x / 2) > 0.699
        return
    assert found / 65536 == pytest.approx(resistance / x if x > 0.02 else volt / current / 2, rel=0.008, abs=3e-4)


def test_a_winding_that_settles_within_a_step_has_no_inductance():
    assert winding_inductance(1000 << 4, 1000 << 4, 50000) == 0


@given(st.lists(st.integers(-1500, 1500), min_size=4, max_size=4), st.integers(0, 16383))
def test_readings_are_straightened_as_the_harmonics_say(q4, rotor):
    loop = CurrentLoop()
    fill_sine(loop)
    fill_bend(loop, *q4)
    angle = rotor / 16384 * math.tau
    bend = q4[0] * math.cos(angle) + q4[1] * math.sin(angle)
    bend += q4[2] * math.cos(2 * angle) + q4[3] * math.sin(2 * angle)
    away = (corrected_rotor(loop, rotor) - rotor - bend / 16 + 8192) % 16384 - 8192
    lines = 0.005 * math.hypot(q4[0], q4[1]) / 16 + 0.02 * math.hypot(q4[2], q4[3]) / 16
    assert abs(away) <= 2 + lines


def test_an_unbent_reading_stays_as_it_is():
    loop = CurrentLoop()
    assert [corrected_rotor(loop, rotor) for rotor in range(0, 16384, 97)] == list(range(0, 16384, 97))


def test_sums_alternate_with_the_voltage_and_stay_small():
    loop = CurrentLoop()
    loop.level, loop.alternate_d = 1000, 300
    probe_begin(loop, 1)
    for _ in range(46000):
        loop.current_d, loop.voltage_d = 50 + 7 * loop.probe_sign, -23170 * loop.probe_sign
        probe_step(loop)
        assert loop.feed_d == 1000 + 300 * loop.probe_sign
    assert (loop.probe_steps, loop.sum_current_d, loop.sum_voltage_d) == (46000, 7 * 46000, -23170 * 46000)
    assert loop.sum_voltage_d >= -(1 << 30)
