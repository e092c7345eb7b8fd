"""States, arming, watchdog and faults: by example, and with random frames, resets and sensor faults."""

import random

import pytest

from shared.joint import faults
from shared.joint import layout as j
from shared.joint.commission_state import COMMISSION_FULL, COMMISSION_VERIFY, Commission
from shared.joint.current import current_repair, current_step
from shared.joint.drive_state import drive_arm, drive_clear, drive_disarm, drive_quick_stop
from shared.joint.encoder import home_at
from shared.joint.thermal import slow_tick
from shared.joint.tick import begin_commission, joint_reset, motion_tick
from shared.record import pack
from shared.wire import names as w

from .plant import made


class Joint:
    """The blocks of a joint at rest with healthy sensors; the bridge is nowhere."""

    def __init__(self, commissioned=True):
        blocks = made(has_joint_encoder=False)
        self.loop, self.settings, self.state, self.io = blocks.loop, blocks.settings, blocks.state, blocks.io
        self.commission, self.curve = Commission(), blocks.curve
        self.settings.commissioned = int(commissioned)
        joint_reset(self.loop, self.settings, self.state, 100)
        self.healthy()
        slow_tick(self.settings, self.state, self.io, self.curve)

    def healthy(self):
        b = self.io
        b.hash_ok = b.session = b.hardware_ready = 1
        b.e_stop = b.hardware_fault = 0
        b.bus_raw, b.thermistor_raw, b.mcu_raw = 2291, 2048, 980
        for k in range(3):
            self.loop.raw[k] = 2048

    def tick(self, count=1):
        for _ in range(count):
            motion_tick(self.loop, self.settings, self.state, self.io, self.commission)
        return self.state.drive_state

    def setpoint(self, mode=w.MODE_POSITION, position=0):
        self.io.mode, self.io.position = mode, position
        self.io.sequence = (self.io.sequence + 1) & 0xFFFF

    def arm(self, purpose=w.MODE_OFF):
        return drive_arm(self.settings, self.state, self.io, purpose)

    def ready(self):
        self.tick(2)
        home_at(self.settings, self.state, 100)
        self.setpoint()
        self.tick()
        return self

    def run(self):
        self.ready()
        assert self.arm() == w.RESULT_OK
        assert self.tick(4) == w.STATE_OPERATION_ENABLED
        return self


def test_arming_climbs_one_state_a_tick():
    joint = Joint()
    assert joint.state.drive_state == w.STATE_NOT_READY
    assert joint.tick(2) == w.STATE_SWITCH_ON_DISABLED
    joint.ready()
    assert joint.arm() == w.RESULT_OK
    seen = [joint.tick() for _ in range(4)]
    assert seen == [w.STATE_READY, w.STATE_SWITCHED_ON, w.STATE_OPERATION_ENABLED, w.STATE_OPERATION_ENABLED]
    assert joint.state.torque == j.TORQUE_DRIVE


@pytest.mark.parametrize(
    ("place", "value", "result"),
    [
        ("hash_ok", 0, w.RESULT_WRONG_HASH),
        ("session", 0, w.RESULT_NO_SESSION),
        ("mode", w.MODE_HOMING, w.RESULT_NO_SETPOINT),
        ("position", 3000, w.RESULT_FAR_FROM_SETPOINT),
        ("position", -3000, w.RESULT_FAR_FROM_SETPOINT),
    ],
)
def test_arming_is_refused_with_a_reason(place, value, result):
    joint = Joint().ready()
    setattr(joint.io, place, value)
    assert joint.arm() == result
    assert joint.tick(4) == w.STATE_SWITCH_ON_DISABLED


def test_arming_needs_commission_homing_and_a_fresh_set_point():
    joint = Joint(commissioned=False)
    assert joint.arm() == w.RESULT_WRONG_STATE
    joint.tick(2)
    assert joint.arm() == w.RESULT_NOT_COMMISSIONED
    joint.settings.commissioned = 1
    assert joint.arm() == w.RESULT_NOT_HOMED
    home_at(joint.settings, joint.state, 100)
    assert joint.arm() == w.RESULT_NO_SETPOINT
    joint.setpoint()
    joint.tick(60)
    assert joint.arm() == w.RESULT_NO_SETPOINT
    joint.setpoint()
    joint.tick()
    assert joint.arm() == w.RESULT_OK


def test_the_watchdog_damps_then_coasts_and_latches():
    joint = Joint().run()
    before = pack(joint.io)
    states = [joint.tick() for _ in range(800)]
    first = states.index(w.STATE_FAULT_REACTION)
    assert first <= 101
    assert states[first : first + 500] == [w.STATE_FAULT_REACTION] * 500
    assert states[first + 501 :] == [w.STATE_FAULT] * (800 - first - 501)
    s = joint.state
    assert (s.fault_code, s.fault_value) == (faults.FAULT_WATCHDOG, 101)
    assert pack(joint.io) == before
    assert joint.arm() == w.RESULT_FAULT_PRESENT
    assert drive_clear(s) == w.RESULT_OK
    assert joint.tick() == w.STATE_SWITCH_ON_DISABLED
    assert joint.arm() == w.RESULT_NO_SETPOINT


