"""shared/joint: the functions that work on a joint's blocks, in states that a life of the joint leads to."""

from shared.joint import (
    bend,
    cascade,
    checking,
    cogging,
    commission,
    commutation,
    creeping,
    current,
    drive_state,
    encoder,
    feed,
    findings,
    holding,
    homing,
    outer,
    play,
    probe,
    protection,
    proving,
    report,
    resting,
    spectrum,
    spinning,
    svpwm,
    swinging,
    thermal,
    tick,
    turning,
    waves,
    winding,
)
from shared.joint import commission_state as state
from shared.joint.layout import LoopSettings

from .draw import Range
from .joint_robot import (
    COMMISSION,
    CURVE,
    FIELDS,
    IO,
    LOOP,
    MOTION,
    SETTINGS,
    SIGN,
    STATE,
    begin,
    live,
    one_millisecond,
    read_currents,
    trouble,
    wish,
)
from .probe import Probe, probe_with

LOOP_SETTINGS = LoopSettings()
BLOCKS = (LOOP, SETTINGS, STATE, IO, COMMISSION)
ROTOR = Range(0, 16383)
SUM = Range(-(1 << 18), 1 << 18)
CURRENT = Range(-12288, 12288)
RATE = Range(-(1 << 18), (1 << 18) - 1)
WAY = Range(-1023, 1023)
SQUARE = Range(0, (1 << 19) - 1)
OFFSET = Range(0, 65520)
POSITION = Range(-(1 << 28), 1 << 28)
PURPOSE = Range(0, 8)
HARMONIC = Range(-4095, 4095)
TICKS = (0, 250, 318, 509, 510, 510, 250, 250, 255, 9, 9, 9, 3990, 7990, 9990, 9990, 9, 90, 90)  # of each PHASE_*
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
    COMMISSION.pose = dice.bits(18) - (1 << 17)
    COMMISSION.rest_rotor = dice.bits(14)
    COMMISSION.rest_joint = dice.bits(14)


def _commissioning(values, dice):
    """In the middle of commissioning: as many ticks of it as come up, then the probed one."""
    if dice.below(30) == 0 or COMMISSION.phase == state.PHASE_IDLE:
        begin()
        commission.commission_start(COMMISSION, 1 + dice.below(2))
        COMMISSION.pose_given = dice.bits(1)
        commission.commission_step(LOOP, SETTINGS, STATE, IO, COMMISSION)
    if dice.bits(1):
        skip_ahead(dice)
    for _ in range(dice.below(30)):
        follow_field(dice)
        commission.commission_step(LOOP, SETTINGS, STATE, IO, COMMISSION)
    follow_field(dice)


def _in_phases(first, last):
    """Return what brings commissioning into one of these phases, as if all had gone well until then."""

    def fit(values, dice):
        live(values, dice)
        commission.commission_start(COMMISSION, 1)
        skip_to(dice, first + dice.below(last - first + 1))

    return fit


def _probing(values, dice):
    live(values, dice)
    probe.probe_begin(LOOP, 1)
    if dice.bits(1):
        probe.sine_begin(LOOP, SETTINGS, probe.SINE_ON_D + dice.bits(1))
    LOOP.alternate_d = dice.bits(10) * dice.bits(1)
    LOOP.alternate_q = dice.bits(10) * dice.bits(1)
    LOOP.level = dice.bits(10)


def skip_ahead(dice):
    """To near the end of any phase."""
    skip_to(dice, 1 + dice.below(state.PHASE_PROVE_POSITION))


