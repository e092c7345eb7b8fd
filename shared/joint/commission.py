"""Commissioning: from an unknown motor in a leg to a current loop that knows it, tick by tick, in integers.

    at rest, bridge off (here) -> winding: R, L, gains (winding.py)
    -> once round and back and round again: direction, pole pairs, offset, eccentricity (turning.py)
    -> to and fro by itself: flux linkage, and the offset anew (spinning.py)
    -> the same gently: inertia, friction, gains of the outer loops (swinging.py, outer.py) -> done

Each part checks what it relies on and ends everything with a reason, FAULT_COMMISSION_*. What is found is written only
when everything is. The current never exceeds the trip level, the rotor stays within the turn it was taken round, and
whatever ends the torque ends commissioning (commission_abort). To verify is the winding's first phases and half an
electrical turn to and fro, 1.2 deg at a 22:1 joint with 7 pole pairs; direction and offset are compared, not changed.
"""

from ..num.fixed import ratio, saturate, wrap_brad
from ..runtime import const, hot
from .bend import fill_bend, set_bend, straightened
from .cogging import hold_waves, set_waves
from .commission_state import (
    COMMISSION_FULL,
    PHASE_FORWARD,
    PHASE_IDLE,
    PHASE_PROVE_CURRENT,
    PHASE_PROVE_VELOCITY,
    PHASE_RAMP,
    PHASE_REST,
    PHASE_SPIN,
    PHASE_SWING,
    Commission,
    go_on,
    refuse,
)
from .commutation import set_commutation
from .current import current_reset, set_offsets
from .encoder import wrap_count
from .faults import (
    FAULT_COMMISSION_BUS,
    FAULT_COMMISSION_ENCODER,
    FAULT_COMMISSION_MOVING,
    FAULT_COMMISSION_NOISE,
    FAULT_COMMISSION_OFFSET,
    FAULT_COMMISSION_OFFSET_CHANGED,
    FAULT_NONE,
)
from .layout import CurrentLoop, JointIo, JointSettings, JointState
from .outer import keep_outer, restore_outer
from .proving import prove_begin, prove_current, prove_step
from .spinning import spin_begin, spin_step
from .swinging import mechanics_begin, mechanics_step
from .turning import turn_step
from .waves import creep_begin, creep_step
from .winding import winding_step

_ROTOR = const(3)  # its place in lowest and highest, behind the phases
_FRESH_TICKS = const(4)  # until the rotor is read without the old table
_REST_TICKS = const(256)
_REST_SHIFT = const(8)  # of these
_NOISE_MOST = const(24)  # counts peak to peak: 0.1 A
_ENCODER_NOISE_MOST = const(8)  # rc peak to peak
_MOVED_MOST = const(64)  # rc that noise alone may seem to move
_OMEGA_L = const(322)  # 8 rate are 4 pole_pairs / 320 brad a step, in rad of 2^-28 then; a quarter of it in Q14
_DEAD_MOST = const(3276)  # of the parameter


@hot
def commission_start(commission: Commission, kind: int) -> int:
    """Begin commissioning of ``kind`` with the next tick; return PHASE_REST. pose_given and pose are the caller's."""
    commission.kind = kind
    commission.reason = FAULT_NONE
    commission.reason_value = 0
    for phase in range(3):
        commission.raw_sum[phase] = 0
    for at in range(4):
        commission.lowest[at] = 0xFFFF
        commission.highest[at] = -0xFFFF
        commission.harmonic_sum[at] = 0
        commission.bend[at] = 0
    commission.level = 0
    commission.error_sum = 0
    commission.error_way = 0
    commission.backlash = -1
    commission.moved = 0
    commission.joint_moved = 0
    commission.moved_seen = 0
    commission.moved_first = 0
    return go_on(commission, PHASE_REST)


