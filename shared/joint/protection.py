"""Checks that end the torque: supply, current, speed, position, stall, encoders, temperatures. They set state.cause.

Each check runs in every state, so that a cause that is still there also refuses clearing and arming. Limits that only
act (derating) set LIMIT_* bits; a cause found here is a fault.
"""

from ..num.fixed import isqrt, saturate
from ..runtime import const, hot
from ..wire.names import LIMIT_STALL, LIMIT_VOLTAGE, MODE_COMMISSIONING, MODE_POSITION, MODE_VELOCITY
from .current import current_sum
from .encoder import encoder_resync
from .faults import (
    FAULT_CURRENT_SENSE,
    FAULT_EMERGENCY_STOP,
    FAULT_ENCODER_DISAGREE,
    FAULT_ENCODER_LOST,
    FAULT_NONE,
    FAULT_OVER_CURRENT,
    FAULT_OVER_SPEED,
    FAULT_OVER_VOLTAGE,
    FAULT_POSITION_LIMIT,
    FAULT_POSITION_RANGE,
    FAULT_STALL,
    FAULT_UNDER_VOLTAGE,
    damps_first,
)
from .layout import TORQUE_DRIVE, TORQUE_OFF, CurrentLoop, JointIo, JointSettings, JointState

_TICKS_MOST = const(0xFFFF)


@hot
def report_cause(state: JointState, code: int, value: int) -> None:
    """Note a cause with its value.

    The first stays, except that one which allows damping gives way to one which does not.
    """
    if state.cause == FAULT_NONE or (damps_first(state.cause) and damps_first(code) == 0):
        state.cause = code
        state.cause_value = value


@hot
def protect_motion(loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo) -> None:
    """Look for causes once a millisecond, the most dangerous first.

    Times: over-current and emergency stop 1 tick, voltages bus_ticks, a lost encoder bad_ticks,
    disagreement disagree_ticks, current sum sum_ticks, stall stall_ticks.
    """
    state.cause = FAULT_NONE
    state.cause_value = 0
    if io.e_stop:
        report_cause(state, FAULT_EMERGENCY_STOP, 0)
    if io.hardware_fault:
        report_cause(state, io.hardware_fault, io.hardware_value)
    _check_current(loop, settings, state)
    _check_encoders(loop, settings, state)
    _check_bus(settings, state)
    _check_motion(settings, state)
    _check_stall(settings, state)
    if state.slow_cause:
        report_cause(state, state.slow_cause, state.slow_value)
    if state.raised:
        report_cause(state, state.raised, state.raised_value)
        state.raised = FAULT_NONE


@hot
def count_above(ticks: int, value: int, limit: int) -> int:
    """Return ticks + 1, 65535 at most, while ``value`` is above ``limit``; else 0."""
    if value <= limit:
        return 0
    return saturate(ticks + 1, 0, _TICKS_MOST)


@hot
def _check_current(loop: CurrentLoop, settings: JointSettings, state: JointState) -> None:
    """Check trip, voltage limit and sum of the phases; the sum only under torque, and not while commissioning."""
    if loop.tripped:
        length = isqrt(loop.current_d * loop.current_d + loop.current_q * loop.current_q)
        report_cause(state, FAULT_OVER_CURRENT, length)
        loop.tripped = 0
    if loop.limited_steps:
        state.limits = state.limits | LIMIT_VOLTAGE
        loop.limited_steps = 0
    wrong = current_sum(loop)
    size = wrong
    if size < 0:
        size = -size
    if loop.masked:
        size = 0
    state.sum_ticks = count_above(state.sum_ticks, size, settings.sum_limit)
    if state.sum_ticks >= settings.sum_ticks and state.torque != TORQUE_OFF and state.mode != MODE_COMMISSIONING:
        report_cause(state, FAULT_CURRENT_SENSE, wrong)


@hot
def _check_encoders(loop: CurrentLoop, settings: JointSettings, state: JointState) -> None:
    """After any fault of an encoder the position is not trusted: the joint must be homed again."""
    glitches = loop.glitches
    loop.glitches = 0
    if glitches >= settings.glitch_steps:
        state.bad_ticks = saturate(state.bad_ticks + 1, 0, _TICKS_MOST)
    elif state.bad_ticks > 0:
        state.bad_ticks -= 1
    if state.range_exceeded and state.homed:
        report_cause(state, FAULT_POSITION_RANGE, state.turns)
        state.homed = 0
    if state.disagree_ticks >= settings.disagree_ticks:
        report_cause(state, FAULT_ENCODER_DISAGREE, state.joint_error)
        state.homed = 0
    if state.bad_ticks >= settings.bad_ticks:
        report_cause(state, FAULT_ENCODER_LOST, glitches)
        state.homed = 0
        if state.torque == TORQUE_OFF:
            encoder_resync(loop, state)


@hot
def _check_bus(settings: JointSettings, state: JointState) -> None:
    bus = state.bus
    state.under_ticks = count_above(state.under_ticks, settings.under, bus)
    if state.under_ticks >= settings.bus_ticks:
        report_cause(state, FAULT_UNDER_VOLTAGE, bus)
    state.over_ticks = count_above(state.over_ticks, bus, settings.over)
    if state.over_ticks >= settings.bus_ticks:
        report_cause(state, FAULT_OVER_VOLTAGE, bus)


@hot
def _check_motion(settings: JointSettings, state: JointState) -> None:
    """Over-speed in any state; beyond the hard position limit only when driving further out."""
    rate = state.velocity
    if rate > settings.rate_trip or rate < -settings.rate_trip:
        report_cause(state, FAULT_OVER_SPEED, rate)
    if state.torque != TORQUE_DRIVE or state.homed == 0:
        return
    position = state.position
    if rate > 0 and position > settings.position_max + settings.position_margin:
        report_cause(state, FAULT_POSITION_LIMIT, position)
    if rate < 0 and position < settings.position_min - settings.position_margin:
        report_cause(state, FAULT_POSITION_LIMIT, position)


@hot
def _check_stall(settings: JointSettings, state: JointState) -> None:
    """A joint stalls if it is asked to move, uses all the current there is, and stands. Holding a load is no stall."""
    slow = settings.stall_rate
    asked = state.rate_reference
    if asked < 0:
        asked = -asked
    rate = state.velocity
    push = state.current_reference
    if push < 0:
        push = -push
    if rate < 0:
        rate = -rate
    stalled = 0
    if state.mode == MODE_POSITION or state.mode == MODE_VELOCITY:
        stalled = 1
    if asked <= slow + slow or rate >= slow or push < state.current_limit or state.torque != TORQUE_DRIVE:
        stalled = 0
    if stalled:
        state.limits = state.limits | LIMIT_STALL
    state.stall_ticks = count_above(state.stall_ticks, stalled, 0)
    if state.stall_ticks >= settings.stall_ticks:
        report_cause(state, FAULT_STALL, state.current_reference)
