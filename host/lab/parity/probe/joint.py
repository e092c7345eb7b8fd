"""shared/joint: the functions that work on a joint's blocks, in states that a life of the joint leads to."""

from shared.joint import (
    calibration,
    cascade,
    current,
    drive_state,
    encoder,
    feed,
    homing,
    protection,
    report,
    sine,
    svpwm,
    thermal,
    tick,
)
from shared.joint.layout import LoopSettings

from .draw import Range
from .joint_robot import (
    CALIBRATION,
    CURVE,
    FIELDS,
    IO,
    LOOP,
    MOTION,
    SETTINGS,
    STATE,
    begin,
    live,
    one_millisecond,
    read_currents,
    trouble,
    wish,
)
from .probe import Probe

SOURCES = (
    "joint.calibration",
    "joint.cascade",
    "joint.current",
    "joint.drive_state",
    "joint.encoder",
    "joint.feed",
    "joint.homing",
    "joint.protection",
    "joint.report",
    "joint.sine",
    "joint.svpwm",
    "joint.thermal",
    "joint.tick",
)

LOOP_SETTINGS = LoopSettings()
BLOCKS = (LOOP, SETTINGS, STATE, IO, CALIBRATION)
ROTOR = Range(0, 16383)
CURRENT = Range(-12288, 12288)
RATE = Range(-(1 << 18), (1 << 18) - 1)
SQUARE = Range(0, (1 << 19) - 1)
OFFSET = Range(0, 65520)
POSITION = Range(-(1 << 28), 1 << 28)
PURPOSE = Range(0, 8)
TURNS = Range(-(1 << 30) + 2, (1 << 30) - 2)


def _stepping(values, dice):
    """A rotor reading near the last one mostly, and currents."""
    live(values, dice)
    read_currents(dice)
    if dice.below(8):
        values[0] = (MOTION.rotor + MOTION.speed) & 16383
    values[1] = 1 if dice.below(20) == 0 else 0
    if dice.below(10) == 0:
        LOOP.masked = dice.bits(3)


def _tuned(values, dice):
    live(values, dice)
    LOOP_SETTINGS.current_kp = dice.bits(14)
    LOOP_SETTINGS.current_ki = dice.bits(12)
    LOOP_SETTINGS.pwm_period = dice.bits(12)
    LOOP_SETTINGS.pwm_half = LOOP_SETTINGS.pwm_period * 8 + 8
    LOOP_SETTINGS.pwm_span = LOOP_SETTINGS.pwm_period * 12
    LOOP_SETTINGS.pwm_pulse = dice.bits(8)
    LOOP_SETTINGS.pwm_window = dice.bits(9)
    LOOP_SETTINGS.trip_square = dice.bits(26)


def _repairing(values, dice):
    """What current_step left, with the arguments it was called with."""
    step = [0, 0]
    _stepping(step, dice)
    values[0] = current.current_step(step[0], step[1], LOOP)
    values[1] = step[0]
    values[2] = step[1]
    if values[0] == 0 and dice.bits(1):
        values[0] = 2 + dice.bits(1)


def _lost(values, dice):
    live(values, dice)
    LOOP.rotor_rejected = dice.bits(14) if dice.bits(1) else -1


def _turned(values, dice):
    """After any number of turns."""
    live(values, dice)
    STATE.turns = TURNS.any(dice)


def _long_vector(values, dice):
    live(values, dice)
    limit = LOOP.voltage_limit
    values[1] = (dice.below(2 * limit + 1) - limit) << 4
    values[2] = (dice.below(2 * limit + 1) - limit) << 3


def _gliding(values, dice):
    live(values, dice)
    STATE.target_rate = dice.bits(19) - (1 << 18)
    STATE.target_ticks_left = dice.below(17)
    STATE.goal_position = max(-(1 << 29), min((1 << 29) - 1, STATE.target + dice.bits(21) - (1 << 20)))


def _posed(values, dice):
    live(values, dice)
    CALIBRATION.pose = dice.bits(18) - (1 << 17)
    CALIBRATION.rest_rotor = dice.bits(14)
    CALIBRATION.rest_joint = dice.bits(14)


