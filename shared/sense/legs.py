"""What the legs feel: where the feet are, where their contacts have rolled, how much each carries.

Forward kinematics of the measured joints (paper A eqs 1-6) give the feet in the body; roll and pitch turn them into
level axes. A foot is round, so its contact rolls on by its radius times the calf's turn. The joints sag in proportion
to their load, so (goal - measured) times stiffness is the torque, and two torques give the foot's force along the leg:

    F = (ak t3 - ac t2') / (-L2 L3 sin q3),  ak = L2 cos q2, ac = L3 cos(q2 + q3), t2' = t2 - t3

with t2' = t2 where the calf's motor is on the body (paper B).
"""

from ..body.axes import Point, Spot
from ..body.feet import Feet
from ..body.legs import legs_forward
from ..body.params import CALF, JOINTS, LEGS, THIGH, Params
from ..num.fixed import cos_q15, saturate, sin_q15
from ..record import field, parts, record, vector
from ..runtime import Ints, const, hot, zeros


class MeasuredFeet:
    """The feet by the measured joints, in the body, from the middle of the hips."""

    def __init__(self) -> None:
        self.now = Feet()  # lu
        self.before = Feet()  # lu, a tick ago
        self.waves = zeros(2 * JOINTS)  # Q15: sines of hip, thigh and thigh + calf of each leg, then their cosines


@record
class Sensing:
    """What the legs feel of feet, forces and motion."""

    level: list[Point] = parts(LEGS, Point, "each foot from the middle of the hips, in axes that are level")
    force_q12: Ints = vector(LEGS, "own weight Q12", "each foot's force along its leg")
    rolled: list[Spot] = parts(LEGS, Spot, "each foot in level axes, less the way that it rolled")
    joints: Ints = vector(JOINTS, "brad", "the joints in the tick before")
    known: int = field("ticks", "for how long the joints have been measured without a gap, up to 100")
    sent_at: int = field("", "place of the next goals in the ring, 0 .. 15")
    sent: Ints = vector(16 * JOINTS, "brad", "ring of the goals of the last 16 ticks")
    roll: int = field("brad", "of this tick")
    pitch: int = field("brad", "of this tick")
    roll_sine_q13: int = field("Q13", "sine of roll")
    roll_cosine_q13: int = field("Q13", "cosine of roll")
    pitch_sine_q13: int = field("Q13", "sine of pitch")
    pitch_cosine_q13: int = field("Q13", "cosine of pitch")
    rolling_q12: int = field("lu / brad Q12", "how far a foot rolls per turn of its calf")
    answered: int = field("", "place in the ring of the goals that the joints now answer; -1: none yet")


_BRAD_TO_RAD_Q26 = const(6434)  # 2 pi / 65536 in Q26 = 6433.98
_ERROR_MAX = const(4095)  # brad, 22 deg: beyond it a drive gives all it has anyway
_TURN_MAX = const(4095)  # brad per tick
_FORCE_MAX_Q12 = const(16383)
_STRAIGHT = const(1024)  # |L2 L3 sin q3| / 2^13 below which the leg is too straight to show a force


@hot
def sensing_reset(sensing: Sensing) -> None:
    """Forget all that was measured, and the goals."""
    sensing.known = 0
    sensing.sent_at = 0
    sensing.answered = -1
    for leg in range(LEGS):
        sensing.force_q12[leg] = 0
        sensing.level[leg].x = 0
        sensing.level[leg].y = 0
        sensing.level[leg].z = 0


@hot
def keep_sent(sensing: Sensing, joints: Ints) -> None:
    """Keep the goals that are sent in this tick (12 brad)."""
    at = sensing.sent_at * JOINTS
    for joint in range(JOINTS):
        sensing.sent[at + joint] = joints[joint]
    sensing.sent_at = sensing.sent_at + 1 & 15


@hot
def sense_legs(
    params: Params, joints: Ints, roll_brad: int, pitch_brad: int, feet: MeasuredFeet, sensing: Sensing
) -> None:
    """Take 12 measured joints, update feet and forces.

    joints: brad, within +-32768; roll, pitch: brad, 0 where they are not known. ``level`` within 6 lu + 2e-4 of
    the foot's distance. ``force_q12`` answers the goals of ``params.delay_ticks`` ticks ago, within +-16383; it
    is 0 until there are any. Intermediates: 113510 * 8192 + 2^12 < 2^30.
    """
    sensing.roll = roll_brad
    sensing.pitch = pitch_brad
    sensing.roll_sine_q13 = sin_q15(roll_brad) >> 2
    sensing.roll_cosine_q13 = cos_q15(roll_brad) >> 2
    sensing.pitch_sine_q13 = sin_q15(pitch_brad) >> 2
    sensing.pitch_cosine_q13 = cos_q15(pitch_brad) >> 2
    sensing.rolling_q12 = params.foot_radius * _BRAD_TO_RAD_Q26 >> 14
    sensing.answered = -1
    if sensing.known > params.delay_ticks:
        sensing.answered = (sensing.sent_at - params.delay_ticks & 15) * JOINTS
    for leg in range(LEGS):
        now = feet.now.legs[leg]
        before = feet.before.legs[leg]
        before.x = now.x
        before.y = now.y
        before.z = now.z
    legs_forward(params, joints, feet.waves, feet.now)
    level_feet(joints, feet.now, sensing)
    if sensing.answered >= 0:
        foot_forces(params, joints, feet.waves, sensing)
    else:
        for leg in range(LEGS):
            sensing.force_q12[leg] = 0
    for joint in range(JOINTS):
        sensing.joints[joint] = joints[joint]
    if sensing.known < 100:
        sensing.known += 1


