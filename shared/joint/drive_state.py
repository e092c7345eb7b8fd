"""The drive's states in the words of CiA 402, faults that latch, arming, and the watchdog over set-points.

    not ready -> switch-on disabled -> ready -> switched on -> operation enabled
    operation enabled -> quick stop active -> switch-on disabled
    any -> fault reaction (damps) -> fault (coasts) -> switch-on disabled, by clearing only

Set-points act in operation enabled and nowhere else. Quick stop and fault reaction only damp. The
watchdog counts set-points and nothing else; nothing here writes one.
"""

from ..runtime import const, hot
from ..wire.names import (
    LIMIT_WATCHDOG,
    MODE_COMMISSIONING,
    MODE_DAMPING,
    MODE_HOMING,
    MODE_IMPEDANCE,
    MODE_OFF,
    MODE_POSITION,
    RESULT_FAR_FROM_SETPOINT,
    RESULT_FAULT_PRESENT,
    RESULT_NO_SESSION,
    RESULT_NO_SETPOINT,
    RESULT_NOT_COMMISSIONED,
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
from .layout import TORQUE_DAMP, TORQUE_DRIVE, TORQUE_OFF, JointIo, JointSettings, JointState
from .protection import report_cause

REQUEST_NONE = const(0)
REQUEST_ARM = const(1)
REQUEST_DISARM = const(2)
REQUEST_QUICK_STOP = const(3)
REQUEST_CLEAR = const(4)

_NEVER = const(0xFFFF)  # age when there was no set-point


@hot
def drive_reset(state: JointState) -> None:
    """Start not ready, without torque, request, fault or set-point."""
    state.drive_state = STATE_NOT_READY
    state.torque = TORQUE_OFF
    state.request = REQUEST_NONE
    state.purpose = MODE_OFF
    state.mode = MODE_OFF
    state.fault_code = FAULT_NONE
    state.fault_value = 0
    state.fault_tick = 0
    state.setpoint_age = _NEVER


@hot
def drive_arm(settings: JointSettings, state: JointState, io: JointIo, purpose: int) -> int:
    """Ask for operation enabled; return RESULT_OK, or RESULT_* with the first reason against it.

    purpose: MODE_OFF to follow set-points, MODE_COMMISSIONING or MODE_HOMING. Needs switch-on disabled, no
    cause of a fault, the protocol's hash and a session; to follow set-points also a commissioned and
    homed joint and a set-point not older than fresh_ticks, which in position and impedance mode
    lies within settings.near of the joint.
    """
    if state.drive_state == STATE_FAULT or state.drive_state == STATE_FAULT_REACTION or state.cause:
        return RESULT_FAULT_PRESENT
    if state.drive_state != STATE_SWITCH_ON_DISABLED or state.request != REQUEST_NONE:
        return RESULT_WRONG_STATE
    if io.hash_ok == 0:
        return RESULT_WRONG_HASH
    if io.session == 0:
        return RESULT_NO_SESSION
    reason = _purpose_result(settings, state, io, purpose)
    if reason == RESULT_OK:
        state.purpose = purpose
        state.request = REQUEST_ARM
    return reason


@hot
def drive_disarm(state: JointState) -> int:
    """Ask for the torque to end at once; refused only in a fault, which has none. Return RESULT_*."""
    if state.drive_state == STATE_FAULT or state.drive_state == STATE_FAULT_REACTION:
        return RESULT_FAULT_PRESENT
    state.request = REQUEST_DISARM
    return RESULT_OK


@hot
def drive_quick_stop(state: JointState) -> int:
    """Ask to damp to a stop and then coast; return RESULT_WRONG_STATE unless operation is enabled."""
    if state.drive_state != STATE_OPERATION_ENABLED:
        return RESULT_WRONG_STATE
    state.request = REQUEST_QUICK_STOP
    return RESULT_OK


@hot
def drive_clear(state: JointState) -> int:
    """Ask to leave the fault state; return RESULT_FAULT_PRESENT while its cause or another is still there.

    Never arms: after clearing, the joint is in switch-on disabled and every set-point is forgotten.
    """
    if state.drive_state != STATE_FAULT:
        return RESULT_WRONG_STATE
    if state.cause:
        return RESULT_FAULT_PRESENT
    state.request = REQUEST_CLEAR
    return RESULT_OK


@hot
def drive_step(settings: JointSettings, state: JointState, io: JointIo) -> None:
    """Do one tick of the states after the protections have set state.cause."""
    _age_setpoint(state, io)
    _watch_setpoints(settings, state)
    if state.drive_state == STATE_OPERATION_ENABLED and io.hardware_ready == 0:
        report_cause(state, FAULT_DRIVER_SETUP, 0)
    if _latches(state, io):
        _enter_fault(settings, state)
    request = state.request
    drive = state.drive_state
    if drive == STATE_FAULT_REACTION or drive == STATE_QUICK_STOP_ACTIVE:
        _react(settings, state)
    elif drive == STATE_FAULT:
        if request == REQUEST_CLEAR and state.cause == FAULT_NONE:
            _clear(state)
        state.request = REQUEST_NONE
    elif request == REQUEST_DISARM:
        _stand_down(state)
    elif drive == STATE_OPERATION_ENABLED:
        if request == REQUEST_QUICK_STOP:
            state.drive_state = STATE_QUICK_STOP_ACTIVE
            state.reaction_ticks = 0
        state.request = REQUEST_NONE
    else:
        _advance(state, io)
    _set_torque(state, io)


@hot
def _purpose_result(settings: JointSettings, state: JointState, io: JointIo, purpose: int) -> int:
    """Return whether the joint may drive for ``purpose``: RESULT_OK or what is missing."""
    if purpose == MODE_COMMISSIONING:
        return RESULT_OK
    if settings.commissioned == 0:
        return RESULT_NOT_COMMISSIONED
    if purpose == MODE_HOMING:
        return RESULT_OK
    if state.homed == 0:
        return RESULT_NOT_HOMED
    if state.setpoint_age > settings.fresh_ticks or io.mode < MODE_POSITION or io.mode > MODE_IMPEDANCE:
        return RESULT_NO_SETPOINT
    if io.mode == MODE_POSITION or io.mode == MODE_IMPEDANCE:
        away = position_from_wire(io.position, settings.gear_q8) - state.position
        if away > settings.near or away < -settings.near:
            return RESULT_FAR_FROM_SETPOINT
    return RESULT_OK


@hot
def _age_setpoint(state: JointState, io: JointIo) -> None:
    """Count ticks since io.sequence changed; nothing else feeds the watchdog."""
    if io.sequence != state.sequence:
        state.sequence = io.sequence
        state.setpoint_age = 0
    elif state.setpoint_age < _NEVER:
        state.setpoint_age += 1


@hot
def _watch_setpoints(settings: JointSettings, state: JointState) -> None:
    """Commissioning and homing take no set-points and end by themselves; everything else needs set-points."""
    if state.drive_state != STATE_OPERATION_ENABLED or state.purpose != MODE_OFF:
        return
    if state.setpoint_age <= settings.watchdog_ticks:
        return
    state.limits = state.limits | LIMIT_WATCHDOG
    report_cause(state, FAULT_WATCHDOG, state.setpoint_age)


@hot
def _latches(state: JointState, io: JointIo) -> int:
    """Return the cause that is a fault now, FAULT_NONE if there is none.

    While the hardware is not ready the supply may still rise and sensors are not read, so their causes are no faults
    yet. An emergency stop is one. So is what the application found wrong with the hardware, else the joint would never
    get ready, without saying why; but not the gate driver's own fault, which a missing supply causes as well.
    """
    if state.drive_state != STATE_NOT_READY or state.cause == FAULT_EMERGENCY_STOP:
        return state.cause
    if io.hardware_fault == FAULT_NONE or io.hardware_fault == FAULT_DRIVER:
        return FAULT_NONE
    state.cause = io.hardware_fault
    state.cause_value = io.hardware_value
    return state.cause


@hot
def _enter_fault(settings: JointSettings, state: JointState) -> None:
    """Latch the first cause; damp first if the joint was driving or damping and its sensing can be trusted."""
    drive = state.drive_state
    if drive == STATE_FAULT:
        return
    if drive != STATE_FAULT_REACTION:
        state.fault_code = state.cause
        state.fault_value = state.cause_value
        state.fault_tick = state.time_ms
        state.reaction_ticks = 0
    can_damp = damps_first(state.cause)
    if drive != STATE_OPERATION_ENABLED and drive != STATE_QUICK_STOP_ACTIVE and drive != STATE_FAULT_REACTION:
        can_damp = 0
    if state.purpose == MODE_COMMISSIONING:
        can_damp = 0
    if can_damp:
        state.drive_state = STATE_FAULT_REACTION
    else:
        state.drive_state = STATE_FAULT
    state.request = REQUEST_NONE


@hot
def _react(settings: JointSettings, state: JointState) -> None:
    """Damp for the set time; a quick stop also ends when the joint stands."""
    state.reaction_ticks += 1
    if state.drive_state == STATE_FAULT_REACTION:
        if state.reaction_ticks > settings.damp_ticks:
            state.drive_state = STATE_FAULT
        return
    rate = state.velocity
    if rate < 0:
        rate = -rate
    if rate < settings.stall_rate or state.reaction_ticks > settings.quick_ticks or state.request == REQUEST_DISARM:
        _stand_down(state)
    state.request = REQUEST_NONE


@hot
def _stand_down(state: JointState) -> None:
    """To switch-on disabled (not ready stays), and forget the set-points."""
    if state.drive_state != STATE_NOT_READY:
        state.drive_state = STATE_SWITCH_ON_DISABLED
    state.request = REQUEST_NONE
    state.purpose = MODE_OFF
    state.setpoint_age = _NEVER


@hot
def _clear(state: JointState) -> None:
    state.fault_code = FAULT_NONE
    state.fault_value = 0
    state.fault_tick = 0
    _stand_down(state)


@hot
def _advance(state: JointState, io: JointIo) -> None:
    """One state per tick towards operation enabled, as long as the hardware is ready."""
    drive = state.drive_state
    if io.hardware_ready == 0:
        _stand_down(state)
        state.drive_state = STATE_NOT_READY
    elif drive == STATE_NOT_READY:
        state.drive_state = STATE_SWITCH_ON_DISABLED
    elif drive == STATE_SWITCH_ON_DISABLED:
        if state.request == REQUEST_ARM:
            state.drive_state = STATE_READY
    elif drive == STATE_READY:
        state.drive_state = STATE_SWITCHED_ON
    elif drive == STATE_SWITCHED_ON:
        state.drive_state = STATE_OPERATION_ENABLED
        state.request = REQUEST_NONE


@hot
def _set_torque(state: JointState, io: JointIo) -> None:
    drive = state.drive_state
    state.torque = TORQUE_OFF
    state.mode = MODE_OFF
    if drive == STATE_OPERATION_ENABLED:
        state.torque = TORQUE_DRIVE
        state.mode = state.purpose
        if state.purpose == MODE_OFF and io.mode >= MODE_POSITION and io.mode <= MODE_IMPEDANCE:
            state.mode = io.mode
    elif drive == STATE_QUICK_STOP_ACTIVE or drive == STATE_FAULT_REACTION:
        state.torque = TORQUE_DAMP
        state.mode = MODE_DAMPING
