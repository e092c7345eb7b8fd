"""From planned feet to goals: what the joints give under load is added before, and what drives lag behind."""

from ..body.compliance import sag_leg
from ..body.legs import legs_inverse
from ..body.params import JOINTS, LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..runtime import Ints, const, hot
from .react import MET, MET_NOW
from .state import Trot

_ONE_Q12 = const(4096)
_CALM = const(3)  # standing, an eighth of the step


@hot
def share_load(params: Params, walk: Trot) -> int:
    """Move what each foot is expected to carry towards an even share of those that stand; return that, Q12.

    Slowly while it is not to move: who has just stood up does not jerk.
    """
    state = walk.state
    wish = walk.wish
    stands = walk.stands
    load_q12 = walk.load_q12
    step = params.trot.load_step_q12
    if wish.moving == 0:
        step = (step >> _CALM) + 1
    share = 0
    if state.standing:
        share = _ONE_Q12 // state.standing
    for leg in range(LEGS):
        wanted = 0
        if stands[leg]:
            wanted = share
        gap = wanted - load_q12[leg]
        if gap > step or gap < -step:
            gap = saturate(gap, -step, step)
        load_q12[leg] += gap
    return share


@hot
def solve(params: Params, walk: Trot) -> int:
    """Write the joints that reach the planned feet; return why some were brought into reach, or 0."""
    feet = walk.feet
    hip_feet = walk.hip_feet
    joints = walk.joints
    before = walk.joints_before
    at = 0
    for leg in range(LEGS):
        hip = params.legs[leg].hip
        for axis in range(3):
            before[at] = joints[at]
            hip_feet[at] = (feet[at] >> LF_BITS) - hip[axis]
            at += 1
    return legs_inverse(params, walk.hip_feet, walk.work, walk.joints)


@hot
def lead(params: Params, walk: Trot, goal: Ints) -> int:
    """Write 12 goals, brad: the joints, what they give under their load, and where they will be a lag later; return 0.

    Of a foot in the air half of the lag is led: all of it shakes a robot of soft joints. Intermediates: 2^15 * 2^14.
    """
    stands = walk.stands
    early = walk.early
    joints = walk.joints
    before = walk.joints_before
    load_q12 = walk.load_q12
    lag = params.trot.lag_q8
    for at in range(JOINTS):
        goal[at] = joints[at]
    for leg in range(LEGS):
        if load_q12[leg]:
            sag_leg(params, leg, walk.hip_feet, 0, 0, load_q12[leg], goal)
        led = lag
        if stands[leg] == 0:
            led = lag >> 1
        if early[leg] == MET_NOW:
            early[leg] = MET
            led = 0
        at = leg * 3
        for joint in range(3):
            top = params.joint_top[joint]
            step = joints[at] - before[at]
            if step > top or step < -top:
                step = saturate(step, -top, top)
            goal[at] += step * led >> 8
            at += 1
    return 0
