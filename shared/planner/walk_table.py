"""The table mover: stands and walks by a gait's table alone, blind to the ground.

    command -> slewed speed -> gait clock -> feet -> body and legs
"""

from ..body.axes import TWIST_AXES
from ..gait.steps import body_advance, move_feet, place_feet, start_swings, steps_at_rest
from ..gait.table import gait_clock
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.sensed import Sensed
from .command import Command
from .follow import follow_command, limit_to_both, use_gait, wanted_gait
from .pose import pose_legs
from .state import PlannerState
from .status import STANDING, WALKING


@hot
def walk_table(planner: PlannerState, command: Command, sensed: Sensed) -> None:
    """Do one tick of standing or walking by a gait's table.

    The first cycle is walked at half speed: all feet start at rest, in the middle of their travel, and the last one to
    swing would otherwise be left a whole stride behind.
    """
    wanted = wanted_gait(planner, command)
    limit_to_both(planner, wanted)
    fits = within_speed(planner, wanted)
    still = follow_command(planner, command, 1 + planner.status.cycles)
    if stands(planner, still) == 0:
        if planner.clock.tick == 0:
            start_swings(planner.gait, planner.clock, planner.steps)
        step_feet(planner, lift_height(planner, command.height))
        next_cycle(planner, wanted, fits, still)
    pose_legs(planner, command, sensed)


@hot
def stands(planner: PlannerState, still: int) -> int:
    """Return 1 if the robot stands in this tick, its feet where they are; 0 if it walks, perhaps from now on.

    still: 1 if the speed is 0.
    """
    status = planner.status
    if status.state != STANDING:
        return 0
    if still:
        place_feet(planner.params, planner.gait, planner.steps, planner.speed, 0, planner.feet)
        status.swinging = 0
        return 1
    status.state = WALKING
    return 0


@hot
def lift_height(planner: PlannerState, height_lu: int) -> int:
    """Return the swing height, lu, within reach: as commanded, or the gait's own if that is 0 or less."""
    if height_lu <= 0:
        height_lu = planner.status.height
    return saturate(height_lu, 0, -planner.params.sit_z)


@hot
def step_feet(planner: PlannerState, height_lu: int) -> None:
    """Move and place all feet for one tick of the gait's clock."""
    status = planner.status
    move_feet(planner.steps, planner.speed, body_advance(planner.gait, planner.clock))
    status.swinging = place_feet(planner.params, planner.gait, planner.steps, planner.speed, height_lu, planner.feet)


@hot
def next_cycle(planner: PlannerState, wanted: int, fits: int, still: int) -> None:
    """Advance the clock; at the end of a cycle stand if ``still``, or change to the ``wanted`` gait if it ``fits``."""
    status = planner.status
    if gait_clock(planner.gait, planner.clock) == 0:
        return
    status.cycles = 1
    if still and steps_at_rest(planner.params, planner.steps):
        status.state = STANDING
    elif fits:
        use_gait(planner, wanted)
    else:
        use_gait(planner, status.gait)


@hot
def within_speed(planner: PlannerState, wanted: int) -> int:
    """Return 1 if the ``wanted`` gait allows the current speed: at a higher one its steps would be too long."""
    speed = planner.speed
    other = planner.gaits[wanted]
    for axis in range(TWIST_AXES):
        if speed[axis] > other.speed_max[axis] or speed[axis] < -other.speed_max[axis]:
            return 0
    return 1
