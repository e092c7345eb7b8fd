"""The trot: one of four segments that feels load, ground and motion, and acts on them.

    BODY (four feet, the body moves on and sways over the coming diagonal), SWING FR + RL, BODY, SWING FL + RR

It is a table gait (shared/gait/gaits.py) whose segments are re-timed by speed, plus: sag fed forward,
speed corrected by the legs' odometry, centre of mass learnt from tipping, footholds that follow the
ground's twist, higher steps where it is rough, a body that rises with load and crouches before a leg
is straight, and that turns about the ground when it levels. A swing of 0.2 s is one and a half time
constants sqrt(height / g) of tipping: the shorter it is, the less the robot tips.

Without measured joints it walks on expectations (no odometry, the own weight); without turning
rates it holds no heading and learns no centre of mass; without attitude it does not level.
"""

from ..body.load import STANDS_Q8, Load, load_share, load_slew
from ..body.params import JOINTS, LEGS, LF_BITS, Params
from ..body.pose import POSE_X, POSE_Y, POSE_Z
from ..body.stability import support_margin
from ..gait.steps import SPEED_X, SPEED_Y, Steps
from ..gait.table import Clock, Gait
from ..num.fixed import cos_q15, mul_q15, saturate, sin_q15
from ..record import field, record, vector
from ..runtime import Ints, const, hot, zeros
from ..sense.legs import Sensing, sense_legs, sense_moved, sensing_reset
from .ground import extra_lift, follow_twist, press_feet, roughness, twist
from .navigate import Navigation, drive_as_told, follow_reference, hold, navigate_reset
from .sway import diagonal_y, next_sway, smooth_q12
from .tipping import Tipping, tip_add, tip_learn, tip_reset


@record
class TrotState:
    """What the trot feels and does about it."""

    weight_q12: int = field("own weight Q12", "measured weight")
    raised: int = field("lu", "body above the rest height")
    ahead: int = field("lu", "body ahead of the feet")
    sway: int = field("lu", "body to the left of the feet")
    sway_from: int = field("lu", "sway at the beginning of the segment")
    sway_to: int = field("lu", "sway at its end")
    twist: int = field("lf", "of the ground: how much higher it is at FR and RL than its plane")
    rough: int = field("1/16 brad", "largest tilt of late")
    lift: int = field("lu", "added to the swing's height")
    fastest: int = field("lf / tick", "largest speed; grows after a start")
    age: Ints = vector(LEGS, "ticks", "since the planned touchdown, 0 in swing, up to 1000")
    turned: Ints = vector(3, "2^-18 rad", "turn about x, y and z in this tick")
    turned_known: int = field("", "1: it is measured")
    behind: int = field("ticks", "behind the reference, BEHIND_STEP times, less those not behind")
    margin: int = field("lu", "of the centre of mass in the support")
    advice: int = field("", "ADVICE_...")
    active: int = field("", "1: the body is not where a table gait wants it")
    far: int = field("lu^2", "thigh joint to foot of the longest leg, as planned last")


ADVICE_FINE = const(0)
ADVICE_BEHIND = const(1)  # held up: another gait may get on
ADVICE_TILTED = const(2)  # tilted: another gait may be safer

BEHIND_STEP = const(3)  # a held-up trot lurches on and slips back: behind in a third of the time is too much
_TILT_ADVICE = const(17472)  # 6 deg, 1/16 brad
_WEIGHT_LEAST_Q12 = const(3277)  # 0.8 of the own weight: the measurement reads low, not the robot light
_WEIGHT_MOST_Q12 = const(9830)  # 2.4 times: beyond it the legs are too weak anyway
_AGE_MAX = const(1000)


class Trot:
    """All that the trot remembers, preallocated; the planner holds one."""

    def __init__(self, params: Params):
        self.sensing = Sensing()
        self.load = Load()
        self.nav = Navigation()
        self.tip = Tipping()
        self.state = TrotState()
        self.body = zeros(JOINTS)  # the planned feet in the body
        self.contact = zeros(LEGS)  # 1: the foot surely stands
        self.weights = zeros(LEGS)  # 256: the foot is planned to stand
        trot_reset(params, self)