@hot
def level_feet(joints: Ints, feet: Feet, sensing: Sensing) -> None:
    """Write the measured feet in level axes into ``level``, and where they would be without rolling into ``rolled``.

    feet: lu within +-65534, because leg and hip are within 32767 lu each. ``rolled``: error at most 1/600 of the way
    rolled + 1 lu. Part of sense_legs. Intermediates: 113510 * 8192 + 2^12 and 5147 * 32768.
    """
    sine = sensing.pitch_sine_q13
    cosine = sensing.pitch_cosine_q13
    roll_sine = sensing.roll_sine_q13
    roll_cosine = sensing.roll_cosine_q13
    at = 0
    for leg in range(LEGS):
        foot = feet.legs[leg]
        level = sensing.level[leg]
        rolled = sensing.rolled[leg]
        ahead = foot.x * cosine + foot.z * sine + 0x1000 >> 13
        z = foot.z * cosine - foot.x * sine + 0x1000 >> 13
        aside = foot.y * roll_cosine - z * roll_sine + 0x1000 >> 13
        level.x = ahead
        level.y = aside
        level.z = foot.y * roll_sine + z * roll_cosine + 0x1000 >> 13
        calf_pitch = (joints[at + THIGH] + joints[at + CALF] + sensing.pitch + 0x8000 & 0xFFFF) - 0x8000
        hip = (joints[at] + sensing.roll + 0x8000 & 0xFFFF) - 0x8000
        rolled.x = ahead - (sensing.rolling_q12 * calf_pitch >> 12)
        rolled.y = aside + (sensing.rolling_q12 * hip >> 12)
        at += 3


@hot
def foot_forces(params: Params, joints: Ints, waves: Ints, sensing: Sensing) -> None:
    """Write the force of each foot along its leg from the errors of thigh and calf, Q12, +-16383.

    A calf motor on the body answers the errors of thigh and calf together. A leg within about 2 deg of straight gives
    0. Intermediates: two halves of 32767 * 32767.
    """
    at = 0
    for leg in range(LEGS):
        sent = sensing.answered + at
        thigh = joints[at + THIGH]
        calf = joints[at + CALF]
        error = sensing.sent[sent + THIGH] - thigh
        turned = thigh - sensing.joints[at + THIGH]
        above = joint_torque(params.stiff_q8.thigh, params.damp_q8.thigh, error, turned)
        if params.coupled == 0:
            error = 0
            turned = 0
        error += sensing.sent[sent + CALF] - calf
        turned += calf - sensing.joints[at + CALF]
        below = joint_torque(params.stiff_q8.calf, params.damp_q8.calf, error, turned)
        if params.coupled == 0:
            above = saturate(above - below, -32767, 32767)
        limb = params.legs[leg]
        arms = -((limb.thigh_length * limb.calf_length >> 13) * sin_q15(calf) + 0x4000 >> 15)
        force = 0
        if arms >= _STRAIGHT or arms <= -_STRAIGHT:
            knee_drop = limb.thigh_length * waves[at + JOINTS + THIGH] + 0x4000 >> 15
            calf_drop = limb.calf_length * waves[at + JOINTS + CALF] + 0x4000 >> 15
            force = ((knee_drop * below >> 1) - (calf_drop * above >> 1)) // arms
        sensing.force_q12[leg] = saturate(force, -_FORCE_MAX_Q12, _FORCE_MAX_Q12)
        at += 3


@hot
def joint_torque(stiff_q8: int, damp_q8: int, error_brad: int, turned_brad: int) -> int:
    """Return a joint's torque, stiffness * error - damping * speed, in own weight times lu, +-32767.

    stiff, damp: ``params.stiff_q8`` and ``damp_q8`` of the joint; error: goal minus measured; turned: in one tick; each
    limited to +-4095 brad. Intermediates: 4095 * 32767 * 2.
    """
    if error_brad > _ERROR_MAX:
        error_brad = _ERROR_MAX
    elif error_brad < -_ERROR_MAX:
        error_brad = -_ERROR_MAX
    if turned_brad > _TURN_MAX:
        turned_brad = _TURN_MAX
    elif turned_brad < -_TURN_MAX:
        turned_brad = -_TURN_MAX
    torque = stiff_q8 * error_brad - damp_q8 * turned_brad >> 8
    if torque > 32767:
        return 32767
    if torque < -32767:
        return -32767
    return torque
