"""The body over the planned feet: adds balance to the commanded pose, then solves the four legs for it."""

from ..body.axes import POSE_AXES
from ..body.balance import balance_release, balance_step
from ..body.leg import leg_inverse, limit_legs
from ..body.params import LEGS
from ..body.pose import body_rotation, body_to_hip
from ..body.reach import TOO_NEAR, reach_foot
from ..body.stability import support_margin
from ..num.fixed import saturate
from ..runtime import Ints, hot
from ..sense.sensed import PITCH, ROLL, Sensed
from .command import Command
from .handover import fade_out
from .state import PlannerState
from .status import NO_ATTITUDE


@hot
def pose_legs(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Put the body over the planned feet and solve the legs into ``planner.goal``."""
    add_balance(planner, command, sensed)
    flags = solve_legs(planner, planner.goal)
    planner.status.flags |= flags
    write_margin(planner)
    if planner.fade.left:
        fade_out(planner.fade, planner.goal)
        limit_legs(planner.params, planner.goal, planner.leg_flags)


@hot
def add_balance(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Add the balance's correction to the slewed body pose; set NO_ATTITUDE if balance lacks a known tilt."""
    posed = planner.balanced_pose
    if command.balance and sensed.valid.tilt:
        roll = saturate(sensed.tilt[ROLL], -32768, 32767)
        pitch = saturate(sensed.tilt[PITCH], -32768, 32767)
        balance_step(planner.balance, planner.pose, roll, pitch)
    else:
        balance_release(planner.balance, planner.params.pose_slew.roll)
        if command.balance:
            planner.status.flags |= NO_ATTITUDE
    for axis in range(POSE_AXES):
        posed[axis] = planner.pose[axis]
    posed.roll += planner.balance.correction.roll
    posed.pitch += planner.balance.correction.pitch


@hot
def solve_legs(planner: PlannerState, joints: Ints) -> int:
    """Solve all four legs for the planned feet and body pose into ``joints``; return the flags of all legs together.

    A foot that would pass close to its hip, or above it, is kept clear below it: else the whole leg would swing round
    in a tick or two. ``status.out_of_reach`` is set where a stance leg has flags.
    """
    status = planner.status
    body_rotation(planner.balanced_pose, planner.rotation)
    status.out_of_reach = 0
    together = 0
    for leg in range(LEGS):
        body_to_hip(planner.params, leg, planner.balanced_pose, planner.rotation, planner.feet, planner.hip_feet)
        flags = 0
        highest = planner.params.legs[leg].clearance
        if planner.hip_feet.legs[leg].z > highest:
            planner.hip_feet.legs[leg].z = highest
            flags = TOO_NEAR
        flags |= reach_foot(planner.params, leg, planner.hip_feet, planner.reached)
        leg_inverse(planner.params, leg, planner.reached, joints)
        planner.leg_flags[leg] = flags
        together |= flags
    together |= limit_legs(planner.params, joints, planner.leg_flags)
    for leg in range(LEGS):
        if planner.leg_flags[leg] and status.swinging >> leg & 1 == 0:
            status.out_of_reach = 1
    return together


@hot
def write_margin(planner: PlannerState) -> None:
    """Write the margin, how far the centre of mass is inside the support, into the status."""
    params = planner.params
    status = planner.status
    for leg in range(LEGS):
        hip = params.legs[leg].hip
        reached = planner.reached.legs[leg]
        foot = planner.margin_feet.legs[leg]
        foot.x = saturate(reached.x + hip.x, -32767, 32767)
        foot.y = saturate(reached.y + hip.y, -32767, 32767)
        planner.weights[leg] = 1 - (status.swinging >> leg & 1)
    status.margin = support_margin(planner.margin_feet, planner.weights, params.com_x, params.com_y)