@hot
def trot_reset(params: Params, walk: Trot) -> int:
    """Forget everything: the own weight, a level ground, no motion; return 0."""
    trot = walk.state
    load = walk.load
    trot.weight_q12 = 4096
    trot.raised = 0
    trot.ahead = 0
    trot.sway = 0
    trot.twist = 0
    trot.rough = 0
    trot.turned_known = 0
    trot.margin = 0
    trot.advice = ADVICE_FINE
    trot.active = 0
    trot.far = 0
    for leg in range(LEGS):
        trot.age[leg] = 0
        load.force_q12[leg] = 0
    for axis in range(3):
        trot.turned[axis] = 0
    sensing_reset(walk.sensing)
    navigate_reset(walk.nav)
    tip_reset(walk.tip, 1)
    trot_start(params, walk)
    return 0


@hot
def trot_start(params: Params, walk: Trot) -> int:
    """Begin to walk from a stand: slowly, the reference where the robot is; return 0."""
    trot = walk.state
    trot.fastest = params.start_speed
    trot.sway_from = trot.sway
    trot.sway_to = trot.sway
    trot.behind = 0
    trot.lift = 0
    navigate_reset(walk.nav)
    tip_reset(walk.tip, 0)
    return 0


@hot
def feel_legs(params: Params, walk: Trot, joints: Ints, known: int, roll_brad: int, pitch_brad: int) -> int:
    """Take the measured ``joints`` (12 brad, if ``known``): feet, odometry, weight; return 1 if they were.

    roll, pitch: brad within +-32768. The weight follows the sum of the feet's forces, slowly and only while all feet
    surely stand; it reads 5 to 18 % low in simulation. Intermediates below those of sense_legs.
    """
    trot = walk.state
    sensing = walk.sensing
    contact = walk.contact
    if known == 0:
        sensing.known = 0
        sensing.moved_x = 0
        sensing.moved_y = 0
        return 0
    sense_legs(params, joints, roll_brad, pitch_brad, walk.sensing)
    youngest = _AGE_MAX
    for leg in range(LEGS):
        age = trot.age[leg]
        contact[leg] = 0
        if age > params.stand_ticks:
            contact[leg] = 1
        if age < youngest:
            youngest = age
    sense_moved(walk.sensing, walk.contact)
    if youngest > params.stand_ticks and params.sags:
        force = sensing.force_q12[0] + sensing.force_q12[1] + sensing.force_q12[2] + sensing.force_q12[3]
        force = saturate(force, _WEIGHT_LEAST_Q12, _WEIGHT_MOST_Q12) - trot.weight_q12
        trot.weight_q12 += force * params.load_gain_q15 + 0x4000 >> 15
    return 1


@hot
def feel_ground(
    params: Params, walk: Trot, steps: Steps, roll_brad: int, pitch_brad: int, plane_roll: int, plane_pitch: int
) -> int:
    """Follow the ground's twist and roughness, and set the footholds' heights by them; return the twist, lu.

    roll, pitch: the measured tilt; plane_...: how the feet's plane lies against the level, all brad.
    """
    trot = walk.state
    sensing = walk.sensing
    contact = walk.contact
    trot.rough = roughness(params, trot.rough, roll_brad, pitch_brad)
    if sensing.known and contact[0] and contact[1] and contact[2] and contact[3]:
        trot.twist = follow_twist(params, trot.twist, twist(walk.sensing, plane_roll, plane_pitch))
    press_feet(params, steps, trot.twist >> LF_BITS)
    return trot.twist >> LF_BITS


@hot
def drive_speed(params: Params, walk: Trot, speed: Ints, drive: Ints) -> int:
    """Write the corrected speeds for this tick into ``drive`` (3 values); return 1 if they are corrected.

    Without odometry the speeds are the commanded ones.
    """
    trot = walk.state
    sensing = walk.sensing
    nav = walk.nav
    trot.fastest = saturate(trot.fastest + params.start_slew, 0, 0x7FFFF)
    if sensing.known < 2:
        navigate_reset(walk.nav)
        drive_as_told(speed, drive)
        return 0
    follow_reference(params, speed, sensing.moved_x, sensing.moved_y, trot.turned[2], trot.turned_known, walk.nav)
    hold(params, speed, trot.sway, walk.nav, drive)
    step = -1
    if nav.x > params.leg_length * 3 << LF_BITS - 5:
        step = BEHIND_STEP
    trot.behind = saturate(trot.behind + step, 0, 0xFFFF)
    trot.advice = ADVICE_FINE
    if trot.behind > params.advice_ticks:
        trot.advice = ADVICE_BEHIND
    elif trot.rough > _TILT_ADVICE:
        trot.advice = ADVICE_TILTED
    return 1