def skip_to(dice, phase):
    """To near the end of a phase, as if all had gone well until then, or nearly all."""
    pairs = SETTINGS.pole_pairs
    full = COMMISSION.kind == state.COMMISSION_FULL
    travel = pairs * 65536 if full else 32768
    COMMISSION.phase = phase
    COMMISSION.phase_ticks = TICKS[phase]
    COMMISSION.angle = 1280 if phase == state.PHASE_BACK else travel - 1280
    COMMISSION.travel = (42 * 65536 if full else travel) if phase == state.PHASE_FORWARD else travel
    COMMISSION.moved = COMMISSION.angle // (4 * pairs)
    COMMISSION.direction = 1
    COMMISSION.pole_pairs = pairs
    COMMISSION.moved_first = 16384 // pairs
    COMMISSION.moved_seen = 0
    COMMISSION.moved_forward = travel // (4 * pairs)
    COMMISSION.joint_moved_forward = COMMISSION.moved_forward * 256 // SETTINGS.gear_q8
    COMMISSION.error_way = 1 + dice.bits(14)
    COMMISSION.error_sum = dice.bits(22) - (1 << 21)
    for at in range(4):
        COMMISSION.harmonic_sum[at] = dice.bits(22) - (1 << 21)
    COMMISSION.level = 50 + dice.bits(8)
    COMMISSION.window = (16, 256)[dice.bits(1)]
    COMMISSION.current_high_q4 = (700 + dice.bits(10)) << 4
    COMMISSION.resistance = 2000 + dice.bits(15)
    COMMISSION.inductance_d = 4000 + dice.bits(17)
    COMMISSION.inductance_q = 4000 + dice.bits(17)
    COMMISSION.dead_q4 = dice.bits(9)
    COMMISSION.centre = COMMISSION.moved_forward >> 1
    COMMISSION.sign = 1 - 2 * dice.bits(1)
    COMMISSION.half_swings = dice.below(9)
    COMMISSION.way = 40000 + dice.bits(15)
    swung(dice)
    crept(dice)
    ran(dice)
    for axis in range(3):
        COMMISSION.raw_sum[axis] = 2048 * 248
    probed(dice, phase)
    follow_field(dice)
    if phase in (state.PHASE_CREEP, state.PHASE_ROUND):
        held(dice)
    COMMISSION.rotor_last = LOOP.rotor
    COMMISSION.joint_last = IO.joint_raw
    COMMISSION.rest_rotor = LOOP.rotor
    if dice.below(3) == 0:
        go_wrong(dice.below(6), dice.bits(16) - 32768)


def swung(dice):
    """What the swings have summed up, near the end of one."""
    COMMISSION.swing_level = dice.below(4)
    COMMISSION.swing_rate = 512 + dice.bits(16)
    COMMISSION.swing_acceleration = 1 + dice.bits(11)
    COMMISSION.swing_reference = dice.bits(16) - 32768
    COMMISSION.periods = dice.below(4) - 1
    COMMISSION.period_ticks = 1 + dice.bits(12)
    COMMISSION.impulse = dice.bits(26) - (1 << 25)
    COMMISSION.work_in = 100000 + dice.bits(20)
    COMMISSION.work_out = -dice.bits(18)
    COMMISSION.way_in = dice.bits(14) - (1 << 13)
    COMMISSION.way_middle = 1 + dice.bits(13)
    COMMISSION.square_middle = dice.bits(18)
    COMMISSION.square_way = dice.bits(20)
    COMMISSION.inertia = 1000 + dice.bits(14)
    COMMISSION.swing_position = dice.bits(12) - (1 << 11)
    outer.keep_outer(SETTINGS, COMMISSION)


def crept(dice):
    """What a round of creeping has summed up, and how far its table has been looked at."""
    COMMISSION.creep_rounds = dice.below(5)
    COMMISSION.creep_part = dice.below(4)
    COMMISSION.creep_settled = dice.bits(1)
    COMMISSION.creep_far = 300 + dice.bits(13)
    COMMISSION.play_sum = dice.bits(24) - (1 << 23)
    COMMISSION.joint_moved = dice.bits(12) - (1 << 11)
    COMMISSION.backlash = dice.bits(10) - 1
    COMMISSION.order_before = dice.bits(8)
    COMMISSION.current_before = dice.bits(15)
    COMMISSION.phase_before = dice.bits(16) - 32768
    COMMISSION.moved_last = dice.bits(6) - 32
    COMMISSION.moved_before = dice.bits(6) - 32
    COMMISSION.current_last = dice.bits(17) - (1 << 16)
    COMMISSION.bin_last = dice.bits(9)
    COMMISSION.wave = dice.below(3)
    COMMISSION.rejected_waves = dice.bits(3)
    COMMISSION.order = 2 + dice.bits(7)
    COMMISSION.table_repeats = 1 + dice.bits(6)
    COMMISSION.order_last = COMMISSION.order + dice.bits(5)
    COMMISSION.bin_next = dice.below(4) << 7
    COMMISSION.cosine_sum = dice.bits(24) - (1 << 23)
    COMMISSION.sine_sum = dice.bits(24) - (1 << 23)
    for place in range(state.COGGING_BINS):
        COMMISSION.cogging_bins[place] = dice.bits(24) - (1 << 23)
    waved(dice)


