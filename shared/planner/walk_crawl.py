"""The crawl mover: one leg at a time over what is in the way (shared/crawl), from the measured joints and the tilt."""

from ..crawl.crawl import crawl_start, crawl_tick
from ..crawl.ground import even_for_trot
from ..crawl.state import REST, STILL
from ..gait.table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.sensed import PITCH, ROLL, Sensed
from .command import MODE_WALK, Command
from .follow import use_gait, wanted_gait
from .handover import REASON_COMMAND, REASON_EVEN, REASON_NONE, crawl_can_follow
from .state import PlannerState
from .status import BLIND, STANDING, WALKING


@hot
def start_crawl(planner: PlannerState) -> None:
    """Stand as the feet are; the crawl begins once the joints' loads are known."""
    planner.speed.vx = 0
    planner.speed.vy = 0
    planner.speed.wz = 0
    planner.crawl.stage.stage = STILL


@hot
def walk_crawl(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of the crawl, or of standing still before it; return why it gives way now, or REASON_NONE.

    While joints or attitude are missing the goals stay as they are. It is STANDING where the crawl rests.
    """
    if sensed.valid.joints == 0 or sensed.valid.tilt == 0:
        planner.status.flags |= BLIND
        return REASON_NONE
    roll = saturate(sensed.tilt[ROLL], -32768, 32767)
    pitch = saturate(sensed.tilt[PITCH], -32768, 32767)
    if planner.crawl.stage.stage == STILL and planner.sensing.known > planner.params.delay_ticks + 1:
        crawl_start(planner.crawl, planner.sensing, sensed.joints, planner.joints, roll, pitch)
    if planner.crawl.stage.stage == STILL:
        return REASON_NONE
    return crawl_on(planner, command, sensed, roll, pitch)


@hot
def crawl_on(planner: PlannerState, command: Command, sensed: Sensed, roll: int, pitch: int) -> int:
    """One tick of the begun crawl; return why it gives way now, or REASON_NONE. roll, pitch: brad."""
    status = planner.status
    stage = planner.crawl.stage
    reason = end_reason(planner, command)
    ahead = command.speed.vx
    if reason or command.mode != MODE_WALK or status.fallen:
        ahead = 0
    status.flags |= crawl_tick(planner.crawl, planner.sensing, sensed.joints, roll, pitch, ahead, planner.goal)
    status.swinging = 0
    if planner.crawl.support.stance[stage.leg] == 0:
        status.swinging = 1 << stage.leg
    status.margin = planner.crawl.support.margin
    status.state = WALKING
    if stage.stage != REST:
        return REASON_NONE
    if reason == REASON_NONE and ahead <= 0:
        status.state = STANDING
    return reason


@hot
def end_reason(planner: PlannerState, command: Command) -> int:
    """Return why the crawl is to end (handover.REASON_...), or REASON_NONE.

    A gait that does not crawl is commanded, or a way the crawl cannot go; where the gait is a trot's, also on
    even ground. A command of no speed at all lets it rest.
    """
    wanted = wanted_gait(planner, command)
    gait = planner.gaits[wanted]
    if command.mode != MODE_WALK:
        return REASON_NONE
    if gait.mover == MOVER_TABLE:
        return REASON_COMMAND
    if command.speed.vx == 0 and command.speed.vy == 0 and command.speed.wz == 0:
        return REASON_NONE
    if crawl_can_follow(planner.params, command) == 0:
        return REASON_COMMAND
    if gait.mover == MOVER_TROT and planner.status.gait != wanted:
        return REASON_COMMAND
    use_gait(planner, wanted)
    if gait.mover != MOVER_CRAWL and even_for_trot(planner.crawl.ground):
        return REASON_EVEN
    return REASON_NONE


@hot
def stop_crawl(planner: PlannerState) -> None:
    """End the crawl, which rests: the trot walks on from the goals sent last."""
    planner.speed.vx = 0
    planner.speed.vy = 0
    planner.speed.wz = 0
    planner.status.state = WALKING