@hot
def commission_abort(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """End commissioning: restore gains, commutation and references; return PHASE_IDLE."""
    if commission.kept_kp:
        loop.kp = commission.kept_kp
        loop.ki = commission.kept_ki
    restore_outer(settings, commission)
    commission.phase = PHASE_IDLE
    commission.kind = 0
    loop.probing = 0
    loop.alternate_d = 0
    loop.alternate_q = 0
    loop.feed_d = 0
    loop.feed_q = 0
    loop.reference_d = 0
    loop.reference_q = 0
    set_bend(loop, settings)
    hold_waves(loop, 0)
    set_waves(loop, settings)
    set_commutation(loop, settings)
    return PHASE_IDLE


@hot
def commission_needs_bridge(commission: Commission) -> int:
    """Return 1 while the field is on, 0 at rest and when idle: the bridge is off then."""
    if commission.phase > PHASE_REST:
        return 1
    return 0


@hot
def commission_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick; return the phase, PHASE_IDLE when over. Then ``reason`` is 0 or says what stood against it.

    A full one takes 20 to 45 s by the pole pairs, to verify 5 s.
    """
    phase = commission.phase
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    commission.phase_ticks += 1
    if phase == PHASE_REST:
        _rest(loop, settings, state, io, commission)
    elif phase < PHASE_PROVE_CURRENT:
        winding_step(loop, settings, commission)
    elif phase == PHASE_PROVE_CURRENT:
        if prove_current(loop, settings, commission):
            go_on(commission, PHASE_FORWARD)
    elif phase < PHASE_SPIN:
        if turn_step(loop, settings, io, commission):
            _turned(loop, settings, commission)
    elif phase == PHASE_SPIN:
        if spin_step(loop, settings, state, commission):
            mechanics_begin(loop, settings, commission)
    elif phase == PHASE_SWING:
        if mechanics_step(loop, settings, state, commission):
            creep_begin(loop, settings, commission)
    elif phase < PHASE_PROVE_VELOCITY:
        if creep_step(loop, settings, state, io, commission):
            prove_begin(settings, commission)
    elif prove_step(loop, settings, state, commission):
        _write(loop, settings, state, commission)
    if commission.phase == PHASE_IDLE:
        commission_abort(loop, settings, commission)
    return commission.phase


@hot
def _turned(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """After the turns: compare the offset, or let the rotor spin; return the phase."""
    if commission.kind == COMMISSION_FULL:
        return spin_begin(loop, commission)
    change = wrap_brad(commission.offset_found - settings.elec_offset)
    if change > settings.verify or change < -settings.verify:
        return refuse(commission, FAULT_COMMISSION_OFFSET_CHANGED, change)
    return go_on(commission, PHASE_IDLE)


@hot
def _extremes(commission: Commission, place: int, value: int) -> int:
    """Take in a value of the lowest and highest at ``place``; return how far apart these are."""
    if value < commission.lowest[place]:
        commission.lowest[place] = value
    if value > commission.highest[place]:
        commission.highest[place] = value
    return commission.highest[place] - commission.lowest[place]


@hot
def _rest(loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission) -> int:
    """Collect 256 readings with the bridge off, then check them and set the current offsets."""
    if commission.phase_ticks == 1:
        commission.kept_kp = loop.kp
        commission.kept_ki = loop.ki
        keep_outer(settings, commission)
        hold_waves(loop, 0)
        if commission.kind == COMMISSION_FULL:
            state.homed = 0
            fill_bend(loop, 0, 0, 0, 0)
    if commission.phase_ticks < _FRESH_TICKS:
        commission.rest_rotor = loop.rotor
        commission.rest_joint = io.joint_raw
        return PHASE_REST
    for phase in range(3):
        raw = loop.raw[phase]
        commission.raw_sum[phase] = commission.raw_sum[phase] + raw
        _extremes(commission, phase, raw)
    _extremes(commission, _ROTOR, wrap_count(loop.rotor - commission.rest_rotor))
    if commission.phase_ticks < _FRESH_TICKS + _REST_TICKS - 1:
        return PHASE_REST
    if _check_rest(loop, settings, state, commission):
        return PHASE_IDLE
    shift = _REST_SHIFT - 4
    set_offsets(loop, commission.raw_sum[0] >> shift, commission.raw_sum[1] >> shift, commission.raw_sum[2] >> shift)
    loop.kp = 0  # these may be another motor's
    loop.ki = 0
    current_reset(loop, loop.rotor)
    return go_on(commission, PHASE_RAMP)


@hot
def _check_rest(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Return FAULT_NONE if the currents, the supply and the rotor at rest are fit, else the first fault."""
    for phase in range(3):
        offset = commission.raw_sum[phase] >> _REST_SHIFT
        if offset > 2048 + settings.offset_spread or offset < 2048 - settings.offset_spread:
            return refuse(commission, FAULT_COMMISSION_OFFSET, offset)
        noise = commission.highest[phase] - commission.lowest[phase]
        if noise > _NOISE_MOST:
            return refuse(commission, FAULT_COMMISSION_NOISE, noise)
    if state.bus < settings.commission_bus_least or state.bus > settings.commission_bus_most:
        return refuse(commission, FAULT_COMMISSION_BUS, state.bus)
    noise = commission.highest[_ROTOR] - commission.lowest[_ROTOR]
    moved = wrap_count(loop.rotor - commission.rest_rotor)
    if noise > _ENCODER_NOISE_MOST and moved <= _MOVED_MOST and moved >= -_MOVED_MOST:
        return refuse(commission, FAULT_COMMISSION_ENCODER, noise)
    if noise > _ENCODER_NOISE_MOST or state.rate > settings.stall_rate or state.rate < -settings.stall_rate:
        return refuse(commission, FAULT_COMMISSION_MOVING, state.rate)
    return FAULT_NONE


@hot
def _write(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Write everything found; return PHASE_IDLE."""
    before = settings.pole_pairs
    pairs = commission.pole_pairs
    settings.bemf = commission.flux
    settings.omega_l = ((commission.inductance_q >> 2) * pairs >> 4) * _OMEGA_L >> 10
    settings.dead = saturate(ratio(commission.dead_q4, saturate(state.bus, 1, 0x7FFF), 11), 0, _DEAD_MOST)
    if before > 0:
        settings.advance = settings.advance * pairs // before
        settings.age = settings.age * pairs // before
    commission.kept_kp = loop.kp
    commission.kept_ki = loop.ki
    commission.kept_outer[0] = 0
    settings.elec_offset = commission.offset_found
    settings.direction = commission.direction
    settings.pole_pairs = pairs
    settings.bend_cos1 = commission.bend[0]
    settings.bend_sin1 = commission.bend[1]
    settings.bend_cos2 = commission.bend[2]
    settings.bend_sin2 = commission.bend[3]
    _write_waves(settings, commission)
    settings.commissioned = 1
    if settings.has_joint_encoder:
        same = commission.moved_forward ^ commission.joint_moved_forward
        settings.joint_encoder_sign = settings.joint_sign
        if same < 0:
            settings.joint_encoder_sign = -settings.joint_sign
    commission.rest_rotor = straightened(loop, commission.rest_rotor)
    if commission.pose_given:
        set_zeros(settings, commission)
    return go_on(commission, PHASE_IDLE)


@hot
def _write_waves(settings: JointSettings, commission: Commission) -> int:
    """Write the cogging's waves; return how often a turn the first is."""
    settings.cogging_order_0 = commission.wave_order[0]
    settings.cogging_current_0 = saturate(commission.wave_current[0], 0, 0x7FFF)
    settings.cogging_phase_0 = commission.wave_phase[0]
    settings.cogging_order_1 = commission.wave_order[1]
    settings.cogging_current_1 = saturate(commission.wave_current[1], 0, 0x7FFF)
    settings.cogging_phase_1 = commission.wave_phase[1]
    settings.cogging_order_2 = commission.wave_order[2]
    settings.cogging_current_2 = saturate(commission.wave_current[2], 0, 0x7FFF)
    settings.cogging_phase_2 = commission.wave_phase[2]
    return settings.cogging_order_0


@hot
def set_zeros(settings: JointSettings, commission: Commission) -> int:
    """Set both encoders' zeros from the pose at which they read rest_rotor and rest_joint; return settings.zero.

    The joint encoder's zero is rounded to its count: the rotor's is exact.
    """
    settings.zero = (commission.rest_rotor - commission.pose * settings.joint_sign) & 16383
    if settings.has_joint_encoder and settings.gear_q8 > 0:
        half = settings.gear_q8 >> 1
        angle = ((commission.pose << 8) + half) // settings.gear_q8
        settings.joint_encoder_zero = (commission.rest_joint - angle * settings.joint_encoder_sign) & 16383
    return settings.zero
