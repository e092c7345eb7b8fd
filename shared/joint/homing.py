"""Homing a joint without an absolute encoder: drive slowly against the stop, then take the stop's known position.

Tick by tick in mode HOMING. It only asks for a rate and lowers the current limit; the cascade does
the rest. The rotor's angle at the stop must fit the stop's position, or homing is refused as ambiguous.
"""

from ..runtime import const, hot
from .drive_state import drive_disarm
from .encoder import home_at
from .faults import FAULT_HOME_AMBIGUOUS, FAULT_HOME_NO_STOP
from .layout import JointSettings, JointState

HOME_IDLE = const(0)
HOME_SEEKING = const(1)
HOME_DONE = const(2)
HOME_NO_STOP = const(3)
HOME_AMBIGUOUS = const(4)


@hot
def homing_start(state: JointState) -> None:
    """Begin to look for the stop: the joint counts as not homed from now on."""
    state.homed = 0
    state.home_ticks = 0
    state.home_still_ticks = 0
    state.home_result = HOME_SEEKING


@hot
def homing_stop(state: JointState) -> None:
    """Give up looking (torque is gone or the mode changed): a search under way ends as HOME_IDLE."""
    if state.home_result == HOME_SEEKING:
        state.home_result = HOME_IDLE


@hot
def homing_tick(settings: JointSettings, state: JointState) -> None:
    """Do one tick before the cascade's; when homing is over, stand down, or raise the reason of its failure."""
    homing_step(settings, state)
    result = state.home_result
    if result == HOME_NO_STOP:
        state.raised = FAULT_HOME_NO_STOP
        state.raised_value = state.home_ticks
    if result == HOME_AMBIGUOUS:
        state.raised = FAULT_HOME_AMBIGUOUS
        state.raised_value = state.position
    if result != HOME_SEEKING:
        drive_disarm(state)


@hot
def homing_step(settings: JointSettings, state: JointState) -> None:
    """Watch for the stop before each tick of the cascade; home_rate is the rate to ask for, 0 when homing is over.

    At the stop: slower than stall_rate with 3/4 of home_current for home_ticks. Then home_result is HOME_DONE or
    HOME_AMBIGUOUS; without a stop in home_limit_ticks it is HOME_NO_STOP.
    """
    state.home_rate = 0
    if state.home_result != HOME_SEEKING:
        return
    if state.current_limit > settings.home_current:
        state.current_limit = settings.home_current
    state.home_ticks += 1
    if state.home_ticks > settings.home_limit_ticks:
        state.home_result = HOME_NO_STOP
        return
    state.home_still_ticks += 1
    if _pushes_at_rest(settings, state) == 0:
        state.home_still_ticks = 0
    if state.home_still_ticks < settings.home_ticks:
        state.home_rate = settings.home_rate
        return
    state.home_result = HOME_AMBIGUOUS
    if home_at(settings, state, settings.stop):
        state.home_result = HOME_DONE


@hot
def _pushes_at_rest(settings: JointSettings, state: JointState) -> int:
    rate = state.velocity
    if rate > settings.stall_rate or rate < -settings.stall_rate:
        return 0
    push = state.current_reference
    if settings.home_rate < 0:
        push = -push
    if push < settings.home_current - (settings.home_current >> 2):
        return 0
    return 1
