"""The drive's states in the words of CiA 402, faults that latch, arming, and the watchdog over set-points.

    not ready -> switch-on disabled -> ready -> switched on -> operation enabled
    operation enabled -> quick stop active -> switch-on disabled
    any -> fault reaction (damps) -> fault (coasts) -> switch-on disabled, by clearing only

Set-points act in operation enabled and nowhere else. Quick stop and fault reaction only damp. The
watchdog counts set-points and nothing else; nothing here writes one.
"""

from ..runtime import Ints, const, hot
from ..wire.names import (
    LIMIT_WATCHDOG,
    MODE_CALIBRATING,
    MODE_DAMPING,
    MODE_HOMING,
    MODE_IMPEDANCE,
    MODE_OFF,
    MODE_POSITION,
    RESULT_FAR_FROM_SETPOINT,
    RESULT_FAULT_PRESENT,
    RESULT_NO_SESSION,
    RESULT_NO_SETPOINT,
    RESULT_NOT_CALIBRATED,
    RESULT_NOT_HOMED,
    RESULT_OK,
    RESULT_WRONG_HASH,
    RESULT_WRONG_STATE,
    STATE_FAULT,
    STATE_FAULT_REACTION,
    STATE_NOT_READY,
    STATE_OPERATION_ENABLED,
    STATE_QUICK_STOP_ACTIVE,
    STATE_READY,
    STATE_SWITCH_ON_DISABLED,
    STATE_SWITCHED_ON,
)
from .cascade import position_from_wire
from .faults import FAULT_DRIVER, FAULT_DRIVER_SETUP, FAULT_EMERGENCY_STOP, FAULT_NONE, FAULT_WATCHDOG, damps_first
from .layout import (
    IO_HARDWARE_FAULT,
    IO_HARDWARE_READY,
    IO_HARDWARE_VALUE,
    IO_HASH_OK,
    IO_MODE,
    IO_POSITION,
    IO_SEQUENCE,
    IO_SESSION,
    K_CALIBRATED,
    K_DAMP_TICKS,
    K_FRESH_TICKS,
    K_GEAR_Q8,
    K_NEAR,
    K_QUICK_TICKS,
    K_STALL_RATE,
    K_WATCHDOG_TICKS,
    REQUEST_ARM,
    REQUEST_CLEAR,
    REQUEST_DISARM,
    REQUEST_NONE,
    REQUEST_QUICK_STOP,
    S_CAUSE,
    S_CAUSE_VALUE,
    S_DRIVE,
    S_FAULT_CODE,
    S_FAULT_TICK,
    S_FAULT_VALUE,
    S_HOMED,
    S_LIMITS,
    S_MODE,
    S_POSITION,
    S_PURPOSE,
    S_REACTION_TICKS,
    S_REQUEST,
    S_SEQUENCE,
    S_SETPOINT_AGE,
    S_TICK,
    S_TORQUE,
    S_VELOCITY,
    TORQUE_DAMP,
    TORQUE_DRIVE,
    TORQUE_OFF,
)
from .protection import report_cause

_NEVER = const(0xFFFF)  # age of a set-point there was not


@hot
def drive_reset(state: Ints) -> int:
    """Start not ready, without torque, request, fault or set-point; return STATE_NOT_READY."""
    state[S_DRIVE] = STATE_NOT_READY
    state[S_TORQUE] = TORQUE_OFF
    state[S_REQUEST] = REQUEST_NONE
    state[S_PURPOSE] = MODE_OFF
    state[S_MODE] = MODE_OFF
    state[S_FAULT_CODE] = FAULT_NONE
    state[S_FAULT_VALUE] = 0
    state[S_FAULT_TICK] = 0
    state[S_SETPOINT_AGE] = _NEVER
    return STATE_NOT_READY


@hot
def drive_arm(cfg, state: Ints, io: Ints, purpose: int) -> int:
    """Ask for operation enabled; return RESULT_OK, or RESULT_* with the first reason against it.

    purpose: MODE_OFF to follow set-points, MODE_CALIBRATING or MODE_HOMING. Needs switch-on disabled, no
    cause of a fault, the protocol's hash and a session; to follow set-points also a calibrated and
    homed joint and a set-point not older than K_FRESH_TICKS, which in position and impedance mode
    lies within K_NEAR of the joint.
    """
    if state[S_DRIVE] == STATE_FAULT or state[S_DRIVE] == STATE_FAULT_REACTION or state[S_CAUSE]:
        return RESULT_FAULT_PRESENT
    if state[S_DRIVE] != STATE_SWITCH_ON_DISABLED or state[S_REQUEST] != REQUEST_NONE:
        return RESULT_WRONG_STATE
    if io[IO_HASH_OK] == 0:
        return RESULT_WRONG_HASH
    if io[IO_SESSION] == 0:
        return RESULT_NO_SESSION
    reason = _purpose_result(cfg, state, io, purpose)
    if reason == RESULT_OK:
        state[S_PURPOSE] = purpose
        state[S_REQUEST] = REQUEST_ARM
    return reason


