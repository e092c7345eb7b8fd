"""Calibration in closed loop on the plain motor: what it finds, what it refuses and why, what it leaves unchanged."""

import math
import random

import pytest

from shared.joint import calibration as c
from shared.joint import faults as f
from shared.joint.drive_state import drive_arm, drive_disarm
from shared.joint.encoder import home_by_encoder
from shared.joint.tick import begin_calibration
from shared.record import pack
from shared.wire import names as w

from .plant import Plant


def calibrate(kind, arrange=None, pose_rad=None, ticks=12000, **plant):
    p = Plant(**plant)
    if arrange:
        arrange(p)
    for _ in range(5):
        p.tick(setpoint=False)
    begin_calibration(p.state, p.calibration, kind)
    if pose_rad is not None:
        p.calibration.pose_given, p.calibration.pose = 1, round(pose_rad / p.units.rad_per_rc)
    assert drive_arm(p.settings, p.state, p.io, w.MODE_CALIBRATING) == w.RESULT_OK
    for tick in range(ticks):
        p.tick(setpoint=False)
        if tick > 10 and p.state.drive_state in (w.STATE_SWITCH_ON_DISABLED, w.STATE_FAULT):
            break
    return p


def offset_error(p, true):
    return ((p.settings.elec_offset - true + 32768) & 65535) - 32768


@pytest.mark.parametrize(("offset", "direction", "sign"), [(12345, -1, 1), (50000, 1, -1)])
def test_full_calibration_finds_everything(offset, direction, sign):
    p = calibrate(
        c.CAL_FULL, lambda p: setattr(p.settings, "pole_pairs", 0),
        elec_offset_brad=offset, direction=direction, calibrated=False, sign=sign,
    )  # fmt: skip
    assert p.state.fault_code == 0
    assert (p.settings.calibrated, p.settings.direction, p.settings.pole_pairs) == (1, direction, 7)
    assert abs(offset_error(p, offset)) < 364  # 2 electrical degrees
    assert p.settings.joint_encoder_sign == sign  # it turns with the rotor here
    assert p.loop.electrical_gain == 28 * direction
    assert p.state.drive_state == w.STATE_SWITCH_ON_DISABLED


@pytest.mark.parametrize("seed", range(4))
def test_small_calibration_moves_the_joint_by_little_more_than_a_degree_to_either_side(seed):
    rng = random.Random(seed)
    offset, direction = rng.randrange(65536), rng.choice((1, -1))
    p = Plant(elec_offset_brad=offset, direction=direction, calibrated=False)
    start, far = p.joint_rad(), 0.0
    p.offsets = [2048 + rng.uniform(-9, 9) for _ in range(3)]
    for _ in range(5):
        p.tick(setpoint=False)
    begin_calibration(p.state, p.calibration, c.CAL_SMALL)
    drive_arm(p.settings, p.state, p.io, w.MODE_CALIBRATING)
    for _ in range(6000):
        p.tick(setpoint=False)
        far = max(far, abs(p.joint_rad() - start))
    assert p.state.fault_code == 0
    assert abs(offset_error(p, offset)) < 364
    assert p.settings.direction == direction
    assert math.degrees(far) < 360 / 7 / 22 * 1.1
    for k in range(3):
        assert abs(p.loop.offset_q4[k] / 16 - p.offsets[k]) < 1


def test_the_pose_sets_both_zeros():
    pose = 0.25
    p = calibrate(c.CAL_SMALL, pose_rad=pose, elec_offset_brad=900, calibrated=False)
    zero_rad = 0.3 / 22 - pose  # the plant starts at 0.3 rad of the rotor
    p.angle = (zero_rad + 0.4) * 22
    p.read_slow()
    p.state.fraction = p.rotor()
    assert home_by_encoder(p.settings, p.state, p.io) == 1
    assert p.state.position * p.units.rad_per_rc == pytest.approx(0.4, abs=2e-4)


