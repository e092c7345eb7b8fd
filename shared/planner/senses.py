"""What is believed of the senses, what the trot feels of it, and what a gait that feels nothing forgets."""

from ..body.params import JOINTS
from ..num.fixed import saturate
from ..runtime import Ints, hot
from ..sense.sensed import Sensed
from ..trot.ground import press_feet
from ..trot.trot import feel_ground, feel_legs, sway_body
from .goals import believe
from .state import PlannerState
from .status import BLIND, ODD_READING


@hot
def take_senses(planner: PlannerState, sensed: Sensed) -> int:
    """Write into ``planner.sensed`` what may be believed of ``sensed``; return 0. ODD_READING if not all of it.

    Until the joints are known, what was read of them last are the goals: of a limp robot, that are not driven.
    """
    status = planner.status
    params = planner.params
    valid = sensed.valid
    believed = planner.sensed
    known = believed.valid
    known.tilt = 0
    if valid.tilt:
        odd = believe(sensed.tilt, 2, params.tilt_step, believed.tilt, planner.tilt_past)
        known.tilt = note_odd(planner, odd)
    known.joints = 0
    if valid.joints:
        odd = believe(sensed.joints, JOINTS, params.read_step, believed.joints, planner.joints_past)
        if status.met == 0:
            meet(planner, believed.joints)
        known.joints = note_odd(planner, odd)
        status.met |= known.joints
    known.turned = valid.turned
    turned = sensed.turned
    kept = believed.turned
    for axis in range(3):
        kept[axis] = turned[axis]
    return 0


@hot
def note_odd(planner: PlannerState, odd: int) -> int:
    """Set ODD_READING if some readings were odd; return 1 if the others are known (``odd`` is not -1), else 0."""
    status = planner.status
    if odd > 0:
        status.flags |= ODD_READING
    if odd < 0:
        return 0
    return 1


@hot
def meet(planner: PlannerState, read: Ints) -> int:
    """Take the joints as they were read as the goals; return 0."""
    joints = planner.joints
    goal = planner.goal
    for joint in range(JOINTS):
        goal[joint] = read[joint]
        joints[joint] = read[joint]
    return 0


@hot
def feel(planner: PlannerState, sensed: Sensed) -> int:
    """Give the trot what is sensed: turning rates, legs, ground; BLIND if some is missing. Returns 0."""
    status = planner.status
    trot = planner.trot
    correction = planner.balance.correction
    valid = sensed.valid
    tilt = sensed.tilt
    rates = sensed.turned
    roll = 0
    pitch = 0
    if valid.tilt:
        roll = saturate(tilt[0], -32768, 32767)
        pitch = saturate(tilt[1], -32768, 32767)
    trot.turned_known = valid.turned
    for axis in range(3):
        trot.turned[axis] = 0
        if valid.turned:
            trot.turned[axis] = saturate(rates[axis], -0x8000, 0x7FFF)
    if valid.tilt == 0 or valid.turned == 0 or valid.joints == 0:
        status.flags |= BLIND
    feel_legs(planner.params, planner.walk, sensed.joints, valid.joints, roll, pitch)
    feel_ground(planner.params, planner.walk, planner.steps, roll, pitch, correction.roll, correction.pitch)
    status.advice = trot.advice
    return 0


@hot
def relax(planner: PlannerState) -> int:
    """Under a table gait: forget what was measured, sway to the middle, footholds to level ground; return 0."""
    trot = planner.trot
    sensing = planner.sensing
    status = planner.status
    status.advice = 0
    sensing.known = 0
    if trot.active:
        trot.twist = 0
        sway_body(planner.params, planner.walk, planner.gait, planner.clock, 0)
        press_feet(planner.params, planner.steps, 0)
    return 0
