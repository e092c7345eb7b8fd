"""A joint's calls in their order: the reset once, the motion tick a thousand times a second.

The current step is in current.py and may interrupt motion_tick at any place; slow_tick, ten times a second, is in
thermal.py.
"""

from ..runtime import hot
from ..wire.names import MODE_COMMISSIONING, MODE_HOMING
from .cascade import cascade_reset, cascade_step, damping_current, write_current
from .cogging import switch_waves
from .commission import commission_abort, commission_start, commission_step
from .commission_state import PHASE_REST, Commission
from .commutation import lead_angle, set_commutation
from .current import current_clear, current_reset
from .drive_state import drive_disarm, drive_reset, drive_step
from .encoder import encoder_reset, encoder_step, watch_encoders
from .feed import bus_voltage, feed_bus, feed_voltages
from .homing import homing_start, homing_stop, homing_tick
from .layout import TORQUE_DAMP, TORQUE_DRIVE, TORQUE_OFF, CurrentLoop, JointIo, JointSettings, JointState
from .protection import protect_motion
from .thermal import gather_heat


@hot
def joint_reset(loop: CurrentLoop, settings: JointSettings, state: JointState, rotor: int) -> None:
    """Start a joint whose rotor reads ``rotor`` (0 .. 16383), not homed, not ready.

    ``state`` is zeros, fill_sine has filled its part of ``loop``.
    """
    current_reset(loop, rotor)
    set_commutation(loop, settings)
    encoder_reset(loop, settings, state)
    drive_reset(state)
    cascade_reset(settings, state)
    state.derate = 0x8000


@hot
def motion_tick(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one millisecond; return state.torque: TORQUE_OFF means that the bridge must be off."""
    state.time_ms = (state.time_ms + 1) & 0x3FFFFFFF
    state.limits = state.slow_limits
    _sense(loop, settings, state, io)
    protect_motion(loop, settings, state, io)
    before = state.mode
    drive_step(settings, state, io)
    if state.mode != before:
        _change_mode(loop, settings, state, commission, before)
    _act(loop, settings, state, io, commission)
    return state.torque


@hot
def begin_commission(state: JointState, commission: Commission, kind: int) -> int:
    """Choose the commissioning that arming for MODE_COMMISSIONING will run; return its kind, 0 if one is running."""
    if state.mode == MODE_COMMISSIONING:
        return 0
    commission_start(commission, kind)
    return kind


@hot
def _sense(loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo) -> None:
    encoder_step(loop, settings, state)
    watch_encoders(settings, state, io)
    state.bus = bus_voltage(io.bus_raw, settings.bus_gain)
    feed_bus(loop, settings, state.bus)
    gather_heat(loop, state)
    limit = settings.current_max * state.derate >> 15
    state.current_limit = limit
    loop.current_most = limit


@hot
def _change_mode(
    loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission, before: int
) -> None:
    """Leave the old mode cleanly and start the new one bumpless."""
    if before == MODE_COMMISSIONING:
        commission_abort(loop, settings, commission)
    if before == MODE_HOMING:
        homing_stop(state)
    cascade_reset(settings, state)
    if state.mode == MODE_HOMING:
        homing_start(state)


@hot
def _act(loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission) -> int:
    """Do what the mode wants: commission, home, follow the set-points or brake; return what feed_voltages returns."""
    if state.torque == TORQUE_DRIVE and state.mode == MODE_COMMISSIONING:
        return _commission(loop, settings, state, io, commission)
    waves = 0
    if state.torque == TORQUE_DRIVE:
        if state.mode == MODE_HOMING:
            homing_tick(settings, state)
        waves = 1
        cascade_step(settings, state, io)
    elif state.torque == TORQUE_DAMP:
        damping_current(settings, state)
    else:
        state.current_reference = 0
        current_clear(loop)
    switch_waves(loop, waves)
    write_current(loop, settings, state)
    lead_angle(loop, settings, state)
    return feed_voltages(loop, settings, state)


@hot
def _commission(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick of commissioning; when it is over, stand down, or raise its reason."""
    state.current_reference = 0
    kind = commission.kind
    running = commission_step(loop, settings, state, io, commission)
    if commission.phase <= PHASE_REST:  # idle, or at rest with the bridge off
        state.torque = TORQUE_OFF
        current_clear(loop)
    if running == 0:
        if kind != 0 and commission.reason != 0:
            state.raised = commission.reason
            state.raised_value = commission.reason_value
        drive_disarm(state)
    return running