@hot
def drive_disarm(state: Ints) -> int:
    """Ask for the torque to end at once; refused only in a fault, which has none. Return RESULT_*."""
    if state[S_DRIVE] == STATE_FAULT or state[S_DRIVE] == STATE_FAULT_REACTION:
        return RESULT_FAULT_PRESENT
    state[S_REQUEST] = REQUEST_DISARM
    return RESULT_OK


@hot
def drive_quick_stop(state: Ints) -> int:
    """Ask to damp to a stop and then coast; return RESULT_WRONG_STATE unless operation is enabled."""
    if state[S_DRIVE] != STATE_OPERATION_ENABLED:
        return RESULT_WRONG_STATE
    state[S_REQUEST] = REQUEST_QUICK_STOP
    return RESULT_OK


@hot
def drive_clear(state: Ints) -> int:
    """Ask to leave the fault state; return RESULT_FAULT_PRESENT while its cause or another is still there.

    Never arms: after clearing, the joint is in switch-on disabled and every set-point is forgotten.
    """
    if state[S_DRIVE] != STATE_FAULT:
        return RESULT_WRONG_STATE
    if state[S_CAUSE]:
        return RESULT_FAULT_PRESENT
    state[S_REQUEST] = REQUEST_CLEAR
    return RESULT_OK


@hot
def drive_step(cfg, state: Ints, io: Ints) -> int:
    """Do one tick of the states after the protections have set S_CAUSE; return S_TORQUE."""
    _age_setpoint(state, io)
    _watch_setpoints(cfg, state)
    if state[S_DRIVE] == STATE_OPERATION_ENABLED and io[IO_HARDWARE_READY] == 0:
        report_cause(state, FAULT_DRIVER_SETUP, 0)
    if _latches(state, io):
        _enter_fault(cfg, state)
    request = state[S_REQUEST]
    drive = state[S_DRIVE]
    if drive == STATE_FAULT_REACTION or drive == STATE_QUICK_STOP_ACTIVE:
        _react(cfg, state)
    elif drive == STATE_FAULT:
        if request == REQUEST_CLEAR and state[S_CAUSE] == FAULT_NONE:
            _clear(state)
        state[S_REQUEST] = REQUEST_NONE
    elif request == REQUEST_DISARM:
        _stand_down(state)
    elif drive == STATE_OPERATION_ENABLED:
        if request == REQUEST_QUICK_STOP:
            state[S_DRIVE] = STATE_QUICK_STOP_ACTIVE
            state[S_REACTION_TICKS] = 0
        state[S_REQUEST] = REQUEST_NONE
    else:
        _climb(state, io)
    return _set_torque(state, io)


@hot
def _purpose_result(cfg: Ints, state: Ints, io: Ints, purpose: int) -> int:
    """Return whether the joint may drive for ``purpose``: RESULT_OK or what is missing."""
    if purpose == MODE_CALIBRATING:
        return RESULT_OK
    if cfg[K_CALIBRATED] == 0:
        return RESULT_NOT_CALIBRATED
    if purpose == MODE_HOMING:
        return RESULT_OK
    if state[S_HOMED] == 0:
        return RESULT_NOT_HOMED
    if state[S_SETPOINT_AGE] > cfg[K_FRESH_TICKS] or io[IO_MODE] < MODE_POSITION or io[IO_MODE] > MODE_IMPEDANCE:
        return RESULT_NO_SETPOINT
    if io[IO_MODE] == MODE_POSITION or io[IO_MODE] == MODE_IMPEDANCE:
        away = position_from_wire(io[IO_POSITION], cfg[K_GEAR_Q8]) - state[S_POSITION]
        if away > cfg[K_NEAR] or away < -cfg[K_NEAR]:
            return RESULT_FAR_FROM_SETPOINT
    return RESULT_OK


@hot
def _age_setpoint(state: Ints, io: Ints) -> int:
    """Count ticks since IO_SEQUENCE changed; nothing else feeds the watchdog."""
    if io[IO_SEQUENCE] != state[S_SEQUENCE]:
        state[S_SEQUENCE] = io[IO_SEQUENCE]
        state[S_SETPOINT_AGE] = 0
    elif state[S_SETPOINT_AGE] < _NEVER:
        state[S_SETPOINT_AGE] += 1
    return state[S_SETPOINT_AGE]


@hot
def _watch_setpoints(cfg: Ints, state: Ints) -> int:
    """Calibration and homing take no set-points and end by themselves; everything else needs them."""
    if state[S_DRIVE] != STATE_OPERATION_ENABLED or state[S_PURPOSE] != MODE_OFF:
        return 0
    if state[S_SETPOINT_AGE] <= cfg[K_WATCHDOG_TICKS]:
        return 0
    state[S_LIMITS] = state[S_LIMITS] | LIMIT_WATCHDOG
    return report_cause(state, FAULT_WATCHDOG, state[S_SETPOINT_AGE])


