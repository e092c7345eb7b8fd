"""A joint's calls in their order: everything once, the motion tick a thousand times a second, the slow one ten times.

The fourth, the current step, is current.py. motion_tick may be interrupted by it at any place.
"""

from ..runtime import Ints, hot
from ..wire.names import MODE_CALIBRATING, MODE_HOMING
from .calibration import (
    Calibration,
    calibration_abort,
    calibration_needs_bridge,
    calibration_start,
    calibration_step,
    set_commutation,
)
from .cascade import cascade_reset, cascade_step, damping_current, write_current
from .current import current_relax, current_reset
from .drive_state import drive_disarm, drive_reset, drive_step
from .encoder import encoder_reset, encoder_step, watch_encoders
from .faults import FAULT_HOME_AMBIGUOUS, FAULT_HOME_NO_STOP
from .feed import bus_voltage, feed_bus, feed_voltages, lead_angle
from .homing import homing_start, homing_step, homing_stop
from .layout import (
    HOME_AMBIGUOUS,
    HOME_NO_STOP,
    HOME_SEEKING,
    TORQUE_DAMP,
    TORQUE_DRIVE,
    TORQUE_OFF,
    Foc,
    JointConfig,
    JointIo,
    JointState,
)
from .protection import gather_heat, protect_motion, protect_slow


@hot
def joint_reset(foc: Foc, cfg: JointConfig, state: JointState, rotor: int) -> int:
    """Start a joint whose rotor reads ``rotor`` (0 .. 16383), not homed, not ready; return 0.

    ``state`` is zeros, fill_sine has filled its part of ``foc``.
    """
    current_reset(foc, rotor)
    set_commutation(foc, cfg)
    encoder_reset(foc, cfg, state)
    drive_reset(state)
    cascade_reset(cfg, state)
    state.derate = 0x8000
    return 0


@hot
def motion_tick(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo, cal: Calibration) -> int:
    """Do one millisecond; return state.torque: TORQUE_OFF means that the bridge must be off."""
    state.time_ms = (state.time_ms + 1) & 0x3FFFFFFF
    state.limits = state.slow_limits
    _sense(foc, cfg, state, io)
    protect_motion(foc, cfg, state, io)
    before = state.mode
    drive_step(cfg, state, io)
    if state.mode != before:
        _change_mode(foc, cfg, state, cal, before)
    _act(foc, cfg, state, io, cal)
    return state.torque


@hot
def slow_tick(cfg: JointConfig, state: JointState, io: JointIo, curve: Ints) -> int:
    """Do what is due every 100 ms: temperatures, models, derating; return state.derate (Q15)."""
    return protect_slow(cfg, state, io, curve)


@hot
def begin_calibration(state: JointState, cal: Calibration, kind: int) -> int:
    """Choose the calibration that arming for MODE_CALIBRATING will run; return its kind, 0 if one is running."""
    if state.mode == MODE_CALIBRATING:
        return 0
    calibration_start(cal, kind)
    return kind


@hot
def _sense(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo) -> int:
    encoder_step(foc, cfg, state)
    watch_encoders(cfg, state, io)
    state.bus = bus_voltage(io.bus_raw, cfg.bus_gain)
    feed_bus(foc, cfg, state.bus)
    gather_heat(foc, state)
    limit = cfg.current_max * state.derate >> 15
    state.current_limit = limit
    return limit


@hot
def _change_mode(foc: Foc, cfg: JointConfig, state: JointState, cal: Calibration, before: int) -> int:
    """Leave the old mode cleanly and start the new one bumpless."""
    if before == MODE_CALIBRATING:
        calibration_abort(foc, cfg, cal)
    if before == MODE_HOMING:
        homing_stop(state)
    cascade_reset(cfg, state)
    if state.mode == MODE_HOMING:
        homing_start(state)
    return state.mode


@hot
def _act(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo, cal: Calibration) -> int:
    """Do what the mode wants: calibrate, home, follow the set-points or brake; return what feed_voltages does."""
    if state.torque == TORQUE_DRIVE and state.mode == MODE_CALIBRATING:
        return _calibrate(foc, cfg, state, io, cal)
    if state.torque == TORQUE_DRIVE:
        if state.mode == MODE_HOMING:
            _home(cfg, state)
        cascade_step(cfg, state, io)
    elif state.torque == TORQUE_DAMP:
        damping_current(cfg, state)
    else:
        state.current_reference = 0
        current_relax(foc)
    write_current(foc, cfg, state)
    lead_angle(foc, cfg, state)
    return feed_voltages(foc, cfg, state)


@hot
def _calibrate(foc: Foc, cfg: JointConfig, state: JointState, io: JointIo, cal: Calibration) -> int:
    """One tick of calibration; when it is over, stand down, or raise its reason."""
    state.current_reference = 0
    kind = cal.kind
    running = calibration_step(foc, cfg, state, io, cal)
    if calibration_needs_bridge(cal) == 0:
        state.torque = TORQUE_OFF
        current_relax(foc)
    if running == 0:
        if kind != 0 and cal.reason != 0:
            state.raised = cal.reason
            state.raised_value = cal.reason_value
        drive_disarm(state)
    return running


@hot
def _home(cfg: JointConfig, state: JointState) -> int:
    """One tick of homing; when it is over, stand down, or raise the reason."""
    homing_step(cfg, state)
    result = state.home_result
    if result == HOME_NO_STOP:
        state.raised = FAULT_HOME_NO_STOP
        state.raised_value = state.home_ticks
    if result == HOME_AMBIGUOUS:
        state.raised = FAULT_HOME_AMBIGUOUS
        state.raised_value = state.position
    if result != HOME_SEEKING:
        drive_disarm(state)
    return result
