"""When the crawl over obstacles takes over from the trot, its tick, and when it gives back.

    off -> (held up) backing off -> ready -> crawling -> off
"""

from .adaptive import ADVICE_BEHIND, W_AHEAD, W_BEHIND, W_ROUGH, W_SWAY, adaptive_start
from .balance import balance_reset
from .command import C_GAIT, C_MODE, C_SPEED, MODE_WALK
from .crawl import crawl_start, crawl_tick
from .crawl_state import REST
from .fixed import saturate
from .gait import CLOCK_TICK
from .gaits import GAIT_ADAPTIVE, GAIT_CLIMB
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
from .navigate import navigate_reset
from .planner_layout import (
    BLIND,
    CLIMB_BACK,
    CLIMB_OFF,
    CLIMB_ON,
    CLIMB_READY,
    N_ADVICE,
    N_CLIMB,
    N_CYCLES,
    N_FALLEN,
    N_FLAGS,
    N_GAIT,
    N_MARGIN,
    N_REASON,
    N_STATE,
    N_SWINGING,
    S_ATTITUDE_OK,
    S_JOINTS,
    S_JOINTS_OK,
    S_PITCH,
    S_ROLL,
    STANDING,
    WALKING,
)
from .planner_state import PlannerState
from .planner_steps import use_gait, wanted_gait
from .retreat import retreat_start, retreat_step
from .runtime import Ints, hot
from .sensing import M_KNOWN, M_MOVED_X, sense_legs, stands_level
from .steps import SPEED_SIZE


@hot
def climbs(planner: PlannerState, command: Ints, sensed: Ints) -> int:
    """Return 1 if this tick is the crawl's: it has begun, or is to begin now; else 0.

    It begins when it is the commanded gait and the command one it can follow, or when the adaptive trot is
    advised to give way, at a moment when all feet have stood for long enough; held up, the trot backs off first.
    Without measured joints or attitude it never begins (BLIND): its table is walked instead.
    """
    n = planner.numbers
    if n[N_CLIMB] == CLIMB_BACK:
        return backed_off(planner, command, sensed)
    if n[N_CLIMB]:
        return 1
    if command[C_MODE] != MODE_WALK or n[N_FALLEN] or straight_on(planner.params, command) == 0:
        return 0
    reason = REASON_NONE
    if n[N_SWINGING]:
        return 0
    if command[C_GAIT] == GAIT_CLIMB and (n[N_STATE] == STANDING or n[N_GAIT] == GAIT_CLIMB):
        reason = REASON_COMMAND
    elif n[N_GAIT] == GAIT_ADAPTIVE and (command[C_GAIT] == GAIT_ADAPTIVE or command[C_GAIT] == GAIT_CLIMB):
        reason = advised(planner, command[C_GAIT])
    if reason == REASON_NONE:
        return 0
    if sensed[S_JOINTS_OK] == 0 or sensed[S_ATTITUDE_OK] == 0:
        n[N_FLAGS] |= BLIND
        return 0
    n[N_REASON] = reason
    if reason == REASON_BEHIND:
        return back_off(planner)
    return stop_to_climb(planner, command[C_GAIT])


@hot
def stop_to_climb(planner: PlannerState, gait: int) -> int:
    """Stand as the feet are; the crawl begins, as part of ``gait``, once the joints' loads are known; return 1."""
    n = planner.numbers
    v = planner.speed
    for axis in range(SPEED_SIZE):
        v[axis] = 0
    n[N_CLIMB] = CLIMB_READY
    n[N_GAIT] = gait
    return 1


@hot
def back_off(planner: PlannerState) -> int:
    """The held-up trot begins to back off, its reference where the robot is; return 0: it goes on trotting."""
    n = planner.numbers
    w = planner.felt
    navigate_reset(planner.nav)
    w[W_BEHIND] = 0
    n[N_CLIMB] = CLIMB_BACK
    return retreat_start(planner.retreat)


@hot
def backed_off(planner: PlannerState, command: Ints, sensed: Ints) -> int:
    """One tick of backing off; return 1 if it is done and the crawl takes over, 0 while the trot walks.

    It is given up when the command is no longer one for it, or when the senses it needs are missing.
    """
    n = planner.numbers
    m = planner.sensing
    keeps_on = straight_on(planner.params, command)
    if command[C_MODE] != MODE_WALK or n[N_FALLEN]:
        keeps_on = 0
    if command[C_GAIT] != GAIT_ADAPTIVE and command[C_GAIT] != GAIT_CLIMB:
        keeps_on = 0
    if keeps_on == 0 or sensed[S_JOINTS_OK] == 0 or sensed[S_ATTITUDE_OK] == 0:
        n[N_CLIMB] = CLIMB_OFF
        return 0
    standing = 0
    if n[N_STATE] == STANDING:
        standing = 1
    if retreat_step(planner.params, command, m[M_MOVED_X], standing, planner.retreat):
        return stop_to_climb(planner, command[C_GAIT])
    return 0


