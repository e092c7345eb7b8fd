"""How every mover follows the command: its speed, its pose, its gait.

    command -> slewed speed and pose; a pose out of reach is held back
"""

from ..body.axes import POSE_AXES
from ..runtime import hot
from .command import MODE_WALK, Command, is_posed, slew_pose, slew_speed
from .state import PlannerState
from .status import BAD_COMMAND, POSE_HELD


@hot
def follow_command(planner: PlannerState, command: Command, halves: int) -> int:
    """Slew speed and pose for one tick towards the command; return 1 if the speed is 0.

    halves: 0, 1 or 2 for none, half or all of the commanded speed.
    """
    status = planner.status
    if command.mode != MODE_WALK or status.fallen:
        halves = 0
    still = slew_speed(planner.params, planner.top_speed, command, halves, planner.speed)
    status.pose_moves = 0
    if (status.out_of_reach or status.pose_held) and hold_back(planner, command):
        return still
    if is_posed(command, planner.pose) == 0:
        status.pose_moves = slew_pose(planner.params, command, 1, planner.pose)
    return still


@hot
def hold_back(planner: PlannerState, command: Command) -> int:
    """Move the body's pose one step back if a stance leg is beyond its reach; return 1 while the pose is held back.

    It is held until a pose other than the one that led there is commanded, and the legs are within reach again
    (POSE_HELD). A leg in the air only has its swing cut short.
    """
    status = planner.status
    posed = 0
    other = 0
    for axis in range(POSE_AXES):
        if planner.pose[axis]:
            posed = 1
        if status.held_pose[axis] != command.pose[axis]:
            other = 1
    if status.out_of_reach and posed:
        if status.pose_held == 0:
            for axis in range(POSE_AXES):
                status.held_pose[axis] = command.pose[axis]
        status.pose_held = 1
        status.pose_moves = slew_pose(planner.params, command, 0, planner.pose)
    elif other:
        status.pose_held = 0
    if status.pose_held:
        status.flags |= POSE_HELD
    return status.pose_held


@hot
def limit_to_both(planner: PlannerState, wanted: int) -> None:
    """Limit the commanded speed to what both the current gait and ``wanted`` allow."""
    gait = planner.gait
    other = planner.gaits[wanted]
    top = planner.top_speed
    top.vx = gait.speed_max.vx
    top.vy = gait.speed_max.vy
    top.wz = gait.speed_max.wz
    if other.speed_max.vx < top.vx:
        top.vx = other.speed_max.vx
    if other.speed_max.vy < top.vy:
        top.vy = other.speed_max.vy
    if other.speed_max.wz < top.wz:
        top.wz = other.speed_max.wz


@hot
def wanted_gait(planner: PlannerState, command: Command) -> int:
    """Return the index of the commanded gait, or of the current one if there is no such gait."""
    status = planner.status
    gait = command.gait
    if gait < 0 or gait >= status.gaits:
        status.flags |= BAD_COMMAND
        return status.gait
    return gait


@hot
def use_gait(planner: PlannerState, gait: int) -> None:
    """Walk ``gait`` from its first segment on; only between cycles, when all feet stand."""
    clock = planner.clock
    clock.tick = 0
    clock.made_q10 = 0
    clock.segment = 0
    planner.status.gait = gait
    planner.gait = planner.gaits[gait]
    taken = planner.gait
    planner.status.height = (taken.height_mm << planner.params.length_shift) // 1000
