"""Commissioning: from an unknown motor in a leg to control loops that fit it, tick by tick, in integers.

    at rest, bridge off: offsets, noise, supply (resting.py)
    -> a voltage along one direction: R, L, gains of the current loop (winding.py), and their proof (proving.py)
    -> a field turns the rotor round, back, round again: direction, pole pairs, offset, eccentricity (turning.py)
    -> the rotor swings to and fro by itself: flux linkage, and the offset anew (spinning.py)
    -> the same gently: inertia, friction, gains of the outer loops (swinging.py, outer.py)
    -> it creeps, held by a field: cogging and the gear's play (waves.py, play.py)
    -> it runs, with steps of its speed: proof of the velocity and the position loop (proving.py)
    -> the results are written (findings.py)

Each part checks what it relies on; if that fails, commissioning ends with a reason, FAULT_COMMISSION_*. The results are
written only when all are found. The current never exceeds the trip level, the rotor stays within the turn that the
field took it round, and whatever ends the torque ends commissioning (commission_abort). Verifying takes the winding's
first phases and half an electrical turn to and fro, 1.2 deg at a 22:1 joint with 7 pole pairs; direction and offset are
compared, not changed.
"""

from ..num.fixed import wrap_brad
from ..runtime import hot
from .bend import set_bend
from .cogging import set_waves, switch_waves
from .commission_state import (
    COMMISSION_FULL,
    PHASE_FORWARD,
    PHASE_IDLE,
    PHASE_PROVE_CURRENT,
    PHASE_PROVE_VELOCITY,
    PHASE_REST,
    PHASE_SPIN,
    PHASE_SWING,
    Commission,
    begin_phase,
    fail,
)
from .commutation import set_commutation
from .faults import FAULT_COMMISSION_OFFSET_CHANGED, FAULT_NONE
from .findings import write_findings
from .layout import CurrentLoop, JointIo, JointSettings, JointState
from .outer import restore_outer
from .proving import prove_begin, prove_current, prove_step
from .resting import rest_step
from .spinning import spin_begin, spin_step
from .swinging import mechanics_begin, mechanics_step
from .turning import turn_step
from .waves import creep_begin, creep_step
from .winding import winding_step


@hot
def commission_start(commission: Commission, kind: int) -> None:
    """Begin commissioning of ``kind`` with the next tick. The caller sets pose_given and pose."""
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
    begin_phase(commission, PHASE_REST)


@hot
def commission_abort(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> None:
    """End commissioning: restore gains, commutation and references."""
    if commission.final_kp:
        loop.kp = commission.final_kp
        loop.ki = commission.final_ki
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
    switch_waves(loop, 0)
    set_waves(loop, settings)
    set_commutation(loop, settings)


@hot
def commission_step(
    loop: CurrentLoop, settings: JointSettings, state: JointState, io: JointIo, commission: Commission
) -> int:
    """Do one tick; return the phase, PHASE_IDLE when over. ``reason`` is then 0 or why commissioning failed.

    A full commissioning takes 31 to 55 s (200 simulated motors, docs/joint.md), a verification 5 s.
    """
    phase = commission.phase
    if phase == PHASE_IDLE:
        return PHASE_IDLE
    commission.phase_ticks += 1
    if phase == PHASE_REST:
        rest_step(loop, settings, state, io, commission)
    elif phase < PHASE_PROVE_CURRENT:
        winding_step(loop, settings, commission)
    elif phase == PHASE_PROVE_CURRENT:
        if prove_current(loop, settings, commission):
            begin_phase(commission, PHASE_FORWARD)
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
        write_findings(loop, settings, state, commission)
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
        return fail(commission, FAULT_COMMISSION_OFFSET_CHANGED, change)
    return begin_phase(commission, PHASE_IDLE)
