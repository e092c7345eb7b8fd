"""The body over the planned feet: balance added to the commanded pose, then the four legs solved for it."""

from ..body.balance import balance_release, balance_step
from ..body.compliance import sag_leg
from ..body.leg import leg_inverse, limit_joints
from ..body.params import LEGS
from ..body.pose import POSE_PITCH, POSE_ROLL, POSE_SIZE, body_rotation, body_to_hip
from ..body.reach import TOO_NEAR, reach_foot
from ..num.fixed import saturate
from ..runtime import Ints, hot
from ..sense.sensed import Sensed
from ..trot.trot import pose_body, raise_body, share_weight
from .command import Command
from .handover import fade_out
from .state import PlannerState
from .status import NO_ATTITUDE


@hot
def pose_legs(planner: PlannerState, command: Command, sensed: Sensed, own: int) -> int:
    """Put the body over the planned feet and solve the legs into ``planner.goal``; return their flags.

    own: 1 for the trot's stance (higher, ahead, sag fed forward), 0 to go back to the rest stance.
    """
    status = planner.status
    level(planner, command, sensed)
    active = raise_body(planner.params, planner.walk, own)
    status.margin = share_weight(planner.params, planner.walk, planner.reached, status.swinging, own)
    if active:
        correction = planner.balance.correction
        pose_body(planner.params, planner.walk, correction.roll, correction.pitch, planner.posed)
    flags = solve_legs(planner, planner.goal)
    status.flags |= flags
    fade = planner.fade
    if fade.left:
        fade_out(planner.fade, planner.goal)
        for leg in range(LEGS):
            limit_joints(planner.params, leg, planner.goal)
    return flags


@hot
def level(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Add balance to the slewed body pose; return 0. NO_ATTITUDE if it was asked for in vain."""
    valid = sensed.valid
    tilt = sensed.tilt
    status = planner.status
    params = planner.params
    pose = planner.pose
    posed = planner.posed
    correction = planner.balance.correction
    if command.balance and valid.tilt:
        roll = saturate(tilt[0], -32768, 32767)
        pitch = saturate(tilt[1], -32768, 32767)
        balance_step(planner.balance, planner.pose, roll, pitch)
    else:
        balance_release(planner.balance, params.pose_slew[POSE_ROLL])
        if command.balance:
            status.flags |= NO_ATTITUDE
    for axis in range(POSE_SIZE):
        posed[axis] = pose[axis]
    posed[POSE_ROLL] += correction.roll
    posed[POSE_PITCH] += correction.pitch
    return 0


@hot
def solve_legs(planner: PlannerState, joints: Ints) -> int:
    """Solve all four legs for the planned feet and body pose into ``joints``; return the flags together.

    A foot that would pass close by its hip, or over it, stays clear below: it would swing the whole leg round in a
    tick or two. ``status.beyond`` is set where a standing leg has flags.
    """
    status = planner.status
    hip_feet = planner.hip_feet
    params = planner.params
    leg_flags = planner.leg_flags
    load = planner.load
    trot = planner.trot
    body_rotation(planner.posed, planner.rotation)
    status.beyond = 0
    together = 0
    farthest = 0
    for leg in range(LEGS):
        body_to_hip(planner.params, leg, planner.posed, planner.rotation, planner.feet, planner.hip_feet)
        flags = 0
        highest = params.legs[leg].clearance
        if hip_feet[leg * 3 + 2] > highest:
            hip_feet[leg * 3 + 2] = highest
            flags = TOO_NEAR
        flags |= reach_foot(planner.params, leg, planner.hip_feet, planner.reached)
        far = leg_inverse(planner.params, leg, planner.reached, joints)
        if far > farthest:
            farthest = far
        if load.force_q12[leg]:
            sag_leg(planner.params, leg, planner.reached, 0, 0, load.force_q12[leg], joints)
        flags |= limit_joints(planner.params, leg, joints)
        leg_flags[leg] = flags
        together |= flags
        if flags and status.swinging >> leg & 1 == 0:
            status.beyond = 1
    trot.far = farthest
    return together
