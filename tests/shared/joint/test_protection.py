"""Every protection: what triggers it, how fast, with which code and value, and that healthy operation does not."""

import pytest

from shared.joint import faults as f
from shared.joint import layout as j
from shared.joint.current import current_repair, current_step
from shared.joint.drive_state import drive_arm, drive_clear
from shared.joint.encoder import encoder_reset, home_at
from shared.joint.homing import HOME_AMBIGUOUS, HOME_DONE, HOME_IDLE, HOME_SEEKING
from shared.joint.protection import count_above
from shared.joint.thermal import slow_tick
from shared.joint.tick import begin_commission
from shared.wire import names as w

from .plant import Plant
from .test_cascade import armed
from .test_drive_state import Joint


def until_fault(joint, ticks):
    for tick in range(1, ticks + 1):
        joint.setpoint(position=18)
        joint.tick()
        if joint.state.fault_code:
            return tick
    return None


def test_healthy_operation_has_no_fault_and_no_limit():
    joint = Joint().run()
    assert until_fault(joint, 500) is None
    assert joint.state.limits == 0


def disagree(joint):
    joint.settings.has_joint_encoder = joint.io.joint_valid = 1
    joint.io.joint_raw = 8192


CASES = {
    "under-voltage": (lambda x: setattr(x.io, "bus_raw", 1700), f.FAULT_UNDER_VOLTAGE, 5, 4558),
    "over-voltage": (lambda x: setattr(x.io, "bus_raw", 2900), f.FAULT_OVER_VOLTAGE, 5, 7775),
    "trip": (lambda x: setattr(x.loop, "tripped", 1), f.FAULT_OVER_CURRENT, 1, 0),
    "current sum": (lambda x: x.loop.raw.__setitem__(0, 2148), f.FAULT_CURRENT_SENSE, 10, 100),
    "disagreement": (disagree, f.FAULT_ENCODER_DISAGREE, 5, None),
    "over-speed": (lambda x: setattr(x.settings, "rate_trip", -1), f.FAULT_OVER_SPEED, 1, 0),
    "raised": (lambda x: setattr(x.state, "raised", f.FAULT_HOME_NO_STOP), f.FAULT_HOME_NO_STOP, 1, 0),
    "range": (lambda x: setattr(x.state, "range_exceeded", 1), f.FAULT_POSITION_RANGE, 1, 0),
}


@pytest.mark.parametrize("name", CASES)
def test_a_fault_is_found_in_its_time_with_its_value(name):
    disturb, code, ticks, value = CASES[name]
    joint = Joint().run()
    disturb(joint)
    assert until_fault(joint, 100) == ticks
    assert joint.state.fault_code == code
    assert value is None or joint.state.fault_value == value
    assert joint.state.torque != j.TORQUE_DRIVE


@pytest.mark.parametrize(("every", "fault"), [(1, True), (9, False)])
def test_a_lost_encoder_is_a_fault_and_single_glitches_are_not(every, fault):
    joint = Joint().run()
    for tick in range(60):
        joint.loop.glitches = 8 if tick % every == 0 else 1
        joint.setpoint()
        joint.tick()
    assert (joint.state.fault_code == f.FAULT_ENCODER_LOST) == fault


def test_after_a_lost_encoder_the_joint_follows_it_again_but_must_be_homed():
    joint = Joint().run()
    lost = [12000] * 10
    for _ in range(6):
        for reading in lost:
            current_repair(current_step(reading, 0, joint.loop), reading, 0, joint.loop)
        joint.tick()
    assert joint.state.fault_code == f.FAULT_ENCODER_LOST
    assert (joint.state.homed, joint.loop.rotor) == (0, 12000)
    for _ in range(4):
        assert [current_step(12000, 0, joint.loop) for _ in range(10)] == [0] * 10
        joint.tick()
    assert drive_clear(joint.state) == w.RESULT_OK
    assert joint.tick() == w.STATE_SWITCH_ON_DISABLED
    joint.setpoint()
    joint.tick()
    assert joint.arm() == w.RESULT_NOT_HOMED


def test_beyond_the_position_limit_is_a_fault_only_on_the_way_out():
    joint = Joint().run()
    top = joint.settings.position_max + joint.settings.position_margin
    home_at(joint.settings, joint.state, top + 16384)
    joint.state.rate = -50000
    joint.loop.rotor = 16300
    joint.tick()
    assert joint.state.fault_code == 0
    joint.state.rate = 50000
    joint.loop.rotor = 200
    joint.tick()
    assert joint.state.fault_code == f.FAULT_POSITION_LIMIT


def test_stall_is_a_fault_after_its_time_and_holding_a_load_is_not():
    p = armed()
    p.blocked = True
    p.io.position += 3000
    ticks = 0
    while not p.state.fault_code and ticks < 3000:
        p.tick()
        ticks += 1
    assert p.state.fault_code == f.FAULT_STALL
    assert 1000 <= ticks < 1200
    assert abs(p.state.fault_value) == p.settings.current_max
    p = armed()
    p.load_Nm = 0.12  # 1.75 A
    p.run(1500)
    assert p.state.fault_code == 0
    assert abs(p.current_A()) > 1.6


def test_swapped_phases_do_not_run_away():
    """Phases exchanged after commission: the joint cannot move as asked, stalls, and stops with a fault."""
    p = armed()
    p.swapped = True
    p.io.position += 5000
    start, ticks = p.joint_rad(), 0
    while not p.state.fault_code and ticks < 3000:
        p.tick()
        ticks += 1
    assert p.state.fault_code in (f.FAULT_STALL, f.FAULT_OVER_CURRENT)
    assert abs(p.joint_rad() - start) < 0.1


