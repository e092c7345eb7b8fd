"""From planned feet to goals: what the joints give under load is added before, and what drives lag behind."""

from ..body.compliance import sag
from ..body.legs import legs_inverse
from ..body.params import JOINTS, LEGS, LF_BITS, Params
from ..num.fixed import saturate, sin_q15
from ..runtime import Ints, const, hot
from .react import MET, MET_NOW
from .state import Stride

_ONE_Q12 = const(4096)


@hot
def share_load(params: Params, walk: Stride) -> int:
    """Move what each foot is expected to carry towards an even share of those that stand; return that, Q12."""
    state = walk.state
    stands = walk.stands
    load_q12 = walk.load_q12
    step = params.stride.load_step_q12
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
def solve(params: Params, walk: Stride) -> int:
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
def lead(params: Params, walk: Stride, goal: Ints) -> int:
    """Write 12 goals, brad: the joints, what they give under their load, and where they will be a lag later; return 0.

    Of a foot in the air half of the lag is led: all of it shakes a robot of soft joints. Intermediates: 2^15 * 2^14.
    """
    stands = walk.stands
    early = walk.early
    joints = walk.joints
    before = walk.joints_before
    load_q12 = walk.load_q12
    lag = params.stride.lag_q8
    for at in range(JOINTS):
        goal[at] = joints[at]
    for leg in range(LEGS):
        if load_q12[leg]:
            carry(params, leg, walk.hip_feet, load_q12[leg], goal)
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


@hot
def carry(params: Params, leg: int, hip_feet: Ints, load_q12: int, goal: Ints) -> int:
    """Add to the three goals of ``leg`` what its joints give under a vertical load on its foot; return 0.

    load: Q12 of the own weight, 0 .. 4096. Torque is the load times its lever: the foot from the hip's axis, from the
    thigh's and from the knee. A calf's motor on the body leaves the thigh's only what acts at the knee (paper B).
    Intermediates: 2^15 * 2^12; sag's.
    """
    setup = params.stride
    limb = params.legs[leg]
    at = leg * 3
    knee = -(limb.thigh_length * sin_q15(goal[at + 1]) >> 15)
    above = knee * load_q12 >> 12
    below = (hip_feet[at] - knee) * load_q12 >> 12
    around = hip_feet[at + 1] * load_q12 >> 12
    goal[at] -= sag(around, setup.sag_q16[0])
    if params.coupled:
        give = sag(above, setup.sag_q16[1])
        goal[at + 1] += give
        goal[at + 2] += sag(below, setup.sag_q16[2]) - give
    else:
        goal[at + 1] += sag(above + below, setup.sag_q16[1])
        goal[at + 2] += sag(below, setup.sag_q16[2])
    return 0