def held(dice):
    """A field that holds the rotor, somewhere near it; or none."""
    COMMISSION.flux_taken = dice.below(385) - 192
    if dice.bits(1):
        LOOP.electrical_gain = 0
        turned = 4 * COMMISSION.pole_pairs * COMMISSION.direction * LOOP.rotor + COMMISSION.offset_found
        COMMISSION.angle = (turned + dice.bits(15) - (1 << 14)) & 0xFFFF
        COMMISSION.field_q6 = (COMMISSION.angle << 6) + dice.bits(6)


def waved(dice):
    """Waves of a cogging, which act or not."""
    for wave in range(3):
        cogging.put_wave(LOOP, wave, dice.below(512), dice.bits(15), dice.bits(16))
        COMMISSION.wave_order[wave] = dice.bits(8)
        COMMISSION.wave_current[wave] = dice.bits(15)
        COMMISSION.wave_phase[wave] = dice.bits(16) - 32768
    LOOP.waves = 3 * dice.bits(1)


def ran(dice):
    """Where a run of the proofs is."""
    COMMISSION.run_ticks = dice.below(300) - 1
    COMMISSION.proved = 4096 + dice.bits(11)
    COMMISSION.repeated = dice.bits(1)
    COMMISSION.goal = dice.bits(20) - (1 << 19)


def _waving(values, dice):
    live(values, dice)
    waved(dice)


def probed(dice, phase):
    """What the interrupt has added up by then."""
    probe.probe_begin(LOOP, 1)
    if phase == state.PHASE_PROVE_CURRENT:
        probe.sine_begin(LOOP, SETTINGS, probe.SINE_ON_D + dice.bits(1))
    steps = 2560
    LOOP.probe_steps = steps
    LOOP.sum_current_d = steps * (200 + dice.bits(9))
    LOOP.sum_current_q = steps * (200 + dice.bits(9))
    LOOP.sum_voltage_d = steps * (dice.bits(6) - 32)
    LOOP.sum_voltage_q = steps * (200 + dice.bits(9))
    LOOP.alternate_d = 300 + dice.bits(9) if phase == state.PHASE_ALTERNATE_D else 0
    LOOP.alternate_q = 300 + dice.bits(9) if phase == state.PHASE_ALTERNATE_Q else 0


def go_wrong(where, value):
    """One of what commissioning has measured is anything."""
    if where == 0:
        COMMISSION.moved_forward = value
    elif where == 1:
        COMMISSION.moved = value
    elif where == 2:
        COMMISSION.joint_moved_forward = value
    elif where == 3:
        COMMISSION.raw_sum[0] = value
    elif where == 4:
        COMMISSION.harmonic_sum[0] = value << 12
    else:
        LOOP.sum_current_d = value << 8


