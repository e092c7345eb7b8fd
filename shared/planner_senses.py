"""What is believed of the senses, what the adaptive trot feels of it, and what a gait that feels nothing forgets."""

from .adaptive import W_ACTIVE, W_ADVICE, W_RATES, W_TURNED, W_TWIST, feel_ground, feel_legs, sway_body
from .fixed import saturate
from .goals import believe
from .ground import press_feet
from .params import JOINTS
from .planner_layout import (
    BLIND,
    ODD_READING,
    S_ATTITUDE_OK,
    S_JOINTS,
    S_JOINTS_OK,
    S_PITCH,
    S_RATES,
    S_RATES_OK,
    S_ROLL,
    SENSED_SIZE,
)
from .planner_state import PlannerState
from .runtime import Ints, hot
from .sensing import M_KNOWN


@hot
def take_senses(planner: PlannerState, sensed: Ints) -> int:
    """Write into ``planner.sensed`` what may be believed of ``sensed``; return 0. ODD_READING if not all of it.

    Until the joints are known, what was read of them last are the goals: of a limp robot, that are not driven.
    """
    status = planner.status
    params = planner.params
    own = planner.sensed
    odd = 0
    own[S_ATTITUDE_OK] = 0
    if sensed[S_ATTITUDE_OK]:
        odd = believe(sensed, S_ROLL, 2, params.tilt_step, planner.sensed, planner.tilt_read)
        if odd >= 0:
            own[S_ATTITUDE_OK] = 1
        if odd > 0:
            status.flags |= ODD_READING
    own[S_JOINTS_OK] = 0
    if sensed[S_JOINTS_OK]:
        odd = believe(sensed, S_JOINTS, JOINTS, params.read_step, planner.sensed, planner.joints_read)
        if status.met == 0:
            meet(planner)
        if odd >= 0:
            own[S_JOINTS_OK] = 1
            status.met = 1
        if odd > 0:
            status.flags |= ODD_READING
    for at in range(S_RATES, SENSED_SIZE):
        own[at] = sensed[at]
    return 0


@hot
def meet(planner: PlannerState) -> int:
    """Take the joints as they were read as the goals; return 0."""
    own = planner.sensed
    q = planner.joints
    to = planner.goal
    for joint in range(JOINTS):
        to[joint] = own[S_JOINTS + joint]
        q[joint] = own[S_JOINTS + joint]
    return 0


@hot
def feel(planner: PlannerState, sensed: Ints) -> int:
    """Give the adaptive trot what is sensed: turning rates, legs, ground; BLIND if some is missing. Returns 0."""
    status = planner.status
    w = planner.felt
    correction = planner.balance.correction
    roll = 0
    pitch = 0
    if sensed[S_ATTITUDE_OK]:
        roll = saturate(sensed[S_ROLL], -32768, 32767)
        pitch = saturate(sensed[S_PITCH], -32768, 32767)
    w[W_RATES] = sensed[S_RATES_OK]
    for axis in range(3):
        w[W_TURNED + axis] = 0
        if sensed[S_RATES_OK]:
            w[W_TURNED + axis] = saturate(sensed[S_RATES + axis], -0x8000, 0x7FFF)
    if sensed[S_ATTITUDE_OK] == 0 or sensed[S_RATES_OK] == 0 or sensed[S_JOINTS_OK] == 0:
        status.flags |= BLIND
    feel_legs(planner.params, planner.walk, sensed, S_JOINTS, sensed[S_JOINTS_OK], roll, pitch)
    feel_ground(planner.params, planner.walk, planner.steps, roll, pitch, correction.roll, correction.pitch)
    status.advice = w[W_ADVICE]
    return 0


@hot
def relax(planner: PlannerState) -> int:
    """Under a table gait: forget what was measured, sway to the middle, footholds to level ground; return 0."""
    w = planner.felt
    m = planner.sensing
    status = planner.status
    status.advice = 0
    m[M_KNOWN] = 0
    if w[W_ACTIVE]:
        w[W_TWIST] = 0
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
        press_feet(planner.params, planner.steps, 0)
    return 0