@hot
def retime(params: Params, gait: Gait, speed: Ints) -> int:
    """Give the gait's segments the lengths for the present speed; return the ticks of half a cycle.

    The body moves on in the swings at half its mean speed: faster in the swing tips more, slower jerks. Only at the
    start of a segment. Intermediates: 2^19 * 2^10.
    """
    now = speed[SPEED_X]
    if now < 0:
        now = -now
    if speed[SPEED_Y] < 0:
        now -= speed[SPEED_Y]
    else:
        now += speed[SPEED_Y]
    span = params.fast_speed - params.slow_speed
    if span < 1:
        span = 1
    now = saturate(now - params.slow_speed, 0, span)
    body = params.body_slow + ((params.body_fast - params.body_slow) * now + (span >> 1)) // span
    swing = params.swing_slow + ((params.swing_fast - params.swing_slow) * now + (span >> 1)) // span
    for pair in range(0, 4, 2):
        stance = gait.rows[pair]
        stance.ticks = body
        stance.advance_q4 = (body << 4) + (swing << 3)
        flight = gait.rows[pair + 1]
        flight.ticks = swing
        flight.advance_q4 = swing << 3
        for leg in range(LEGS):
            if flight.start[leg]:
                flight.start[leg] = swing
                flight.swing_q10[leg] = swing << 9
    for leg in range(LEGS):
        gait.stance_q10[leg] = (body + swing << 11) - (swing << 9)
    gait.cycle = body + swing << 1
    return body + swing


@hot
def begin_segment(params: Params, walk: Trot, gait: Gait, clock: Clock, speed: Ints, drive: Ints) -> int:
    """At a segment's first tick: its length, and where to sway (BODY) or how high to lift (SWING); return 0.

    speed, drive: 3 values each, the reference's and the corrected speed. Intermediates: 2^19 * 2^10.
    """
    trot = walk.state
    nav = walk.nav
    tip = walk.tip
    half = retime(params, gait, speed)
    segment = clock.segment
    if segment & 1:
        trot.lift = extra_lift(params, trot.rough, nav.x, drive[SPEED_X])
        return 0
    front = 1 - (segment >> 1)
    flight = gait.rows[1]
    swing = flight.ticks
    ahead_q1 = saturate((half << 1) - (swing >> 1), 0, 0x3FF)
    ahead = saturate(drive[SPEED_X], -0x7FFFF, 0x7FFFF) * ahead_q1 >> LF_BITS + 1
    com_x = params.com_x + (tip.com_x >> LF_BITS)
    com_y = params.com_y + (tip.com_y >> LF_BITS)
    line = diagonal_y(walk.body, front, 3 - front, saturate(ahead, -32767, 32767), com_x)
    trot.sway_from = trot.sway
    trot.sway_to = next_sway(params, trot.sway, line, com_y)
    return 0


@hot
def sway_body(params: Params, walk: Trot, gait: Gait, clock: Clock, walking: int) -> int:
    """Move the body's sway by one tick: with the BODY segment when walking, else slowly to the middle; return it, lu.

    Range of the way: 3/8 of a leg, so 2^14 * 2^12 in the product.
    """
    trot = walk.state
    if walking == 0:
        step = params.sway_slew
        trot.sway -= saturate(trot.sway, -step, step)
    elif clock.segment & 1 == 0:
        share = smooth_q12(clock.tick + 1, gait.rows[clock.segment].ticks)
        trot.sway = trot.sway_from + ((trot.sway_to - trot.sway_from) * share >> 12)
    return trot.sway


@hot
def learn_centre(params: Params, walk: Trot, clock: Clock) -> int:
    """Sum up how the robot tips over a swing and learn from it; return the tip it learnt from, 2^-18 rad, else 0.

    What is sensed lags, so a swing's sum begins and ends P_TIP_TICKS after the swing does. Nothing is learnt
    without turning rates, nor in the plane, where nothing tips about a diagonal.
    """
    trot = walk.state
    if trot.turned_known == 0 or params.lateral_q12 == 0:
        return 0
    tick = clock.tick + 1
    swings = clock.segment & 1
    late = params.tip_ticks
    if (swings and tick >= late) or (swings == 0 and tick < late):
        tip_add(walk.tip, trot.turned[0], trot.turned[1])
    elif swings == 0 and tick == late:
        front = clock.segment >> 1
        return tip_learn(params, walk.body, front, 3 - front, walk.tip)
    return 0