@hot
def advised(planner: PlannerState, wanted: int) -> int:
    """Return why the adaptive trot should give way to the crawl, once all feet surely stand; else REASON_NONE.

    wanted: the commanded gait. Tilt alone is no reason: a crawl begun with the feet on both sides of an edge down does
    not know where it is. So a commanded one waits for level feet too, clear of what might hold the trot up.
    """
    n = planner.numbers
    params = planner.params
    w = planner.felt
    clock = planner.clock
    if n[N_STATE] != WALKING or clock[CLOCK_TICK] <= params.stand_ticks:
        return REASON_NONE
    if n[N_ADVICE] == ADVICE_BEHIND:
        return REASON_BEHIND
    if wanted == GAIT_CLIMB and w[W_BEHIND] == 0 and stands_level(planner.params, planner.sensing):
        return REASON_COMMAND
    return REASON_NONE


@hot
def climb(planner: PlannerState, command: Ints, sensed: Ints) -> int:
    """One tick of the crawl over obstacles, or of what comes before and after it; return 0.

    While joints or attitude are missing the goals stay as they are. It is STANDING where the crawl rests.
    """
    n = planner.numbers
    params = planner.params
    m = planner.sensing
    support = planner.climb.support
    stage = planner.climb.stage
    if sensed[S_JOINTS_OK] == 0 or sensed[S_ATTITUDE_OK] == 0:
        n[N_FLAGS] |= BLIND
        return 0
    roll = saturate(sensed[S_ROLL], -32768, 32767)
    pitch = saturate(sensed[S_PITCH], -32768, 32767)
    sense_legs(planner.params, sensed, S_JOINTS, roll, pitch, planner.sensing)
    if n[N_CLIMB] == CLIMB_READY and m[M_KNOWN] > params.sent_ticks + 1:
        crawl_start(planner.climb, planner.sensing, sensed, S_JOINTS, planner.joints, roll, pitch)
        n[N_CLIMB] = CLIMB_ON
    if n[N_CLIMB] == CLIMB_ON:
        reason = leaves(planner, command)
        ahead = command[C_SPEED]
        if reason or command[C_MODE] != MODE_WALK or n[N_FALLEN]:
            ahead = 0
        n[N_FLAGS] |= crawl_tick(planner.climb, planner.sensing, sensed, S_JOINTS, roll, pitch, ahead, planner.goal)
        n[N_SWINGING] = 0
        if support.stance[stage.leg] == 0:
            n[N_SWINGING] = 1 << stage.leg
        n[N_MARGIN] = support.margin
        n[N_STATE] = WALKING
        if stage.stage == REST:
            if reason:
                hand_to_trot(planner, command, reason)
            elif ahead <= 0:
                n[N_STATE] = STANDING
    return 0


@hot
def leaves(planner: PlannerState, command: Ints) -> int:
    """Return why the crawl is to end (handover.REASON_...), or REASON_NONE.

    Another gait is commanded, or a way it cannot go; as part of the adaptive gait also on even ground. A
    command of no speed at all lets it rest.
    """
    n = planner.numbers
    wanted = wanted_gait(planner, command)
    if command[C_MODE] != MODE_WALK:
        return REASON_NONE
    if wanted != GAIT_CLIMB and wanted != GAIT_ADAPTIVE:
        return REASON_COMMAND
    if command[C_SPEED] == 0 and command[C_SPEED + 1] == 0 and command[C_SPEED + 2] == 0:
        return REASON_NONE
    if straight_on(planner.params, command) == 0:
        return REASON_COMMAND
    n[N_GAIT] = wanted
    if wanted == GAIT_ADAPTIVE and ground_even(planner.climb.even):
        return REASON_EVEN
    return REASON_NONE


@hot
def hand_to_trot(planner: PlannerState, command: Ints, reason: int) -> int:
    """End the crawl: the commanded gait walks on from where the feet stand, from rest; return 0."""
    n = planner.numbers
    w = planner.felt
    v = planner.speed
    steps_from_crawl(planner.params, planner.climb.map, planner.climb.path, w[W_AHEAD], w[W_SWAY], planner.steps)
    fade_start(planner.params, planner.fade, planner.joints)
    for axis in range(SPEED_SIZE):
        v[axis] = 0
    balance_reset(planner.balance)
    adaptive_start(planner.params, planner.walk)
    w[W_ROUGH] = 0
    n[N_CLIMB] = CLIMB_OFF
    n[N_REASON] = reason
    n[N_ADVICE] = 0
    n[N_CYCLES] = 0
    n[N_STATE] = WALKING
    return use_gait(planner, wanted_gait(planner, command))
