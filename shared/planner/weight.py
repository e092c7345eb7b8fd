"""Lifted off the ground: feet that carried the robot carry nothing any more.

What the feet that are to stand carry together is the weight, evened over 0.2 s: in walks of Caramelo and Parallel over
steps, bars and stairs it fell to 0.41 of the own weight at the lowest, unless the trunk lay on an edge. In the hand it
falls below a quarter within 0.3 s. That the feet carry at all is seen as soon as it has risen, and in the hand: legs
that hold still feel no loads but true ones. Who has risen on a stand, or has joints too stiff to tell, is not lifted.
Legs that a pose has just moved are held by dry friction and sag as little as 0.2 of the weight would have them: what
they carry is asked anew, and a body that carried before may feel it while it walks, too.

    carries nothing -> slowly to the stance, hold it -> carries again and is told to stand -> stands
"""

from ..crawl.state import HANG, LOWER
from ..gait.table import MOVER_CRAWL
from ..num.fixed import saturate
from ..runtime import const, hot
from .command import MODE_FOLD, MODE_LIMP, MODE_SIT, MODE_STAND
from .posture import posture_step
from .state import PlannerState
from .states import begin_move
from .status import CARRIES, LIFTED, POSED, RISING, STANDING

_OWN_Q12 = const(4096)
_HALF_Q12 = const(2048)
_QUARTER_Q12 = const(1024)
_RISEN = const(4)  # ticks for which the joints have answered a robot that has risen


@hot
def watch_weight(planner: PlannerState) -> None:
    """Take what the feet were felt to carry in this tick.

    Where that begins the legs go to the stance. A body that is shifted feels other loads, and is not looked at.
    Intermediates: 2^17 * 2^8, at 20 Hz.
    """
    status = planner.status
    if status.pose_moves:
        if status.carries_weight == CARRIES:
            status.carries_weight = POSED
        status.feet_load_q12 = 0
        return
    status.feet_load_q12 += (carried_load_q12(planner) - status.feet_load_q12) * planner.params.average_q10 >> 10
    if status.carries_weight != CARRIES:
        check_carries(planner)
    elif status.feet_load_q12 < _QUARTER_Q12:
        status.lifted = 1
        status.flags |= LIFTED
        begin_move(planner, planner.sensed, RISING)
        posture_step(planner.move, planner.goal)


@hot
def carried_load_q12(planner: PlannerState) -> int:
    """Return what the feet carry, own weight Q12: also the one that the crawl lowers.

    It may bear most of the robot before it is told to stand. Other legs in the air press only as they are moved.
    Within -1 .. 2 own weights: a leg that strikes something seems to pull with several for a tick, which is no lift.
    """
    carried_q12 = planner.odometry.carried_q12
    if planner.status.mover == MOVER_CRAWL:
        stage = planner.crawl.stage
        if stage.stage == HANG or stage.stage == LOWER:
            carried_q12 += saturate(planner.sensing.force_q12[stage.leg], 0, _OWN_Q12)
    return saturate(carried_q12, -_OWN_Q12, 2 * _OWN_Q12)


@hot
def check_carries(planner: PlannerState) -> None:
    """See whether the feet carry the robot: when it has risen, before it walks, while it stands, after a pose."""
    status = planner.status
    tells = 0
    if planner.sensing.known == planner.params.delay_ticks + _RISEN:
        status.feet_load_q12 = carried_load_q12(planner)
        tells = 1
    elif status.state == STANDING or status.carries_weight == POSED:
        tells = 1
    if tells and status.feet_load_q12 >= _HALF_Q12:
        status.carries_weight = CARRIES


@hot
def stays_lifted(planner: PlannerState, mode: int) -> int:
    """Return 1 while the robot is lifted: until its feet carry and it is told to stand, or it is to sit or be limp."""
    status = planner.status
    if status.lifted == 0:
        return 0
    carries = status.carries_weight
    if mode == MODE_LIMP or mode == MODE_SIT or mode == MODE_FOLD or (mode == MODE_STAND and carries == CARRIES):
        status.lifted = 0
    else:
        status.flags |= LIFTED
    return status.lifted
