"""A joint of a robot file with a motor that is none: enough to bring the blocks into every state there is."""

from shared.joint.commission_state import Commission
from shared.joint.commutation import fill_sine
from shared.joint.current import current_repair, current_step
from shared.joint.drive_state import drive_arm, drive_clear
from shared.joint.layout import SINE_SIZE, CurrentLoop, JointIo, JointSettings, JointState
from shared.joint.probe import probe_step
from shared.joint.thermal import slow_tick
from shared.joint.tick import begin_commission, joint_reset, motion_tick
from shared.record import copy
from shared.wire.names import MODE_COMMISSIONING, MODE_HOMING, MODE_OFF, STATE_FAULT, STATE_SWITCH_ON_DISABLED

from .draw import INT16
from .probe import Head, Pick
from .robots import JOINTS

LOOP = CurrentLoop()
FIELDS = Head(LOOP, SINE_SIZE)  # without the sine table, which nothing changes
SETTINGS = JointSettings()
STATE = JointState()
IO = JointIo()
COMMISSION = Commission()
FRESH = ((JointState(), STATE), (JointIo(), IO), (Commission(), COMMISSION))
CURVE = JOINTS[0][2]
SIGN = Pick(-1, 1)

_PURPOSES = (MODE_OFF,) * 14 + (MODE_HOMING, MODE_COMMISSIONING)  # the last two take long


fill_sine(LOOP)


class Motion:
    """Where the pretended rotor is and how fast it turns, rc and rc a step."""

    def __init__(self):
        self.rotor = 0
        self.speed = 0
        self.quiet = 0  # ticks without a fault from outside


MOTION = Motion()


def begin():
    """Start with the first joint."""
    settings(0)


def settings(which):
    """Load a joint's blocks: commissioned, hardware ready, a host there."""
    loop, settings, _ = JOINTS[which]
    copy(loop, LOOP)
    copy(settings, SETTINGS)
    for fresh, block in FRESH:
        copy(fresh, block)
    SETTINGS.commissioned = 1
    MOTION.rotor = MOTION.speed = 0
    MOTION.quiet = 60
    calm_inputs()
    joint_reset(LOOP, SETTINGS, STATE, 0)
    slow_tick(SETTINGS, STATE, IO, CURVE)


def calm_inputs():
    """Sensors and host as they should be."""
    IO.hash_ok = IO.session = IO.hardware_ready = IO.joint_valid = 1
    IO.e_stop = IO.hardware_fault = 0
    IO.bus_raw = (SETTINGS.under_start + SETTINGS.over_start) * 2048 // SETTINGS.bus_gain
    IO.thermistor_raw = 2048
    IO.mcu_raw = 980


def live(values, dice):
    """Three milliseconds of life; what is probed then acts on the state it leads to."""
    if dice.below(90) == 0:
        settings(dice.below(len(JOINTS)))
    for _ in range(3):
        wish(dice)
        trouble(dice)
        one_millisecond(dice)


def wish(dice):
    """What a host does: set-points most of the time, arming, clearing, other modes now and then."""
    if dice.below(8):
        IO.sequence = (IO.sequence + 1) & 0xFFFF
    if dice.below(12) == 0:
        IO.position = INT16.any(dice)
        IO.velocity = INT16.any(dice)
        IO.current = INT16.any(dice)
        IO.position >>= dice.below(12)
        IO.stiffness = dice.bits(15)
        IO.damping = dice.bits(15)
    if dice.below(40) == 0:
        IO.mode = dice.below(6)
    if STATE.drive_state == STATE_FAULT:
        drive_clear(STATE)
    elif STATE.drive_state == STATE_SWITCH_ON_DISABLED:
        STATE.homed = 1
        purpose = dice.choose(_PURPOSES)
        if drive_arm(SETTINGS, STATE, IO, purpose) == 0 and purpose == MODE_COMMISSIONING:
            begin_commission(STATE, COMMISSION, 1 + dice.below(2))


def trouble(dice):
    """Something fails for a while, rarely; in between all is well long enough to be armed."""
    if MOTION.quiet > 0:
        MOTION.quiet -= 1
        if MOTION.quiet == 0:
            where = dice.below(5)
            something_fails(where, (1, 40, dice.bits(12), dice.bits(12), dice.bits(12))[dice.below(5)])
        return
    if dice.below(12) == 0:
        calm_inputs()
        MOTION.quiet = 40 + dice.bits(6 + dice.below(3))


def something_fails(where, value):
    """One of the inputs says what it should not."""
    if where == 0:
        IO.e_stop = value
    elif where == 1:
        IO.hardware_fault = value
    elif where == 2:
        IO.bus_raw = value
    elif where == 3:
        IO.thermistor_raw = value
    else:
        IO.mcu_raw = value


def one_millisecond(dice):
    """Two current steps with currents about as wanted, then the motion tick; the slow one now and then."""
    push = LOOP.voltage_q >> 7
    MOTION.speed += push + dice.bits(3) - 4 - (MOTION.speed >> 4)
    MOTION.speed = max(-400, min(400, MOTION.speed))
    for _ in range(2):
        MOTION.rotor = (MOTION.rotor + MOTION.speed) & 16383
        read_currents(dice)
        invalid = 1 if dice.below(500) == 0 else 0
        code = current_step(MOTION.rotor, invalid, LOOP)
        if code:
            current_repair(code, MOTION.rotor, invalid, LOOP)
        if LOOP.probing:
            probe_step(LOOP)
    along = STATE.position % (SETTINGS.gear_q8 << 6) * 256 // SETTINGS.gear_q8 * SETTINGS.joint_encoder_sign
    IO.joint_raw = (SETTINGS.joint_encoder_zero + along + dice.bits(1)) & 16383  # else it could not drive for long
    motion_tick(LOOP, SETTINGS, STATE, IO, COMMISSION)
    if dice.below(50) == 0:
        slow_tick(SETTINGS, STATE, IO, CURVE)


def read_currents(dice):
    """Phase readings whose sum is about 0, up to full scale if something is wrong."""
    span = 11 if MOTION.quiet == 0 and dice.below(4) == 0 else 6
    half = 1 << (span - 1)
    a = dice.bits(span) - half
    b = dice.bits(span) - half
    LOOP.raw[0] = 2048 + a
    LOOP.raw[1] = 2048 + b
    LOOP.raw[2] = max(0, min(4095, 2048 - a - b))
