"""The fast trot's mover: command and senses go to the fast trot (shared/stride), its goals and feet to the planner."""

from ..body.legs import legs_forward
from ..body.params import JOINTS, LEGS, LF_BITS
from ..body.pose import POSE_SIZE
from ..gait.steps import SPEED_SIZE, steps_reset
from ..gait.table import MOVER_STRIDE
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.sensed import Sensed
from ..stride.lead import solve
from ..stride.state import stride_reset
from ..stride.stride import stride_done, stride_tick
from ..trot.trot import trot_reset
from .command import Command
from .handover import fade_start
from .state import PlannerState
from .status import BLIND, STANDING, WALKING
from .steps import follow_command, limit_to_both, wanted_gait


@hot
def start_stride(planner: PlannerState) -> int:
    """Begin where the goals sent last have the feet; return 0."""
    stride = planner.stride
    work = stride.work
    feet = stride.feet
    measured = stride.measured
    pose = planner.pose
    posed = stride.posed
    stride_reset(planner.params, planner.stride)
    trot_reset(planner.params, planner.walk)
    legs_forward(planner.params, planner.joints, work.waves, stride.measured)
    for at in range(JOINTS):
        feet[at] = measured[at] << LF_BITS
    for axis in range(POSE_SIZE):
        posed[axis] = pose[axis]
    solve(planner.params, planner.stride)
    return 0


@hot
def walk_stride(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of standing or walking by the fast trot; return the legs in swing, bits.

    Told to walk by another mover's gait it stops first. Without measured joints, tilt or rates it goes on by what it
    is told (BLIND).
    """
    status = planner.status
    stride = planner.stride
    state = stride.state
    still = follow_stride(planner, command)
    moving = 1
    if status.state == STANDING:
        moving = 0
        if still == 0:
            status.state = WALKING
            moving = 1
    flags = stride_tick(
        planner.params, planner.stride, sensed, planner.speed, planner.pose, moving, planner.goal
    )
    status.flags |= flags
    if state.known == 0:
        status.flags |= BLIND
    status.beyond = 0
    if moving == 0 and flags:
        status.beyond = 1
    if moving and still and stride_done(planner.stride):
        status.state = STANDING
    return tell_stride(planner)


@hot
def follow_stride(planner: PlannerState, command: Command) -> int:
    """Move speed and pose one tick towards the command, slower while swings are high; return 1 if the speed is 0."""
    params = planner.params
    stride = planner.stride
    state = stride.state
    top = planner.top
    wanted = wanted_gait(planner, command)
    limit_to_both(planner, wanted)
    if state.high_left:
        for axis in range(2):
            top[axis] = saturate(top[axis], 0, params.stride.high_speed)
    gait = planner.gaits[wanted]
    halves = 2
    if gait.mover != MOVER_STRIDE:
        halves = 0
    return follow_command(planner, command, halves)


@hot
def tell_stride(planner: PlannerState) -> int:
    """Write the feet, in the body, and the legs in swing to where the planner tells them; return those, bits."""
    status = planner.status
    stride = planner.stride
    state = stride.state
    planned = stride.feet
    hip_feet = stride.hip_feet
    feet = planner.feet
    reached = planner.reached
    for at in range(JOINTS):
        feet[at] = planned[at] >> LF_BITS
        reached[at] = hip_feet[at]
    leg_flags = planner.leg_flags
    for leg in range(LEGS):
        leg_flags[leg] = 0
    status.swinging = state.swinging
    status.margin = 0
    status.advice = 0
    return state.swinging


@hot
def stop_stride(planner: PlannerState) -> int:
    """End the fast trot, which stands: another goes on from its goals; return 0."""
    status = planner.status
    speed = planner.speed
    for axis in range(SPEED_SIZE):
        speed[axis] = 0
    steps_reset(planner.params, planner.steps)
    fade_start(planner.params, planner.fade, planner.joints)
    status.cycles = 0
    return 0