def follow_field(dice):
    """The rotor goes where the field points, as a free one does, with the current that is asked for."""
    pairs = SETTINGS.pole_pairs
    turned = COMMISSION.angle // (4 * pairs) if pairs else 0
    LOOP.rotor = (turned + 100 + dice.bits(1)) & 16383
    LOOP.current_d = SETTINGS.commission_current + dice.bits(3) - 4
    IO.joint_raw = (turned * 256 // SETTINGS.gear_q8) & 16383
    STATE.rate = 0
    STATE.bus = (SETTINGS.commission_bus_least + SETTINGS.commission_bus_most) >> 1
    for phase in range(3):
        LOOP.raw[phase] = 2048 + dice.bits(2)
        if COMMISSION.phase != state.PHASE_REST:
            LOOP.raw[phase] += (200, -60, -140)[phase]


_probe = probe_with(watch=(FIELDS, STATE, SETTINGS, COMMISSION), fit=live, begin=begin)


class Life(Probe):
    """The motion tick through a long life: set-points, modes, faults, arming, commissioning, homing."""

    def draw(self, index, count):
        wish(self.dice)
        trouble(self.dice)
        one_millisecond(self.dice)


PROBES = (
    _probe(current, "current_step", (ROTOR, ROTOR, LOOP), fit=_stepping, vectors=4),
    _probe(current, "current_repair", (ROTOR, ROTOR, ROTOR, LOOP), fit=_repairing, vectors=2),
    _probe(current, "turn_voltage", (LOOP,)),
    _probe(current, "limit_voltage", (LOOP,)),
    _probe(current, "current_reset", (LOOP, ROTOR)),
    _probe(current, "current_clear", (LOOP,)),
    _probe(current, "set_offsets", (LOOP, OFFSET, OFFSET, OFFSET)),
    _probe(current, "current_sum", (LOOP,)),
    _probe(current, "set_loop", (LOOP, LOOP_SETTINGS), fit=_tuned),
    _probe(svpwm, "svpwm", (LOOP, CURRENT, CURRENT), fit=_long_vector),
    _probe(feed, "feed_bus", (LOOP, SETTINGS, Range(-32768, 32767))),
    _probe(commutation, "lead_angle", (LOOP, SETTINGS, STATE)),
    _probe(feed, "feed_voltages", (LOOP, SETTINGS, STATE)),
    _probe(cascade, "cascade_reset", (SETTINGS, STATE)),
    _probe(cascade, "cascade_step", (SETTINGS, STATE, IO)),
    _probe(cascade, "follow_position", (SETTINGS, STATE, IO)),
    _probe(cascade, "glide", (STATE, RATE), fit=_gliding),
    _probe(cascade, "feed_acceleration", (SETTINGS, STATE, Range(-65535, 65535))),
    _probe(cascade, "follow_velocity", (SETTINGS, STATE, Range(-(1 << 24), 1 << 24))),
    _probe(cascade, "velocity_loop", (SETTINGS, STATE, CURRENT)),
    _probe(cascade, "impedance", (SETTINGS, STATE, IO)),
    _probe(cascade, "guard_position", (SETTINGS, STATE, CURRENT)),
    _probe(cascade, "limit_current", (SETTINGS, STATE, Range(-(1 << 21), 1 << 21))),
    _probe(cascade, "damping_current", (SETTINGS, STATE)),
    _probe(cascade, "write_current", (LOOP, SETTINGS, STATE)),
    _probe(encoder, "encoder_reset", (LOOP, SETTINGS, STATE)),
    _probe(encoder, "encoder_resync", (LOOP, STATE), fit=_lost),
    _probe(encoder, "encoder_step", (LOOP, SETTINGS, STATE), fit=_turned, vectors=3),
    _probe(encoder, "track_rate", (SETTINGS, STATE, Range(-8192, 8191))),
    _probe(encoder, "joint_count", (SETTINGS, ROTOR)),
    _probe(encoder, "watch_encoders", (SETTINGS, STATE, IO)),
    _probe(encoder, "choose_turn", (SETTINGS, STATE, POSITION)),
    _probe(encoder, "home_at", (SETTINGS, STATE, POSITION)),
    _probe(encoder, "home_by_encoder", (SETTINGS, STATE, IO)),
    _probe(report, "report_position", (SETTINGS, STATE)),
    _probe(report, "report_velocity", (SETTINGS, STATE)),
    _probe(report, "report_current", (LOOP, SETTINGS)),
    _probe(report, "report_bus", (SETTINGS, STATE)),
    _probe(thermal, "model_reset", (STATE, Range(-1000, 4000))),
    _probe(thermal, "model_step", (SETTINGS, STATE, SQUARE)),
    _probe(thermal, "i2t_step", (SETTINGS, STATE, SQUARE)),
    _probe(homing, "homing_start", (STATE,)),
    _probe(homing, "homing_stop", (STATE,)),
    _probe(homing, "homing_step", (SETTINGS, STATE)),
    _probe(homing, "homing_tick", (SETTINGS, STATE)),
    _probe(protection, "report_cause", (STATE, Range(0, 80), Range(-(1 << 23), (1 << 23) - 1))),
    _probe(protection, "protect_motion", (LOOP, SETTINGS, STATE, IO)),
    _probe(thermal, "gather_heat", (LOOP, STATE)),
    _probe(drive_state, "drive_reset", (STATE,)),
    _probe(drive_state, "drive_arm", (SETTINGS, STATE, IO, PURPOSE)),
    _probe(drive_state, "drive_disarm", (STATE,)),
    _probe(drive_state, "drive_quick_stop", (STATE,)),
    _probe(drive_state, "drive_clear", (STATE,)),
    _probe(drive_state, "drive_step", (SETTINGS, STATE, IO), vectors=2),
    _probe(current, "keep_gains", (LOOP, LOOP_SETTINGS), fit=_tuned),
    _probe(bend, "corrected_rotor", (LOOP, ROTOR)),
    _probe(bend, "fill_bend", (LOOP, HARMONIC, HARMONIC, HARMONIC, HARMONIC)),
    _probe(bend, "set_bend", (LOOP, SETTINGS)),
    _probe(commutation, "commutate", (LOOP, Range(1, 50), SIGN, Range(-(1 << 20), 1 << 20))),
    _probe(commutation, "set_commutation", (LOOP, SETTINGS)),
    _probe(commission, "commission_start", (COMMISSION, Range(1, 2))),
    _probe(commission, "commission_abort", (LOOP, SETTINGS, COMMISSION)),
    _probe(commission, "commission_step", (LOOP, SETTINGS, STATE, IO, COMMISSION), fit=_commissioning, vectors=2),
    _probe(findings, "write_findings", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(18, 18)),
    _probe(findings, "set_zeros", (SETTINGS, COMMISSION), fit=_posed),
    _probe(state, "fail", (COMMISSION, Range(64, 90), Range(-(1 << 23), (1 << 23) - 1))),
    _probe(state, "begin_phase", (COMMISSION, Range(0, 18))),
    _probe(winding, "winding_inductance", (Range(1, 1 << 22), Range(1, 1 << 20), Range(0, 1 << 18))),
    _probe(probe, "probe_begin", (LOOP, SIGN)),
    _probe(probe, "probe_step", (LOOP,), fit=_probing),
    _probe(probe, "sine_begin", (LOOP, SETTINGS, Range(2, 3))),
    _probe(commutation, "point", (LOOP, COMMISSION)),
    _probe(resting, "rest_step", (LOOP, SETTINGS, STATE, IO, COMMISSION), fit=_in_phases(1, 1)),
    _probe(winding, "winding_step", (LOOP, SETTINGS, COMMISSION), fit=_in_phases(2, 7)),
    _probe(turning, "turn_step", (LOOP, SETTINGS, IO, COMMISSION), fit=_in_phases(9, 11)),
    _probe(spinning, "spin_begin", (LOOP, COMMISSION), fit=_in_phases(11, 11)),
    _probe(spinning, "spin_step", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(12, 12)),
    _probe(spinning, "swing", (LOOP, STATE, COMMISSION), fit=_in_phases(12, 13)),
    _probe(commutation, "follow_rotor", (LOOP, STATE, COMMISSION), fit=_in_phases(12, 13)),
    _probe(spinning, "turn_round", (COMMISSION,), fit=_in_phases(12, 13)),
    _probe(spinning, "swing_rate", (SETTINGS, COMMISSION), fit=_in_phases(12, 13)),
    _probe(spinning, "swing_current", (SETTINGS, STATE, COMMISSION, Range(1, 262143)), fit=_in_phases(12, 13)),
    _probe(swinging, "mechanics_begin", (LOOP, SETTINGS, COMMISSION), fit=_in_phases(12, 13)),
    _probe(swinging, "mechanics_step", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(13, 13)),
    _probe(swinging, "follow_rate", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(12, 13)),
    _probe(swinging, "ask_rate", (SETTINGS, STATE, COMMISSION), fit=_in_phases(12, 13)),
    _probe(holding, "hold_rotor", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(14, 15)),
    _probe(holding, "turning_current", (SETTINGS, COMMISSION, SUM, SUM, ROTOR, WAY), fit=_in_phases(14, 15)),
    _probe(holding, "find_flux_taken", (SETTINGS, COMMISSION), fit=_in_phases(13, 14)),
    _probe(play, "follow_joint", (IO, COMMISSION)),
    _probe(play, "add_play", (SETTINGS, COMMISSION, WAY), fit=_in_phases(14, 15)),
    _probe(play, "find_play", (SETTINGS, COMMISSION), fit=_in_phases(14, 15)),
    _probe(creeping, "begin_round", (LOOP, SETTINGS, COMMISSION, Range(0, 3)), fit=_in_phases(13, 16)),
    _probe(creeping, "creep_round", (LOOP, SETTINGS, STATE, IO, COMMISSION), fit=_in_phases(14, 15)),
    _probe(creeping, "stand_still", (LOOP, SETTINGS, STATE, IO, COMMISSION), fit=_in_phases(16, 16)),
    _probe(spectrum, "clear_table", (COMMISSION, Range(1, 100)), fit=_in_phases(14, 15)),
    _probe(spectrum, "add_to_table", (COMMISSION, Range(-0x7FFFF, 0x7FFFF)), fit=_in_phases(14, 15)),
    _probe(spectrum, "look_for", (COMMISSION, Range(0, 250)), fit=_in_phases(16, 16)),
    _probe(spectrum, "look_at_table", (LOOP, COMMISSION), fit=_in_phases(16, 16)),
    _probe(spectrum, "wave_amplitude", (COMMISSION,), fit=_in_phases(16, 16)),
    _probe(checking, "begin_check", (LOOP, SETTINGS, COMMISSION, Range(0, 32767)), fit=_in_phases(16, 16)),
    _probe(checking, "check_wave", (LOOP, SETTINGS, COMMISSION), fit=_in_phases(16, 16)),
    _probe(waves, "creep_begin", (LOOP, SETTINGS, COMMISSION), fit=_in_phases(13, 13)),
    _probe(waves, "creep_step", (LOOP, SETTINGS, STATE, IO, COMMISSION), fit=_in_phases(14, 16)),
    _probe(proving, "prove_current", (LOOP, SETTINGS, COMMISSION), fit=_in_phases(8, 8)),
    _probe(proving, "prove_begin", (SETTINGS, COMMISSION), fit=_in_phases(16, 16)),
    _probe(proving, "prove_step", (LOOP, SETTINGS, STATE, COMMISSION), fit=_in_phases(17, 18)),
    _probe(cogging, "cogging_step", (LOOP, ROTOR), fit=_waving),
    _probe(cogging, "set_waves", (LOOP, SETTINGS)),
    _probe(cogging, "put_wave", (LOOP, Range(0, 2), Range(0, 511), Range(0, 40000), Range(-32768, 65535))),
    _probe(cogging, "try_wave", (LOOP, COMMISSION, Range(0, 2)), fit=_in_phases(14, 16)),
    _probe(cogging, "drop_wave", (LOOP, COMMISSION, Range(0, 2)), fit=_in_phases(14, 16)),
    _probe(cogging, "switch_waves", (LOOP, Range(0, 1))),
    _probe(outer, "set_outer_gains", (SETTINGS, Range(0, 1 << 18), Range(0, 20588))),
    _probe(outer, "keep_outer", (SETTINGS, COMMISSION)),
    _probe(outer, "restore_outer", (SETTINGS, COMMISSION)),
    Probe(commutation, "fill_sine", (LOOP,), watch=(LOOP,), ticks=False),
    _probe(tick, "joint_reset", (LOOP, SETTINGS, STATE, ROTOR)),
    _probe(thermal, "slow_tick", (SETTINGS, STATE, IO, CURVE)),
    _probe(tick, "begin_commission", (STATE, COMMISSION, Range(1, 2))),
    _probe(tick, "motion_tick", (LOOP, SETTINGS, STATE, IO, COMMISSION), vectors=2),
    Life(tick, "motion_tick:life", BLOCKS, watch=(FIELDS, STATE), begin=begin, vectors=10),
)