def _calibrating(values, dice):
    """In the middle of a calibration: as many ticks of one as come up, then the probed one."""
    if dice.below(30) == 0 or CALIBRATION.phase == calibration.PHASE_IDLE:
        begin()
        calibration.calibration_start(CALIBRATION, 1 + dice.below(3))
        CALIBRATION.pose_given = dice.bits(1)
    if dice.bits(1):
        skip_ahead(dice)
    for _ in range(dice.below(30)):
        follow_field(dice)
        calibration.calibration_step(LOOP, SETTINGS, STATE, IO, CALIBRATION)
    follow_field(dice)


def skip_ahead(dice):
    """To near the end of any phase, as if all had gone well until then, or nearly all."""
    travel = 262144 if CALIBRATION.kind == calibration.CAL_FULL else 32768
    pairs = SETTINGS.pole_pairs
    phase = 1 + dice.below(calibration.PHASE_RETURN)
    back = phase == calibration.PHASE_BACK or phase == calibration.PHASE_RETURN
    CALIBRATION.phase = phase
    CALIBRATION.phase_ticks = (0, 250, 250, 506)[phase] if phase < calibration.PHASE_FORWARD else 0
    CALIBRATION.angle = 1280 if back else travel - 1280
    CALIBRATION.moved = CALIBRATION.angle // (4 * pairs)
    CALIBRATION.direction = 1
    CALIBRATION.pole_pairs = pairs
    CALIBRATION.moved_forward = travel // (4 * pairs)
    CALIBRATION.joint_moved_forward = CALIBRATION.moved_forward * 256 // SETTINGS.gear_q8
    for axis in range(3):
        CALIBRATION.raw_sum[axis] = 2048 * 250
    follow_field(dice)
    CALIBRATION.rotor_last = LOOP.rotor
    CALIBRATION.joint_last = IO.joint_raw
    CALIBRATION.rest_rotor = LOOP.rotor
    if dice.below(3) == 0:
        value = dice.bits(16) - 32768
        go_wrong(dice.below(4), value)


def go_wrong(where, value):
    """One of what calibration has measured is anything."""
    if where == 0:
        CALIBRATION.moved_forward = value
    elif where == 1:
        CALIBRATION.moved = value
    elif where == 2:
        CALIBRATION.joint_moved_forward = value
    else:
        CALIBRATION.raw_sum[0] = value