@hot
def raise_body(params: Params, walk: Trot, own: int) -> int:
    """Move height and lead of the body by one tick; return 1 while they are not those of a table gait.

    own: 1 for its own stance, 0 to go back to the rest stance. More load: up to 1/10 of the leg higher, which
    shortens the knee's lever. A leg near straight has no strength left: the body crouches by what is too long.
    Intermediates: squares of a leg, below 2^30.
    """
    trot = walk.state
    load = walk.load
    up = params.height_slew
    wanted = 0
    ahead = 0
    if own:
        ahead = params.body_forward
        leg = params.leg_length
        wanted = params.body_raise + saturate((trot.weight_q12 - 4096) * (leg >> 3) >> 12, 0, leg // 10)
        longest = params.leg_longest
        over = (trot.far - longest * longest) // (2 * longest + 1)
        if over > 0:
            wanted = saturate(wanted, -0xFFFF, trot.raised - over)
        elif wanted > trot.raised:
            wanted = saturate(wanted, -0xFFFF, trot.raised - (over >> 1))
    trot.raised += saturate(wanted - trot.raised, -2 * up, up)
    trot.ahead += saturate(ahead - trot.ahead, -up, up)
    trot.active = own
    if trot.raised or trot.ahead or trot.sway or load.force_q12[0] or load.force_q12[1]:
        trot.active = 1
    if load.force_q12[2] or load.force_q12[3] or trot.twist:
        trot.active = 1
    return trot.active


@hot
def pose_body(params: Params, walk: Trot, roll_brad: int, pitch_brad: int, posed: Ints) -> int:
    """Add lead, sway and height to the pose, and turn it about the ground below the body instead of its middle.

    roll, pitch: the part of the pose that levels the body, brad. Turning about the hips would move the centre of
    mass off the feet on a slope. Returns 0. Intermediates: 32767 * 32767 + 2^14.
    """
    trot = walk.state
    height = saturate(trot.raised - params.legs[0].rest[2], 0, 32767)
    cosine = cos_q15(pitch_brad)
    posed[POSE_X] += trot.ahead + mul_q15(height, sin_q15(pitch_brad))
    posed[POSE_Y] += trot.sway - mul_q15(height, mul_q15(sin_q15(roll_brad), cosine))
    posed[POSE_Z] += trot.raised - height + mul_q15(height, mul_q15(cos_q15(roll_brad), cosine))
    return 0


@hot
def share_weight(params: Params, walk: Trot, reached: Ints, swinging: int, own: int) -> int:
    """Share the weight out over the standing feet, slew it, and tell the stability margin; return the margin, lu.

    reached: 12 lu from the hips; swinging: bits. own 0: no foot is expected to share_weight, so the sag fades.
    """
    trot = walk.state
    body = walk.body
    weights = walk.weights
    tip = walk.tip
    at = 0
    for leg in range(LEGS):
        hip = params.legs[leg].hip
        x = reached[at] + hip[0]
        y = reached[at + 1] + hip[1]
        if x > 32767 or x < -32767 or y > 32767 or y < -32767:
            x = saturate(x, -32767, 32767)
            y = saturate(y, -32767, 32767)
        body[at] = x
        body[at + 1] = y
        at += 3
        weights[leg] = 0
        if swinging >> leg & 1:
            trot.age[leg] = 0
        else:
            weights[leg] = STANDS_Q8
            if trot.age[leg] < _AGE_MAX:
                trot.age[leg] += 1
    com_x = params.com_x + (tip.com_x >> LF_BITS)
    com_y = params.com_y + (tip.com_y >> LF_BITS)
    planar = 0
    if params.lateral_q12 == 0:
        planar = 1
    weight = 0
    if own:
        weight = trot.weight_q12
    if trot.active:
        load_share(walk.body, walk.weights, com_x, com_y, weight, planar, walk.load)
        load_slew(walk.load, trot.weight_q12 * params.load_slew_q12 >> 12)
    trot.margin = support_margin(walk.body, walk.weights, com_x, com_y)
    return trot.margin