@hot
def _latches(state: Ints, io: Ints) -> int:
    """Return the cause that is a fault now, FAULT_NONE if there is none.

    Before the hardware is ready the supply may still rise and sensors are not read: what these say is none yet. An
    emergency stop is, and what the application found wrong with the hardware, which would keep it from ever getting
    ready without a word; but for the gate driver's own fault, which is that of a missing supply.
    """
    if state[S_DRIVE] != STATE_NOT_READY or state[S_CAUSE] == FAULT_EMERGENCY_STOP:
        return state[S_CAUSE]
    if io[IO_HARDWARE_FAULT] == FAULT_NONE or io[IO_HARDWARE_FAULT] == FAULT_DRIVER:
        return FAULT_NONE
    state[S_CAUSE] = io[IO_HARDWARE_FAULT]
    state[S_CAUSE_VALUE] = io[IO_HARDWARE_VALUE]
    return state[S_CAUSE]


@hot
def _enter_fault(cfg, state: Ints) -> int:
    """Latch the first cause; damp first if the joint was driving or damping and its sensing can be trusted."""
    drive = state[S_DRIVE]
    if drive == STATE_FAULT:
        return drive
    if drive != STATE_FAULT_REACTION:
        state[S_FAULT_CODE] = state[S_CAUSE]
        state[S_FAULT_VALUE] = state[S_CAUSE_VALUE]
        state[S_FAULT_TICK] = state[S_TICK]
        state[S_REACTION_TICKS] = 0
    can_damp = damps_first(state[S_CAUSE])
    if drive != STATE_OPERATION_ENABLED and drive != STATE_QUICK_STOP_ACTIVE and drive != STATE_FAULT_REACTION:
        can_damp = 0
    if state[S_PURPOSE] == MODE_CALIBRATING:
        can_damp = 0
    if can_damp:
        state[S_DRIVE] = STATE_FAULT_REACTION
    else:
        state[S_DRIVE] = STATE_FAULT
    state[S_REQUEST] = REQUEST_NONE
    return state[S_DRIVE]


@hot
def _react(cfg: Ints, state: Ints) -> int:
    """Damp for the set time; a quick stop also ends when the joint stands."""
    state[S_REACTION_TICKS] += 1
    if state[S_DRIVE] == STATE_FAULT_REACTION:
        if state[S_REACTION_TICKS] > cfg[K_DAMP_TICKS]:
            state[S_DRIVE] = STATE_FAULT
        return state[S_DRIVE]
    rate = state[S_VELOCITY]
    if rate < 0:
        rate = -rate
    if rate < cfg[K_STALL_RATE] or state[S_REACTION_TICKS] > cfg[K_QUICK_TICKS] or state[S_REQUEST] == REQUEST_DISARM:
        _stand_down(state)
    state[S_REQUEST] = REQUEST_NONE
    return state[S_DRIVE]


@hot
def _stand_down(state: Ints) -> int:
    """To switch-on disabled (not ready stays), and forget the set-points."""
    if state[S_DRIVE] != STATE_NOT_READY:
        state[S_DRIVE] = STATE_SWITCH_ON_DISABLED
    state[S_REQUEST] = REQUEST_NONE
    state[S_PURPOSE] = MODE_OFF
    state[S_SETPOINT_AGE] = _NEVER
    return state[S_DRIVE]


@hot
def _clear(state: Ints) -> int:
    state[S_FAULT_CODE] = FAULT_NONE
    state[S_FAULT_VALUE] = 0
    state[S_FAULT_TICK] = 0
    return _stand_down(state)


@hot
def _climb(state: Ints, io: Ints) -> int:
    """One state per tick towards operation enabled, as long as the hardware is ready."""
    drive = state[S_DRIVE]
    if io[IO_HARDWARE_READY] == 0:
        _stand_down(state)
        state[S_DRIVE] = STATE_NOT_READY
    elif drive == STATE_NOT_READY:
        state[S_DRIVE] = STATE_SWITCH_ON_DISABLED
    elif drive == STATE_SWITCH_ON_DISABLED:
        if state[S_REQUEST] == REQUEST_ARM:
            state[S_DRIVE] = STATE_READY
    elif drive == STATE_READY:
        state[S_DRIVE] = STATE_SWITCHED_ON
    elif drive == STATE_SWITCHED_ON:
        state[S_DRIVE] = STATE_OPERATION_ENABLED
        state[S_REQUEST] = REQUEST_NONE
    return state[S_DRIVE]


@hot
def _set_torque(state: Ints, io: Ints) -> int:
    drive = state[S_DRIVE]
    state[S_TORQUE] = TORQUE_OFF
    state[S_MODE] = MODE_OFF
    if drive == STATE_OPERATION_ENABLED:
        state[S_TORQUE] = TORQUE_DRIVE
        state[S_MODE] = state[S_PURPOSE]
        if state[S_PURPOSE] == MODE_OFF and io[IO_MODE] >= MODE_POSITION and io[IO_MODE] <= MODE_IMPEDANCE:
            state[S_MODE] = io[IO_MODE]
    elif drive == STATE_QUICK_STOP_ACTIVE or drive == STATE_FAULT_REACTION:
        state[S_TORQUE] = TORQUE_DAMP
        state[S_MODE] = MODE_DAMPING
    return state[S_TORQUE]
