"""The body over the planned feet: balance added to the commanded pose, then the four legs solved for it."""

from ..body.balance import balance_release, balance_step
from ..body.leg import leg_inverse, limit_joints
from ..body.params import LEGS
from ..body.pose import POSE_PITCH, POSE_ROLL, POSE_SIZE, body_rotation, body_to_hip
from ..body.reach import TOO_NEAR, reach_foot
from ..body.stability import support_margin
from ..num.fixed import saturate
from ..runtime import Ints, hot
from ..sense.sensed import Sensed
from .command import Command
from .handover import fade_out
from .state import PlannerState
from .status import NO_ATTITUDE


@hot
def pose_legs(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Put the body over the planned feet and solve the legs into ``planner.goal``; return their flags."""
    status = planner.status
    fade = planner.fade
    level(planner, command, sensed)
    flags = solve_legs(planner, planner.goal)
    status.flags |= flags
    tell_margin(planner)
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
    body_rotation(planner.posed, planner.rotation)
    status.beyond = 0
    together = 0
    for leg in range(LEGS):
        body_to_hip(planner.params, leg, planner.posed, planner.rotation, planner.feet, planner.hip_feet)
        flags = 0
        highest = params.legs[leg].clearance
        if hip_feet[leg * 3 + 2] > highest:
            hip_feet[leg * 3 + 2] = highest
            flags = TOO_NEAR
        flags |= reach_foot(planner.params, leg, planner.hip_feet, planner.reached)
        leg_inverse(planner.params, leg, planner.reached, joints)
        flags |= limit_joints(planner.params, leg, joints)
        leg_flags[leg] = flags
        together |= flags
        if flags and status.swinging >> leg & 1 == 0:
            status.beyond = 1
    return together


@hot
def tell_margin(planner: PlannerState) -> int:
    """Write how far the centre of mass is inside the polygon of the standing feet into the status; return it, lu."""
    params = planner.params
    status = planner.status
    reached = planner.reached
    feet = planner.margin_feet
    weights = planner.weights
    at = 0
    for leg in range(LEGS):
        hip = params.legs[leg].hip
        for axis in range(2):
            feet[at + axis] = saturate(reached[at + axis] + hip[axis], -32767, 32767)
        at += 3
        weights[leg] = 1 - (status.swinging >> leg & 1)
    status.margin = support_margin(planner.margin_feet, planner.weights, params.com_x, params.com_y)
    return status.margin
