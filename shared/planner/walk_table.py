"""The table mover: stands and walks by a gait's table alone, blind to the ground.

    command -> slewed speed -> gait clock -> feet -> body and legs
"""

from ..gait.steps import start_swings
from ..runtime import hot
from ..sense.sensed import Sensed
from .command import Command
from .pose import pose_legs
from .state import PlannerState
from .steps import (
    follow_command,
    lift_height,
    limit_to_both,
    next_cycle,
    stands,
    step_feet,
    wanted_gait,
    within_speed,
)


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
