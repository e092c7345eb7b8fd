"""From planned feet to goals: compensates in advance for sag under load, for friction and for the drives' lag."""

from ..body.compliance import sag_leg
from ..body.legs import legs_inverse
from ..body.params import CALF, JOINTS, LEGS, LF_BITS, THIGH, Params
from ..num.fixed import saturate
from ..runtime import Ints, const, hot
from .react import EARLY, EARLY_NOW
from .state import Trot

_ONE_Q12 = const(4096)
_CALM = const(3)  # bits: while the robot stands, an eighth of the step


@hot
def share_load(params: Params, trot: Trot) -> None:
    """Move the load that each foot is expected to carry towards an even share among the stance feet.

    Slowly while the robot is not to move, so that it does not jerk when it has just stood up.
    """
    step = params.trot.load_step_q12
    if trot.command.moving == 0:
        step = (step >> _CALM) + 1
    share = 0
    if trot.state.standing:
        share = _ONE_Q12 // trot.state.standing
    for leg in range(LEGS):
        wanted = 0
        if trot.stance[leg]:
            wanted = share
        gap = wanted - trot.load_q12[leg]
        if gap > step or gap < -step:
            gap = saturate(gap, -step, step)
        trot.load_q12[leg] += gap


@hot
def solve(params: Params, trot: Trot) -> int:
    """Write the joints that reach the planned feet; return why some feet were brought into reach, or 0."""
    for joint in range(JOINTS):
        trot.joints_before[joint] = trot.joints[joint]
    for leg in range(LEGS):
        hip = params.legs[leg].hip
        foot = trot.feet.legs[leg]
        from_hip = trot.hip_feet.legs[leg]
        from_hip.x = (foot.x >> LF_BITS) - hip.x
        from_hip.y = (foot.y >> LF_BITS) - hip.y
        from_hip.z = (foot.z >> LF_BITS) - hip.z
    return legs_inverse(params, trot.hip_feet, trot.work, trot.joints)


@hot
def feed_forward(params: Params, trot: Trot, goal: Ints) -> None:
    """Write 12 goals, brad: the joints, plus their sag under load, plus their motion during the drives' lag.

    For a swing foot only half of the lag is compensated: all of it shakes a robot with soft joints. Friction is
    compensated while feet carry the expected load: not after something was met. Intermediates: 2^15 * 2^14.
    """
    lag = params.trot.lag_q8
    most = params.joint_speed_safe
    least = -most
    for leg in range(LEGS):
        at = leg * 3
        goal[at] = trot.joints[at]
        goal[at + THIGH] = trot.joints[at + THIGH]
        goal[at + CALF] = trot.joints[at + CALF]
        if trot.load_q12[leg]:
            sag_leg(params, leg, trot.hip_feet, 0, 0, trot.load_q12[leg], goal)
        lead = lag
        if trot.early_contact[leg] == EARLY_NOW:
            trot.early_contact[leg] = EARLY
            lead = 0
        elif trot.stance[leg] == 0:
            lead = lag >> 1
        elif trot.state.high_left == 0:
            compensate_friction(params, trot, leg, goal)
        for joint in range(3):
            step = trot.joints[at] - trot.joints_before[at]
            if step > most or step < least:
                step = saturate(step, -params.joint_speed_max[joint], params.joint_speed_max[joint])
            goal[at] += step * lead >> 8
            at += 1


@hot
def compensate_friction(params: Params, trot: Trot, leg: int, goal: Ints) -> None:
    """Add to the goals of a stance leg the part of its joints' motion that friction holds back. Part of feed_forward.

    That is dry friction plus a share of the load, which shows as the sag that ``goal`` already includes. A slow joint
    gets less of it, so that a joint at rest is not sent to and fro. A calf motor on the body feels thigh + calf.
    Intermediates: 2^16 * 2^14, 2^13 * 2^14, 2^15 * 2^12.
    """
    setup = params.trot
    friction = setup.friction
    friction_rate_q16 = setup.friction_rate_q16
    joints = trot.joints
    before = trot.joints_before
    at = leg * 3
    step = 0
    given = 0
    ahead = 0
    for joint in range(3):
        if params.coupled == 0 or joint < CALF:
            step = 0
            given = 0
            ahead = 0
        step += joints[at] - before[at]
        given += goal[at] - joints[at]
        held = given
        if held < 0:
            held = -held
        held = friction[joint] + (held * setup.load_friction_q12 >> 12)
        share_q12 = step * friction_rate_q16 >> 4
        if share_q12 > _ONE_Q12 or share_q12 < -_ONE_Q12:
            share_q12 = saturate(share_q12, -_ONE_Q12, _ONE_Q12)
        ahead = (share_q12 * held >> 12) - ahead
        goal[at] += ahead
        at += 1
