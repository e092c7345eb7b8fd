"""A joint of a robot file with a motor that is none: enough to bring the blocks into every state there is."""


from shared.joint import layout as j
from shared.joint.calibration import CAL_SIZE
from shared.joint.current import current_repair, current_step
from shared.joint.drive_state import drive_arm, drive_clear
from shared.joint.sine import fill_sine
from shared.joint.tick import begin_calibration, joint_reset, motion_tick, slow_tick
from shared.runtime import zeros
from shared.wire.names import MODE_CALIBRATING, MODE_HOMING, MODE_OFF, STATE_FAULT, STATE_SWITCH_ON_DISABLED

from .draw import Range
from .probe import Head, Pick
from .robots import JOINTS

FOC = zeros(j.FOC_SIZE)
FIELDS = Head(FOC, j.F_SINE)  # without the sine table, which nothing changes
CFG = zeros(j.CFG_SIZE)
STATE = zeros(j.STATE_SIZE)
IO = zeros(j.IO_SIZE)
CAL = zeros(CAL_SIZE)
CURVE = JOINTS[0][2]
SIGN = Pick(-1, 1)

_WORD = Range(-32768, 32767)
_PURPOSES = (MODE_OFF, MODE_OFF, MODE_OFF, MODE_OFF, MODE_HOMING, MODE_CALIBRATING)


fill_sine(FOC)


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
    """Load a joint's blocks: calibrated, hardware ready, a host there."""
    foc, cfg, _ = JOINTS[which]
    for at in range(j.F_SINE):
        FOC[at] = foc[at]
    for at in range(j.CFG_SIZE):
        CFG[at] = cfg[at]
    for block in (STATE, IO, CAL):
        for at in range(len(block)):
            block[at] = 0
    CFG[j.K_CALIBRATED] = 1
    MOTION.rotor = MOTION.speed = 0
    MOTION.quiet = 60
    calm_inputs()
    joint_reset(FOC, CFG, STATE, 0)
    slow_tick(CFG, STATE, IO, CURVE)


def calm_inputs():
    """Sensors and host as they should be."""
    IO[j.IO_HASH_OK] = IO[j.IO_SESSION] = IO[j.IO_HARDWARE_READY] = IO[j.IO_JOINT_VALID] = 1
    IO[j.IO_E_STOP] = IO[j.IO_HARDWARE_FAULT] = 0
    IO[j.IO_BUS_RAW] = (CFG[j.K_UNDER_START] + CFG[j.K_OVER_START]) * 2048 // CFG[j.K_BUS_GAIN]
    IO[j.IO_THERMISTOR_RAW] = 2048
    IO[j.IO_MCU_RAW] = 980


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
        IO[j.IO_SEQUENCE] = (IO[j.IO_SEQUENCE] + 1) & 0xFFFF
    if dice.below(12) == 0:
        for at in range(j.IO_POSITION, j.IO_STIFFNESS):
            IO[at] = _WORD.any(dice)
        IO[j.IO_POSITION] >>= dice.below(12)
        IO[j.IO_STIFFNESS] = dice.bits(15)
        IO[j.IO_DAMPING] = dice.bits(15)
    if dice.below(40) == 0:
        IO[j.IO_MODE] = dice.below(6)
    if STATE[j.S_DRIVE] == STATE_FAULT:
        drive_clear(STATE)
    elif STATE[j.S_DRIVE] == STATE_SWITCH_ON_DISABLED:
        STATE[j.S_HOMED] = 1
        purpose = _PURPOSES[dice.below(len(_PURPOSES))]
        if drive_arm(CFG, STATE, IO, purpose) == 0 and purpose == MODE_CALIBRATING:
            begin_calibration(STATE, CAL, 1 + dice.below(3))


def trouble(dice):
    """Something fails for a while, rarely; in between all is well long enough to be armed."""
    if MOTION.quiet > 0:
        MOTION.quiet -= 1
        if MOTION.quiet == 0:
            at = (j.IO_E_STOP, j.IO_HARDWARE_FAULT, j.IO_BUS_RAW, j.IO_THERMISTOR_RAW, j.IO_MCU_RAW)[dice.below(5)]
            IO[at] = (1, 40, dice.bits(12), dice.bits(12), dice.bits(12))[dice.below(5)]
        return
    if dice.below(12) == 0:
        calm_inputs()
        MOTION.quiet = 40 + dice.bits(6 + dice.below(3))


def one_millisecond(dice):
    """Two current steps with currents about as wanted, then the motion tick; the slow one now and then."""
    push = FOC[j.F_V_Q] >> 7
    MOTION.speed += push + dice.bits(3) - 4 - (MOTION.speed >> 4)
    MOTION.speed = max(-400, min(400, MOTION.speed))
    for _ in range(2):
        MOTION.rotor = (MOTION.rotor + MOTION.speed) & 16383
        read_currents(dice)
        invalid = 1 if dice.below(500) == 0 else 0
        code = current_step(MOTION.rotor, invalid, FOC)
        if code:
            current_repair(code, MOTION.rotor, invalid, FOC)
    IO[j.IO_JOINT_RAW] = (MOTION.rotor * 256 // CFG[j.K_GEAR_Q8] + dice.bits(1)) & 16383
    motion_tick(FOC, CFG, STATE, IO, CAL)
    if dice.below(50) == 0:
        slow_tick(CFG, STATE, IO, CURVE)


def read_currents(dice):
    """Phase readings whose sum is about 0, up to full scale if something is wrong."""
    span = 11 if MOTION.quiet == 0 and dice.below(4) == 0 else 6
    half = 1 << (span - 1)
    a = dice.bits(span) - half
    b = dice.bits(span) - half
    FOC[j.F_RAW_A] = 2048 + a
    FOC[j.F_RAW_B] = 2048 + b
    FOC[j.F_RAW_C] = max(0, min(4095, 2048 - a - b))
