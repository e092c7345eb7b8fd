"""Which legs swing: diagonals half a cycle apart, each in stance for a bit more than half of the cycle.

A robot that is pushed steps sooner. A tipping body falls faster and faster; if it waited for the usual touchdown, the
feet in the air would strike the ground and the body go over them. So swings go on faster, and feet that have just begun
to swing come down again at once, except in high swings, which an edge needs.
"""

from ..body.params import LEGS, Params
from ..runtime import const, hot
from .feet import lift_off
from .react import check_landing, count_held_up, react
from .state import CYCLE_Q20, Trot

_DIAGONALS = const(0x06)  # bits of the legs that are half a cycle on: FL, RR
_MIDDLE = const(16383)  # middle of a swing, Q15
_STILL_MAX = const(0x200000)


@hot
def advance_legs(params: Params, trot: Trot, still: int) -> None:
    """Advance the cycle by one tick: which legs stand, which swing, which met something.

    ``still`` 1: the command is to stand. While ``command.moving`` is 0 all legs stand, the phase midway between two
    swings.
    """
    state = trot.state
    setup = params.trot
    if trot.command.moving == 0:
        state.phase_q20 = (setup.stance_q20 >> 1) - (CYCLE_Q20 >> 2)
        state.still_q20 = 0
        stand_all(trot)
        return
    advance_phase(params, trot, still)
    stance = trot.stance
    swinging = 0
    standing = 0
    for leg in range(LEGS):
        leg_phase = state.phase_q20
        if _DIAGONALS >> leg & 1:
            leg_phase = leg_phase + (CYCLE_Q20 >> 1) & CYCLE_Q20 - 1
        leg_phase -= setup.stance_q20
        if leg_phase < 0:
            stance[leg] = 1
            if leg_phase + setup.stance_q20 > setup.landing_q20:
                trot.early_contact[leg] = 0
            else:
                check_landing(params, trot, leg)
        else:
            share = (leg_phase >> 5) * setup.swing_rate_q13 >> 13
            if share > 32767:
                share = 32767
            state.swing_q15 = share
            if trot.early_contact[leg] == 0:
                if stance[leg]:
                    count_held_up(params, trot, leg)
                    lift_off(trot, leg)
                    stance[leg] = 0
                stance[leg] = react(params, trot, leg)
        if stance[leg]:
            standing += 1
        else:
            swinging |= 1 << leg
    state.swinging = swinging
    state.standing = standing


@hot
def advance_phase(params: Params, trot: Trot, still: int) -> None:
    """Advance the phase by one tick, and count for how long the command has been to stand (``still`` 1)."""
    state = trot.state
    step = params.trot.phase_step_q20
    if state.pushed and state.swinging:
        step = hurried_step(params, trot)
    elif state.careful > 0 and state.swinging == 0:
        step = params.trot.careful_step_q20
    state.phase_q20 = state.phase_q20 + step & CYCLE_Q20 - 1
    if still == 0:
        state.still_q20 = 0
    elif state.still_q20 < _STILL_MAX:
        state.still_q20 += step


@hot
def hurried_step(params: Params, trot: Trot) -> int:
    """Return by how much the phase advances in a tick of a swing while the robot is pushed, Q20.

    In the first tick of a push, the phase jumps from before the middle of a swing to as long after it: there the feet
    are as high, and on their way down. Error at most 48. Intermediates: 2^15 * 2^14.
    """
    setup = params.trot
    share = trot.state.swing_q15
    if trot.state.pushed == 2 or share > _MIDDLE:
        return setup.hurried_step_q20
    return setup.hurried_step_q20 + ((32767 - 2 * share) * (CYCLE_Q20 - setup.stance_q20 >> 5) >> 10)


@hot
def stand_all(trot: Trot) -> None:
    """Put all legs into stance."""
    for leg in range(LEGS):
        trot.stance[leg] = 1
        trot.early_contact[leg] = 0
    trot.state.swinging = 0
    trot.state.standing = LEGS