def test_only_set_points_feed_the_watchdog():
    joint = Joint().run()
    for _ in range(300):
        joint.io.session += 1  # other traffic
        joint.io.position = joint.state.time_ms & 7
        joint.tick()
    assert joint.state.fault_code == faults.FAULT_WATCHDOG
    joint = Joint().run()
    for _ in range(300):
        joint.setpoint()
        joint.tick()
    assert joint.state.drive_state == w.STATE_OPERATION_ENABLED


@pytest.mark.parametrize("state", range(8))
def test_emergency_stop_from_every_state(state):
    joint = Joint().run()
    joint.state.drive_state = state
    joint.io.e_stop = 1
    assert joint.tick() == w.STATE_FAULT
    assert joint.state.torque == j.TORQUE_OFF
    assert drive_clear(joint.state) == w.RESULT_FAULT_PRESENT
    joint.io.e_stop = 0
    joint.setpoint()
    joint.tick()
    assert joint.state.drive_state == w.STATE_FAULT
    assert drive_clear(joint.state) == w.RESULT_OK
    joint.setpoint()
    assert joint.tick(3) == w.STATE_SWITCH_ON_DISABLED


def test_quick_stop_damps_until_the_joint_stands():
    joint = Joint().run()
    joint.state.velocity = joint.state.rate = 60000
    assert drive_quick_stop(joint.state) == w.RESULT_OK
    joint.loop.rotor = 340
    assert joint.tick() == w.STATE_QUICK_STOP_ACTIVE
    assert joint.state.torque == j.TORQUE_DAMP
    assert joint.state.current_reference < 0
    assert joint.tick(60) == w.STATE_SWITCH_ON_DISABLED
    assert drive_quick_stop(joint.state) == w.RESULT_WRONG_STATE


def test_disarming_ends_the_torque_in_the_next_tick():
    joint = Joint().run()
    assert drive_disarm(joint.state) == w.RESULT_OK
    assert joint.tick() == w.STATE_SWITCH_ON_DISABLED
    assert (joint.state.torque, joint.loop.reference_q) == (j.TORQUE_OFF, 0)


def test_the_first_cause_stays():
    joint = Joint().run()
    joint.io.hardware_fault, joint.io.hardware_value = faults.FAULT_DRIVER, 0x421
    joint.tick()
    tick = joint.state.time_ms
    joint.io.hardware_fault = 0
    joint.io.bus_raw = 0
    joint.tick(50)
    s = joint.state
    latched = s.fault_code, s.fault_value, s.fault_tick
    assert latched == (faults.FAULT_DRIVER, 0x421, tick)
    assert drive_clear(s) == w.RESULT_FAULT_PRESENT  # the bus is still missing
    joint.healthy()
    joint.tick()
    assert drive_clear(s) == w.RESULT_OK


def test_before_the_hardware_is_ready_only_an_emergency_stop_latches():
    joint = Joint()
    joint.io.hardware_ready = joint.io.bus_raw = 0
    assert joint.tick(50) == w.STATE_NOT_READY
    assert joint.state.fault_code == 0
    joint.io.e_stop = 1
    assert joint.tick() == w.STATE_FAULT


def test_losing_the_hardware_ends_operation():
    joint = Joint().run()
    joint.io.hardware_ready = 0
    assert joint.tick() == w.STATE_FAULT
    assert joint.state.fault_code == faults.FAULT_DRIVER_SETUP


@pytest.mark.parametrize(("code", "expected"), [(0, 0), (1, 1), (11, 1), (31, 1), (32, 0), (33, 0), (78, 0), (-5, 0)])
def test_which_faults_damp_first(code, expected):
    assert faults.damps_first(code) == expected


SENSOR_FAULTS = (
    ("bus_raw", 0), ("bus_raw", 4095), ("thermistor_raw", 4095), ("thermistor_raw", 0),
    ("mcu_raw", 4095), ("mcu_raw", 0), ("hardware_fault", 39), ("hardware_fault", 9),
    ("hardware_ready", 0), ("e_stop", 1), ("hash_ok", 0), ("session", 0), ("session", 7),
)  # fmt: skip