@pytest.mark.parametrize(
    ("place", "raw", "code"),
    [
        ("thermistor_raw", 4095, f.FAULT_THERMISTOR_OPEN),
        ("thermistor_raw", 0, f.FAULT_THERMISTOR_SHORT),
        ("thermistor_raw", 280, f.FAULT_WINDING_HOT),
        ("mcu_raw", 1190, f.FAULT_MCU_HOT),
        ("mcu_raw", 0, f.FAULT_MCU_SENSOR),
        ("mcu_raw", 4095, f.FAULT_MCU_SENSOR),
    ],
)
def test_temperature_faults(place, raw, code):
    joint = Joint().run()
    setattr(joint.io, place, raw)
    slow_tick(joint.settings, joint.state, joint.io, joint.curve)
    assert until_fault(joint, 2) == 1
    assert joint.state.fault_code == code
    assert joint.state.drive_state == w.STATE_FAULT_REACTION


@pytest.mark.parametrize(
    ("place", "raw", "flag"),
    [("thermistor_raw", 560, w.LIMIT_WINDING_TEMPERATURE), ("mcu_raw", 1110, w.LIMIT_MCU_TEMPERATURE)],
)
def test_heat_takes_the_current_back_linearly(place, raw, flag):
    joint = Joint().run()
    setattr(joint.io, place, raw)
    share = slow_tick(joint.settings, joint.state, joint.io, joint.curve)
    joint.tick()
    assert 0 < share < 0x8000
    assert joint.state.current_limit == joint.settings.current_max * share >> 15
    assert joint.state.limits & flag
    if place == "thermistor_raw":
        span = joint.settings.winding_cut - joint.settings.winding_derate
        expected = (joint.settings.winding_cut - joint.state.winding) / span
        assert share / 32768 == pytest.approx(expected, abs=1e-3)


def test_a_limited_voltage_is_told_in_its_tick():
    joint = Joint().run()
    joint.loop.limited_steps = 3
    joint.tick()
    assert joint.state.limits & w.LIMIT_VOLTAGE
    joint.tick()
    assert not joint.state.limits & w.LIMIT_VOLTAGE


def test_an_open_thermistor_is_never_cold():
    joint = Joint()
    joint.io.thermistor_raw = 4095
    slow_tick(joint.settings, joint.state, joint.io, joint.curve)
    assert joint.state.winding >= 0
    assert joint.state.slow_cause == f.FAULT_THERMISTOR_OPEN


def test_the_model_derates_when_the_sensor_lags():
    """Three ampere for minutes at a sensor that stays cold: the model's winding counts."""
    joint = Joint()
    s, cold = joint.state, joint.state.winding
    shares = []
    for _ in range(4000):
        s.heat_sum, s.heat_ticks = 78000 * 2, 2
        shares.append(slow_tick(joint.settings, s, joint.io, joint.curve))
    assert s.winding > max(cold, joint.settings.winding_derate)
    assert shares[0] == 0x8000
    assert shares == sorted(shares, reverse=True)
    assert 0 < shares[-1] < 0x8000


@pytest.mark.parametrize(("ticks", "value", "expected"), [(3, 8, 4), (3, 7, 0), (65535, 8, 65535)])
def test_count_above(ticks, value, expected):
    assert count_above(ticks, value, 7) == expected


def homing(stop_at, start_rad=0.0):
    """A thigh without a joint encoder, its stop at -0.5 rad, is sent against one at ``stop_at`` rad."""
    p = Plant(elec_offset_brad=3000, has_joint_encoder=False, stop_rad=-0.5, stop_towards=-1)
    p.angle = start_rad * 22
    p.loop.rotor = p.rotor()
    encoder_reset(p.loop, p.settings, p.state)
    p.run(3)
    assert drive_arm(p.settings, p.state, p.io, w.MODE_OFF) == w.RESULT_NOT_HOMED
    assert drive_arm(p.settings, p.state, p.io, w.MODE_HOMING) == w.RESULT_OK
    for _ in range(20000):
        p.tick(setpoint=False)
        if p.joint_rad() <= stop_at:
            p.angle, p.speed = stop_at * 22, max(p.speed, 0.0)
        if p.state.home_result not in (HOME_IDLE, HOME_SEEKING):
            break
    p.tick(setpoint=False)
    return p


@pytest.mark.parametrize("start", [0.0, 0.7])
def test_homing_against_the_stop(start):
    p = homing(-0.5, start)
    assert p.state.home_result == HOME_DONE
    assert p.state.homed == 1
    assert p.state.position * p.units.rad_per_rc == pytest.approx(p.joint_rad(), abs=1e-3)
    assert p.state.drive_state == w.STATE_SWITCH_ON_DISABLED


def test_homing_refuses_a_stop_that_is_not_where_it_should_be():
    p = homing(-0.40)  # 5.7 deg off: the nearest turn is not sure any more
    assert p.state.home_result == HOME_AMBIGUOUS
    assert (p.state.homed, p.state.fault_code) == (0, f.FAULT_HOME_AMBIGUOUS)


def test_homing_gives_up_without_a_stop():
    p = Plant(has_joint_encoder=False)
    p.settings.home_limit_ticks = 300
    p.run(3)
    drive_arm(p.settings, p.state, p.io, w.MODE_HOMING)
    p.run(400)
    assert p.state.fault_code == f.FAULT_HOME_NO_STOP


def test_commission_runs_one_at_a_time():
    joint = Joint()
    assert begin_commission(joint.state, joint.commission, 2) == 2
    joint.state.mode = w.MODE_COMMISSIONING
    assert begin_commission(joint.state, joint.commission, 1) == 0