@pytest.mark.parametrize(
    ("kind", "arrange", "code"),
    [
        (c.CAL_FULL, lambda p: setattr(p, "offsets", [2400, 2048, 2048]), f.FAULT_CAL_OFFSET),
        (c.CAL_FULL, lambda p: setattr(p.settings, "cal_bus_least", 7000), f.FAULT_CAL_BUS),
        (c.CAL_FULL, lambda p: setattr(p.settings, "cal_current", 0), f.FAULT_CAL_NOT_FREE),
        (c.CAL_FULL, lambda p: setattr(p, "blocked", True), f.FAULT_CAL_NOT_FREE),
        (c.CAL_SMALL, lambda p: setattr(p, "blocked", True), f.FAULT_CAL_NOT_FREE),
        (c.CAL_FULL, lambda p: setattr(p.settings, "pole_pairs", 11), f.FAULT_CAL_POLE_PAIRS),
        (c.CAL_VERIFY, lambda p: setattr(p, "swapped", True), f.FAULT_CAL_PHASE_ORDER),
        (c.CAL_VERIFY, lambda p: setattr(p.settings, "elec_offset", 9000), f.FAULT_CAL_OFFSET_CHANGED),
        (c.CAL_SMALL, lambda p: setattr(p, "r", 30.0), f.FAULT_CAL_NO_CURRENT),
    ],
)
def test_refusals_have_a_reason_and_change_nothing(kind, arrange, code):
    p = Plant()
    arrange(p)
    before = pack(p.settings)
    p = calibrate(kind, arrange)
    assert p.state.fault_code == code
    assert pack(p.settings) == before
    assert (p.loop.reference_d, p.loop.reference_q) == (0, 0)
    assert p.loop.electrical_gain == 4 * p.settings.pole_pairs * p.settings.direction


def refused(prepare, each):
    """Run only the rest phase with readings of our own."""
    p = Plant()
    begin_calibration(p.state, p.calibration, c.CAL_FULL)
    prepare(p)
    for tick in range(260):
        for k in range(3):
            p.loop.raw[k] = 2048
        each(p, tick)
        c.calibration_step(p.loop, p.settings, p.state, p.io, p.calibration)
    return p.calibration.reason, p.calibration.reason_value


def nothing(*_):
    pass


@pytest.mark.parametrize(
    ("prepare", "each", "reason", "value"),
    [
        (nothing, lambda p, t: p.loop.raw.__setitem__(1, 2048 + 15 * (-1) ** t), f.FAULT_CAL_NOISE, 30),
        (nothing, lambda p, t: setattr(p.loop, "rotor", 100 + t % 12), f.FAULT_CAL_ENCODER, 11),
        (lambda p: setattr(p.state, "rate", 9000), nothing, f.FAULT_CAL_MOVING, 9000),
        (lambda p: setattr(p.state, "bus", 100), nothing, f.FAULT_CAL_BUS, 100),
    ],
)
def test_checks_at_rest(prepare, each, reason, value):
    def with_bus(p):
        p.state.bus = 6144
        prepare(p)

    assert refused(with_bus, each) == (reason, value)


def test_a_wrong_sum_under_current_is_refused():
    p = Plant()
    p.calibration.phase, p.calibration.kind, p.calibration.phase_ticks = c.PHASE_SETTLE, c.CAL_FULL, 511
    for k, raw in enumerate((2400, 2100, 2100)):
        p.loop.raw[k] = raw
    p.loop.current_d = p.settings.cal_current
    assert c.calibration_step(p.loop, p.settings, p.state, p.io, p.calibration) == c.PHASE_IDLE
    assert (p.calibration.reason, p.calibration.reason_value) == (f.FAULT_CAL_SUM, 456)


def test_a_joint_encoder_that_does_not_follow_is_refused():
    class Stuck(Plant):
        def read_slow(self):
            super().read_slow()
            self.io.joint_raw = 77

    p = Stuck()
    for _ in range(5):
        p.tick(setpoint=False)
    begin_calibration(p.state, p.calibration, c.CAL_SMALL)
    drive_arm(p.settings, p.state, p.io, w.MODE_CALIBRATING)
    for _ in range(4000):
        p.tick(setpoint=False)
    assert p.state.fault_code == f.FAULT_CAL_JOINT_ENCODER


def test_a_wide_spread_is_refused():
    p = Plant()
    p.calibration.kind, p.calibration.phase, p.calibration.offset_count, p.calibration.offset_high = (
        c.CAL_SMALL,
        c.PHASE_RETURN,
        9,
        20000,
    )
    p.calibration.rotor_last, p.calibration.pole_pairs, p.calibration.direction = p.rotor(), 7, 1
    assert c.calibration_step(p.loop, p.settings, p.state, p.io, p.calibration) == c.PHASE_IDLE
    assert p.calibration.reason == f.FAULT_CAL_SPREAD


def test_disarming_in_the_middle_restores_the_commutation():
    p = calibrate(c.CAL_SMALL, ticks=1500)
    assert p.loop.electrical_gain == 0
    before = pack(p.settings)
    drive_disarm(p.state)
    p.tick(setpoint=False)
    assert p.state.drive_state == w.STATE_SWITCH_ON_DISABLED
    assert (p.loop.electrical_gain, p.loop.reference_d, p.calibration.phase) == (28, 0, c.PHASE_IDLE)
    assert pack(p.settings) == before