def disturb(joint, rng):
    """One random frame, reset, request or sensor fault."""
    choice = rng.randrange(17)
    if choice < 5:
        joint.setpoint(rng.choice((1, 2, 3, 4, rng.randint(0, 7))), rng.choice((0, 1, rng.randint(-32768, 32767))))
        joint.io.velocity, joint.io.current = rng.randint(-32768, 32767), rng.randint(-32768, 32767)
        joint.io.stiffness, joint.io.damping = rng.randint(0, 32767), rng.randint(0, 32767)
    elif choice < 8:
        drive_arm(joint.settings, joint.state, joint.io, rng.choice((0, 0, 0, w.MODE_HOMING, w.MODE_COMMISSIONING)))
    elif choice == 8:
        rng.choice((drive_disarm, drive_quick_stop))(joint.state)
    elif choice < 11:
        joint.healthy()
        drive_clear(joint.state)
    elif choice == 11:
        place, value = rng.choice(SENSOR_FAULTS)
        setattr(joint.io, place, value)
    elif choice == 12:
        joint.loop.raw[rng.randrange(3)] = rng.randint(0, 4095)
    elif choice == 13:
        home_at(joint.settings, joint.state, joint.state.position + rng.choice((0, 0, 6000)))
    elif choice == 14:
        begin_commission(joint.state, joint.commission, rng.choice((COMMISSION_FULL, COMMISSION_VERIFY)))
    elif choice == 15 and rng.random() < 0.2:
        joint_reset(joint.loop, joint.settings, joint.state, rng.randrange(16384))
    else:
        slow_tick(joint.settings, joint.state, joint.io, joint.curve)


def check(joint, fault_before, drive_before):
    s, loop = joint.state, joint.loop
    drive, torque = s.drive_state, s.torque
    if torque == j.TORQUE_DRIVE:
        assert drive == w.STATE_OPERATION_ENABLED
    elif torque == j.TORQUE_DAMP:
        assert drive in (w.STATE_QUICK_STOP_ACTIVE, w.STATE_FAULT_REACTION)
        assert s.current_reference * s.velocity <= 0
        assert abs(s.current_reference) <= joint.settings.damp_current
    else:
        assert (loop.reference_q, loop.reference_d) == (0, 0)
    assert abs(loop.reference_q) <= joint.settings.current_max
    assert 0 <= loop.reference_d <= joint.settings.commission_current
    if joint.io.e_stop:
        assert drive == w.STATE_FAULT
    if drive_before == w.STATE_FAULT and drive == w.STATE_FAULT:
        assert s.fault_code == fault_before
    assert (s.fault_code != 0) == (drive in (w.STATE_FAULT, w.STATE_FAULT_REACTION))


@pytest.mark.parametrize("seed", range(5))
def test_random_frames_resets_and_sensor_faults_never_give_torque_where_there_must_be_none(seed):
    """2000 disturbances a seed, 10 000 together; each tick with current steps at a rotor that wanders."""
    rng = random.Random(seed)
    joint, rotor, seen = Joint(), 100.0, set()
    for _ in range(2000):
        disturb(joint, rng)
        for _ in range(rng.choice((1, 1, 2, 5, 40))):
            rotor += rng.uniform(-30, 30) * rng.choice((0, 1, 10))
            reading = int(rotor) & 16383 if rng.random() > 0.03 else rng.randrange(16384)
            code = current_step(reading, 0, joint.loop)
            if code:
                current_repair(code, reading, 0, joint.loop)
            fault, drive = joint.state.fault_code, joint.state.drive_state
            told = pack(joint.io)
            joint.tick()
            assert pack(joint.io) == told
            check(joint, fault, drive)
            seen.add(joint.state.drive_state)
    assert seen >= {1, 2, 3, 4, 5, 6, 7}


@pytest.mark.parametrize("code", [faults.FAULT_DRIVER_SETUP, faults.FAULT_CURRENT_SENSE, faults.FAULT_STORAGE])
def test_what_is_wrong_with_the_hardware_latches_before_it_is_ready(code):
    joint = Joint()
    joint.io.hardware_ready = 0
    joint.io.bus_raw = 0  # the supply still rises
    joint.io.hardware_fault, joint.io.hardware_value = code, 7
    assert joint.tick(50) == w.STATE_FAULT
    assert (joint.state.fault_code, joint.state.fault_value, joint.state.fault_tick) == (code, 7, 1)
    joint.healthy()
    joint.io.hardware_ready = 0
    joint.tick()
    assert drive_clear(joint.state) == w.RESULT_OK
    assert joint.tick(2) == w.STATE_NOT_READY
    assert joint.state.fault_code == faults.FAULT_NONE


def test_a_supply_that_still_rises_is_no_fault_nor_is_the_gate_driver_without_it():
    joint = Joint()
    joint.io.hardware_ready = 0
    joint.io.bus_raw, joint.io.hardware_fault = 0, faults.FAULT_DRIVER
    assert joint.tick(50) == w.STATE_NOT_READY
    joint.healthy()
    assert joint.tick(2) == w.STATE_SWITCH_ON_DISABLED
