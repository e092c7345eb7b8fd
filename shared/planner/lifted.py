"""Lifted off the ground: feet that carried the robot carry nothing any more.

On the ground the feet that are to stand always carry: in walks over steps, stairs and stones they were felt to carry
less than a quarter of the weight for 0.06 s at most, in the hand they never were felt to carry more. Who has never felt
its weight for two seconds on end, on a stand or with joints too stiff to tell, is not lifted.

    carries nothing for 0.25 s -> slowly to the stance, hold it -> carries again for 2 s and is told to stand -> stands
"""

from ..runtime import hot
from ..sense.odometry import FELT
from .command import MODE_LIMP, MODE_SIT, MODE_STAND
from .state import PlannerState
from .states import begin_move
from .status import LIFTED, RISING


@hot
def watch_weight(planner: PlannerState) -> int:
    """Take what the feet were felt to carry in this tick; return 1 if the robot is lifted, else 0.

    It begins to be when they have carried nothing for a quarter of a second; the legs then go to the stance. That they
    carry is known after two seconds: joints that follow at once are felt as if loaded for up to 1.3 s of a walk in the
    air.
    """
    status = planner.status
    odometry = planner.odometry
    carries = 0
    if odometry.carried >= FELT:
        carries = 1
    if carries == status.carries:
        status.doubted = 0
        return status.lifted
    params = planner.params
    most = params.rate_hz >> 2
    if carries:
        most = params.rate_hz << 1
    status.doubted += 1
    if status.doubted <= most:
        return status.lifted
    status.doubted = 0
    status.carries = carries
    if carries == 0 and status.lifted == 0:
        status.lifted = 1
        status.flags |= LIFTED
        begin_move(planner, planner.sensed, RISING)
    return status.lifted


@hot
def put_down(planner: PlannerState, mode: int) -> int:
    """Return 1 while the robot is lifted: until its feet carry and it is told to stand, or it is to sit or be limp."""
    status = planner.status
    if status.lifted == 0:
        return 0
    if mode == MODE_LIMP or mode == MODE_SIT or (mode == MODE_STAND and status.carries):
        status.lifted = 0
        return 0
    status.flags |= LIFTED
    return 1