def follow_field(dice):
    """The rotor goes where the field points, as a free one does, with the current that is asked for."""
    pairs = SETTINGS.pole_pairs
    turned = CALIBRATION.angle // (4 * pairs) if pairs else 0
    LOOP.rotor = (turned + 100 + dice.bits(1)) & 16383
    LOOP.current_d = LOOP.reference_d + dice.bits(3) - 4
    IO.joint_raw = (turned * 256 // SETTINGS.gear_q8) & 16383
    STATE.rate = 0
    STATE.bus = (SETTINGS.cal_bus_least + SETTINGS.cal_bus_most) >> 1
    for phase in range(3):
        LOOP.raw[phase] = 2048 + dice.bits(2)


def _probe(source, name, *arguments, fit=live, vectors=1):
    watch = (FIELDS, STATE, SETTINGS, CALIBRATION)
    return Probe(name, getattr(source, name), arguments, watch=watch, fit=fit, begin=begin, vectors=vectors)


class Life(Probe):
    """The motion tick through a long life: set-points, modes, faults, arming, calibrating, homing."""

    def draw(self, index, count):
        wish(self.dice)
        trouble(self.dice)
        one_millisecond(self.dice)


PROBES = (
    _probe(current, "current_step", ROTOR, ROTOR, LOOP, fit=_stepping, vectors=4),
    _probe(current, "current_repair", ROTOR, ROTOR, ROTOR, LOOP, fit=_repairing, vectors=2),
    _probe(current, "turn_voltage", LOOP),
    _probe(current, "limit_voltage", LOOP),
    _probe(current, "current_reset", LOOP, ROTOR),
    _probe(current, "current_relax", LOOP),
    _probe(current, "set_offsets", LOOP, OFFSET, OFFSET, OFFSET),
    _probe(current, "current_sum", LOOP),
    _probe(current, "set_loop", LOOP, LOOP_SETTINGS, fit=_tuned),
    _probe(svpwm, "svpwm", LOOP, CURRENT, CURRENT, fit=_long_vector),
    _probe(feed, "feed_bus", LOOP, SETTINGS, Range(-32768, 32767)),
    _probe(feed, "lead_angle", LOOP, SETTINGS, STATE),
    _probe(feed, "feed_voltages", LOOP, SETTINGS, STATE),
    _probe(cascade, "cascade_reset", SETTINGS, STATE),
    _probe(cascade, "cascade_step", SETTINGS, STATE, IO),
    _probe(cascade, "follow_position", SETTINGS, STATE, IO),
    _probe(cascade, "glide", STATE, RATE, fit=_gliding),
    _probe(cascade, "feed_acceleration", SETTINGS, STATE, Range(-65535, 65535)),
    _probe(cascade, "follow_velocity", SETTINGS, STATE, Range(-(1 << 24), 1 << 24)),
    _probe(cascade, "velocity_loop", SETTINGS, STATE, CURRENT),
    _probe(cascade, "impedance", SETTINGS, STATE, IO),
    _probe(cascade, "guard_position", SETTINGS, STATE, CURRENT),
    _probe(cascade, "limit_current", SETTINGS, STATE, Range(-(1 << 21), 1 << 21)),
    _probe(cascade, "damping_current", SETTINGS, STATE),
    _probe(cascade, "write_current", LOOP, SETTINGS, STATE),
    _probe(encoder, "encoder_reset", LOOP, SETTINGS, STATE),
    _probe(encoder, "encoder_resync", LOOP, STATE, fit=_lost),
    _probe(encoder, "encoder_step", LOOP, SETTINGS, STATE, fit=_turned, vectors=3),
    _probe(encoder, "track_rate", SETTINGS, STATE, Range(-8192, 8191)),
    _probe(encoder, "joint_count", SETTINGS, ROTOR),
    _probe(encoder, "watch_encoders", SETTINGS, STATE, IO),
    _probe(encoder, "choose_turn", SETTINGS, STATE, POSITION),
    _probe(encoder, "home_at", SETTINGS, STATE, POSITION),
    _probe(encoder, "home_by_encoder", SETTINGS, STATE, IO),
    _probe(report, "report_position", SETTINGS, STATE),
    _probe(report, "report_velocity", SETTINGS, STATE),
    _probe(report, "report_current", LOOP, SETTINGS),
    _probe(report, "report_bus", SETTINGS, STATE),
    _probe(thermal, "model_reset", STATE, Range(-1000, 4000)),
    _probe(thermal, "model_step", SETTINGS, STATE, SQUARE),
    _probe(thermal, "i2t_step", SETTINGS, STATE, SQUARE),
    _probe(homing, "homing_start", STATE),
    _probe(homing, "homing_stop", STATE),
    _probe(homing, "homing_step", SETTINGS, STATE),
    _probe(protection, "report_cause", STATE, Range(0, 80), Range(-(1 << 23), (1 << 23) - 1)),
    _probe(protection, "protect_motion", LOOP, SETTINGS, STATE, IO),
    _probe(protection, "gather_heat", LOOP, STATE),
    _probe(protection, "protect_slow", SETTINGS, STATE, IO, CURVE),
    _probe(drive_state, "drive_reset", STATE),
    _probe(drive_state, "drive_arm", SETTINGS, STATE, IO, PURPOSE),
    _probe(drive_state, "drive_disarm", STATE),
    _probe(drive_state, "drive_quick_stop", STATE),
    _probe(drive_state, "drive_clear", STATE),
    _probe(drive_state, "drive_step", SETTINGS, STATE, IO, vectors=2),
    _probe(calibration, "set_commutation", LOOP, SETTINGS),
    _probe(calibration, "calibration_start", CALIBRATION, Range(1, 3)),
    _probe(calibration, "calibration_abort", LOOP, SETTINGS, CALIBRATION),
    _probe(calibration, "calibration_needs_bridge", CALIBRATION),
    _probe(calibration, "calibration_step", LOOP, SETTINGS, STATE, IO, CALIBRATION, fit=_calibrating),
    _probe(calibration, "set_zeros", SETTINGS, CALIBRATION, fit=_posed),
    Probe("fill_sine", sine.fill_sine, (LOOP,), watch=(LOOP,), ticks=False),
    _probe(tick, "joint_reset", LOOP, SETTINGS, STATE, ROTOR),
    _probe(tick, "slow_tick", SETTINGS, STATE, IO, CURVE),
    _probe(tick, "begin_calibration", STATE, CALIBRATION, Range(1, 3)),
    _probe(tick, "motion_tick", LOOP, SETTINGS, STATE, IO, CALIBRATION, vectors=2),
    Life("motion_tick:life", tick.motion_tick, BLOCKS, watch=(FIELDS, STATE), begin=begin, vectors=10),
)
