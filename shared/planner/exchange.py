"""When the crawl over obstacles takes over from the trot, its tick, and when it gives back.

    off -> (held up) backing off -> ready -> crawling -> off
"""

from ..body.balance import balance_reset
from ..crawl.crawl import crawl_start, crawl_tick
from ..crawl.state import REST
from ..gait.gaits import GAIT_ADAPTIVE, GAIT_CLIMB
from ..gait.steps import SPEED_SIZE
from ..num.fixed import saturate
from ..runtime import hot
from ..sense.legs import sense_legs, stands_level
from ..sense.sensed import Sensed
from ..trot.navigate import navigate_reset
from ..trot.trot import ADVICE_BEHIND, trot_start
from .command import MODE_WALK, Command
from .handover import (
    REASON_BEHIND,
    REASON_COMMAND,
    REASON_EVEN,
    REASON_NONE,
    fade_start,
    ground_even,
    steps_from_crawl,
    straight_on,
)
from .retreat import retreat_start, retreat_step
from .state import PlannerState
from .status import BLIND, CLIMB_BACK, CLIMB_OFF, CLIMB_ON, CLIMB_READY, STANDING, WALKING
from .steps import use_gait, wanted_gait


@hot
def climbs(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """Return 1 if this tick is the crawl's: it has begun, or is to begin now; else 0.

    It begins when it is the commanded gait and the command one it can follow, or when the adaptive trot is
    advised to give way, at a moment when all feet have stood for long enough; held up, the trot backs off first.
    Without measured joints or attitude it never begins (BLIND): its table is walked instead.
    """
    valid = sensed.valid
    status = planner.status
    if status.climb == CLIMB_BACK:
        return backed_off(planner, command, sensed)
    if status.climb:
        return 1
    if command.mode != MODE_WALK or status.fallen or straight_on(planner.params, command) == 0:
        return 0
    reason = REASON_NONE
    if status.swinging:
        return 0
    if command.gait == GAIT_CLIMB and (status.state == STANDING or status.gait == GAIT_CLIMB):
        reason = REASON_COMMAND
    elif status.gait == GAIT_ADAPTIVE and (command.gait == GAIT_ADAPTIVE or command.gait == GAIT_CLIMB):
        reason = advised(planner, command.gait)
    if reason == REASON_NONE:
        return 0
    if valid.joints == 0 or valid.tilt == 0:
        status.flags |= BLIND
        return 0
    status.reason = reason
    if reason == REASON_BEHIND:
        return back_off(planner)
    return stop_to_climb(planner, command.gait)


@hot
def stop_to_climb(planner: PlannerState, gait: int) -> int:
    """Stand as the feet are; the crawl begins, as part of ``gait``, once the joints' loads are known; return 1."""
    status = planner.status
    speed = planner.speed
    for axis in range(SPEED_SIZE):
        speed[axis] = 0
    status.climb = CLIMB_READY
    status.gait = gait
    return 1


@hot
def back_off(planner: PlannerState) -> int:
    """The held-up trot begins to back off, its reference where the robot is; return 0: it goes on trotting."""
    status = planner.status
    trot = planner.trot
    navigate_reset(planner.nav)
    trot.behind = 0
    status.climb = CLIMB_BACK
    return retreat_start(planner.retreat)


@hot
def backed_off(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of backing off; return 1 if it is done and the crawl takes over, 0 while the trot walks.

    It is given up when the command is no longer one for it, or when the senses it needs are missing.
    """
    valid = sensed.valid
    status = planner.status
    sensing = planner.sensing
    keeps_on = straight_on(planner.params, command)
    if command.mode != MODE_WALK or status.fallen:
        keeps_on = 0
    if command.gait != GAIT_ADAPTIVE and command.gait != GAIT_CLIMB:
        keeps_on = 0
    if keeps_on == 0 or valid.joints == 0 or valid.tilt == 0:
        status.climb = CLIMB_OFF
        return 0
    standing = 0
    if status.state == STANDING:
        standing = 1
    if retreat_step(planner.params, command, sensing.moved_x, standing, planner.retreat, planner.back):
        return stop_to_climb(planner, command.gait)
    return 0


@hot
def advised(planner: PlannerState, wanted: int) -> int:
    """Return why the adaptive trot should give way to the crawl, once all feet surely stand; else REASON_NONE.

    wanted: the commanded gait. Tilt alone is no reason: a crawl begun with the feet on both sides of an edge down does
    not know where it is. So a commanded one waits for level feet too, clear of what might hold the trot up.
    """
    status = planner.status
    params = planner.params
    trot = planner.trot
    clock = planner.clock
    if status.state != WALKING or clock.tick <= params.stand_ticks:
        return REASON_NONE
    if status.advice == ADVICE_BEHIND:
        return REASON_BEHIND
    if wanted == GAIT_CLIMB and trot.behind == 0 and stands_level(planner.params, planner.sensing):
        return REASON_COMMAND
    return REASON_NONE


@hot
def climb(planner: PlannerState, command: Command, sensed: Sensed) -> int:
    """One tick of the crawl over obstacles, or of what comes before and after it; return 0.

    While joints or attitude are missing the goals stay as they are. It is STANDING where the crawl rests.
    """
    valid = sensed.valid
    tilt = sensed.tilt
    status = planner.status
    params = planner.params
    sensing = planner.sensing
    support = planner.climb.support
    stage = planner.climb.stage
    if valid.joints == 0 or valid.tilt == 0:
        status.flags |= BLIND
        return 0
    roll = saturate(tilt[0], -32768, 32767)
    pitch = saturate(tilt[1], -32768, 32767)
    sense_legs(planner.params, sensed.joints, roll, pitch, planner.sensing)
    if status.climb == CLIMB_READY and sensing.known > params.sent_ticks + 1:
        crawl_start(planner.climb, planner.sensing, sensed.joints, planner.joints, roll, pitch)
        status.climb = CLIMB_ON
    if status.climb == CLIMB_ON:
        reason = leaves(planner, command)
        ahead = command.speed[0]
        if reason or command.mode != MODE_WALK or status.fallen:
            ahead = 0
        status.flags |= crawl_tick(planner.climb, planner.sensing, sensed.joints, roll, pitch, ahead, planner.goal)
        status.swinging = 0
        if support.stance[stage.leg] == 0:
            status.swinging = 1 << stage.leg
        status.margin = support.margin
        status.state = WALKING
        if stage.stage == REST:
            if reason:
                hand_to_trot(planner, command, reason)
            elif ahead <= 0:
                status.state = STANDING
    return 0


@hot
def leaves(planner: PlannerState, command: Command) -> int:
    """Return why the crawl is to end (handover.REASON_...), or REASON_NONE.

    Another gait is commanded, or a way it cannot go; as part of the adaptive gait also on even ground. A
    command of no speed at all lets it rest.
    """
    status = planner.status
    wanted = wanted_gait(planner, command)
    if command.mode != MODE_WALK:
        return REASON_NONE
    if wanted != GAIT_CLIMB and wanted != GAIT_ADAPTIVE:
        return REASON_COMMAND
    if command.speed[0] == 0 and command.speed[1] == 0 and command.speed[2] == 0:
        return REASON_NONE
    if straight_on(planner.params, command) == 0:
        return REASON_COMMAND
    status.gait = wanted
    if wanted == GAIT_ADAPTIVE and ground_even(planner.climb.even):
        return REASON_EVEN
    return REASON_NONE


@hot
def hand_to_trot(planner: PlannerState, command: Command, reason: int) -> int:
    """End the crawl: the commanded gait walks on from where the feet stand, from rest; return 0."""
    status = planner.status
    trot = planner.trot
    speed = planner.speed
    steps_from_crawl(planner.params, planner.climb.map, planner.climb.path, trot.ahead, trot.sway, planner.steps)
    fade_start(planner.params, planner.fade, planner.joints)
    for axis in range(SPEED_SIZE):
        speed[axis] = 0
    balance_reset(planner.balance)
    trot_start(planner.params, planner.walk)
    trot.rough = 0
    status.climb = CLIMB_OFF
    status.reason = reason
    status.advice = 0
    status.cycles = 0
    status.state = WALKING
    return use_gait(planner, wanted_gait(planner, command))
