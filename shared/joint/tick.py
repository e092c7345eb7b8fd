"""A joint's calls in their order: everything once, the motion tick a thousand times a second, the slow one ten times.

The fourth, the current step, is current.py. motion_tick may be interrupted by it at any place.
"""

from ..runtime import Ints, hot
from ..wire.names import MODE_CALIBRATING, MODE_HOMING
from .calibration import (
    C_KIND,
    C_REASON,
    C_VALUE,
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
    IO_BUS_RAW,
    K_BUS_GAIN,
    K_CURRENT_MAX,
    S_BUS,
    S_CURRENT_LIMIT,
    S_CURRENT_REF,
    S_DERATE,
    S_HOME_RESULT,
    S_HOME_TICKS,
    S_LIMITS,
    S_MODE,
    S_POSITION,
    S_RAISED,
    S_RAISED_VALUE,
    S_SLOW_LIMITS,
    S_TICK,
    S_TORQUE,
    TORQUE_DAMP,
    TORQUE_DRIVE,
    TORQUE_OFF,
)
from .protection import gather_heat, protect_motion, protect_slow


@hot
def joint_reset(foc, cfg, state: Ints, rotor: int) -> int:
    """Start a joint whose rotor reads ``rotor`` (0 .. 16383), not homed, not ready; return 0.

    ``state`` is zeros, fill_sine has filled its part of ``foc``.
    """
    current_reset(foc, rotor)
    set_commutation(foc, cfg)
    encoder_reset(foc, cfg, state)
    drive_reset(state)
    cascade_reset(cfg, state)
    state[S_DERATE] = 0x8000
    return 0


@hot
def motion_tick(foc, cfg, state: Ints, io, cal) -> int:
    """Do one millisecond; return S_TORQUE: TORQUE_OFF means that the bridge must be off."""
    state[S_TICK] = (state[S_TICK] + 1) & 0x3FFFFFFF
    state[S_LIMITS] = state[S_SLOW_LIMITS]
    _sense(foc, cfg, state, io)
    protect_motion(foc, cfg, state, io)
    before = state[S_MODE]
    drive_step(cfg, state, io)
    if state[S_MODE] != before:
        _change_mode(foc, cfg, state, cal, before)
    _act(foc, cfg, state, io, cal)
    return state[S_TORQUE]


@hot
def slow_tick(cfg, state, io, curve) -> int:
    """Do what is due every 100 ms: temperatures, models, derating; return S_DERATE (Q15)."""
    return protect_slow(cfg, state, io, curve)


@hot
def begin_calibration(state: Ints, cal, kind: int) -> int:
    """Choose the calibration that arming for MODE_CALIBRATING will run; return its kind, 0 if one is running."""
    if state[S_MODE] == MODE_CALIBRATING:
        return 0
    calibration_start(cal, kind)
    return kind


@hot
def _sense(foc, cfg: Ints, state: Ints, io: Ints) -> int:
    encoder_step(foc, cfg, state)
    watch_encoders(cfg, state, io)
    state[S_BUS] = bus_voltage(io[IO_BUS_RAW], cfg[K_BUS_GAIN])
    feed_bus(foc, cfg, state[S_BUS])
    gather_heat(foc, state)
    limit = cfg[K_CURRENT_MAX] * state[S_DERATE] >> 15
    state[S_CURRENT_LIMIT] = limit
    return limit


@hot
def _change_mode(foc, cfg, state: Ints, cal, before: int) -> int:
    """Leave the old mode cleanly and start the new one bumpless."""
    if before == MODE_CALIBRATING:
        calibration_abort(foc, cfg, cal)
    if before == MODE_HOMING:
        homing_stop(state)
    cascade_reset(cfg, state)
    if state[S_MODE] == MODE_HOMING:
        homing_start(state)
    return state[S_MODE]


@hot
def _act(foc, cfg, state: Ints, io, cal) -> int:
    """Do what the mode wants: calibrate, home, follow the set-points or brake; return what feed_voltages does."""
    if state[S_TORQUE] == TORQUE_DRIVE and state[S_MODE] == MODE_CALIBRATING:
        return _calibrate(foc, cfg, state, io, cal)
    if state[S_TORQUE] == TORQUE_DRIVE:
        if state[S_MODE] == MODE_HOMING:
            _home(cfg, state)
        cascade_step(cfg, state, io)
    elif state[S_TORQUE] == TORQUE_DAMP:
        damping_current(cfg, state)
    else:
        state[S_CURRENT_REF] = 0
        current_relax(foc)
    write_current(foc, cfg, state)
    lead_angle(foc, cfg, state)
    return feed_voltages(foc, cfg, state)


@hot
def _calibrate(foc, cfg, state: Ints, io, cal: Ints) -> int:
    """One tick of calibration; when it is over, stand down, or raise its reason."""
    state[S_CURRENT_REF] = 0
    kind = cal[C_KIND]
    running = calibration_step(foc, cfg, state, io, cal)
    if calibration_needs_bridge(cal) == 0:
        state[S_TORQUE] = TORQUE_OFF
        current_relax(foc)
    if running == 0:
        if kind != 0 and cal[C_REASON] != 0:
            state[S_RAISED] = cal[C_REASON]
            state[S_RAISED_VALUE] = cal[C_VALUE]
        drive_disarm(state)
    return running


@hot
def _home(cfg, state: Ints) -> int:
    """One tick of homing; when it is over, stand down, or raise the reason."""
    homing_step(cfg, state)
    result = state[S_HOME_RESULT]
    if result == HOME_NO_STOP:
        state[S_RAISED] = FAULT_HOME_NO_STOP
        state[S_RAISED_VALUE] = state[S_HOME_TICKS]
    if result == HOME_AMBIGUOUS:
        state[S_RAISED] = FAULT_HOME_AMBIGUOUS
        state[S_RAISED_VALUE] = state[S_POSITION]
    if result != HOME_SEEKING:
        drive_disarm(state)
    return result
