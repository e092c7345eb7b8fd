"""shared/trot: its parts in states that some ticks of anything bring about, for every robot and rate."""

from shared.body.axes import POSE_AXES, Pose, Turn, Twist
from shared.runtime import zeros
from shared.sense.legs import MeasuredFeet, Sensing, sense_legs
from shared.sense.odometry import Odometry
from shared.sense.sensed import Sensed
from shared.trot import clock, feel, feet, ground, lead, react, state, steer, trot

from .draw import Range
from .draws import BRAD, LEG
from .probe import Block, Pick, Probe
from .robots import PARAMS

PARTS = ("clock", "feel", "feet", "ground", "lead", "react", "state", "steer", "trot")

FLAG = Range(0, 1)
INT30 = Range(-(1 << 30), (1 << 30) - 1)
SHARE = Range(0, 32767)
PLACE = Range(-32767, 32767)
SPEED18 = Range(-(1 << 18), 1 << 18)
SPEED = Block(Twist(), (3, SPEED18))
POSE = Block(Pose(), (3, Range(-8191, 8191)), (3, BRAD))
TURNED = Block(Turn(), (3, INT30))
TILT = Block(zeros(2), (2, BRAD))
GOAL = zeros(12)
SENSED = Sensed()
FEET = MeasuredFeet()
SENSING = Sensing()
ODOMETRY = Odometry()
WALK = state.Trot(FEET, ODOMETRY)
ROBOT = Pick(*PARAMS)
LEGS_OF = (WALK.stands, WALK.met, WALK.tops, WALK.load_q12, WALK.ascent, WALK.residual_x, WALK.residual_z)
HELD = (WALK.held, WALK.frees, WALK.jams, WALK.rows, WALK.peak, WALK.usual, WALK.short)
STATE = (WALK.state, WALK.feet, WALK.starts) + LEGS_OF + HELD
PAST = (WALK.before, WALK.joints_before, WALK.posed, WALK.past_x, WALK.past_z)
FREE = (WALK.free_x_q4, WALK.free_z_q4)
ALL = STATE + (WALK.heights, WALK.measured, WALK.joints) + FREE + PAST


def _begin():
    sensed = (SENSED.tilt, SENSED.joints, SENSED.turned, SENSED.valid)
    for block in ALL + (WALK.wish, WALK.hip_feet, WALK.past_stands, GOAL, SENSING, ODOMETRY) + sensed:
        _clear(block)
    state.trot_reset(PARAMS[0], WALK)


def _clear(block):
    row = Block(block).row
    for at in range(len(row)):
        row[at] = 0


def _sense(dice):
    """Joints mostly about where they were sent, sometimes anywhere; rates and tilts mostly small."""
    valid = SENSED.valid
    valid.joints = valid.tilt = valid.turned = 1 if dice.bits(5) else 0
    far = dice.below(12) == 0
    for joint in range(12):
        SENSED.joints[joint] = BRAD.any(dice) if far else GOAL[joint] + dice.bits(9) - 256
    for axis in range(2):
        SENSED.tilt[axis] = BRAD.any(dice) if far else dice.bits(10) - 512
    for axis in range(3):
        SENSED.turned[axis] = INT30.any(dice) if far else dice.bits(11) - 1024


def _live(values, dice):
    """Two ticks of anything on the drawn robot."""
    params = values[0]
    if dice.below(40) == 0:
        state.trot_reset(params, WALK)
    SPEED.fill(dice)
    POSE.fill(dice)
    for axis in range(POSE_AXES):
        POSE.row[axis] >>= 3
    for _ in range(2):
        _sense(dice)
        _wish(dice)
        for axis in range(2):
            ODOMETRY.speed[axis] = dice.bits(23) - (1 << 22) if dice.below(8) == 0 else dice.bits(17) - (1 << 16)
        sense_legs(params, SENSED.joints, SENSED.tilt[0], SENSED.tilt[1], FEET, SENSING)
        trot.trot_tick(params, WALK, SENSED, SPEED.array, POSE.array, GOAL)


def _wish(dice):
    """Mostly walk, mostly level, mostly with the robot's own lift."""
    wish = WALK.wish
    wish.moving = 1 if dice.bits(5) else 0
    wish.balance = 1 if dice.bits(3) else 0
    wish.height = 0 if dice.bits(2) else INT30.any(dice)


def _moving(values, dice):
    """The same, with a foot of the drawn leg in the air, mostly far from where it was sent."""
    _live(values, dice)
    leg = values[2]
    WALK.stands[leg] = 0
    WALK.met[leg] = 0
    WALK.state.known = 100
    WALK.state.swing_q15 = SHARE.any(dice)
    WALK.frees[leg] = dice.bits(1)
    for foot in range(4):
        WALK.residual_x[foot] = dice.bits(13) - 4096
        WALK.residual_z[foot] = dice.bits(13) - 4096


def _landing(values, dice):
    """The same, but the foot stands."""
    _moving(values, dice)
    WALK.stands[values[2]] = 1


def _leg_moving(values, dice):
    """For a function without a robot in its arguments."""
    given = [PARAMS[dice.below(len(PARAMS))], WALK, values[1]]
    _live(given, dice)


def _done(values, dice):
    _leg_moving([WALK, 0], dice)
    WALK.state.still_q20 = dice.bits(22)


def _moving_first(values, dice):
    """With leg FR in the air."""
    given = [values[0], WALK, 0]
    _moving(given, dice)


def _lunging(values, dice):
    """At speeds about those of a push."""
    _live(values, dice)
    for axis in range(2):
        WALK.state.seen[axis] = dice.bits(20) - (1 << 19)
    WALK.state.high_left = dice.bits(1)


def _probe(name, module, arguments, watch=STATE, fit=_live, vectors=1):
    return Probe(name, getattr(module, name), arguments, watch=watch, fit=fit, begin=_begin, vectors=vectors)


PROBES = (
    _probe("trot_reset", state, (ROBOT, WALK)),
    _probe("feel", feel, (ROBOT, WALK, TURNED, FLAG), ALL),
    _probe("see_speed", feel, (ROBOT, WALK, TURNED)),
    _probe("free_feet", feel, (ROBOT, WALK), FREE),
    _probe("see_residual", feel, (ROBOT, WALK), FREE + (WALK.residual_x, WALK.residual_z)),
    _probe("steer", steer, (ROBOT, WALK, SPEED, TURNED, POSE)),
    _probe("feel_push", steer, (ROBOT, WALK), (WALK.state,), fit=_lunging),
    Probe("overspeed", steer.overspeed, (Range(-(1 << 19), 1 << 19), Range(-(1 << 18), 1 << 18))),
    Probe("capture_point", steer.capture_point, (ROBOT, INT30)),
    Probe("reach_speed", steer.reach_speed, (ROBOT, SPEED18, Range(-(1 << 22), 1 << 22), Range(-(1 << 26), 1 << 26))),
    _probe("wait_for_feet", steer, (ROBOT, WALK, POSE)),
    _probe("lean", steer, (ROBOT, WALK, TILT, TURNED, POSE)),
    Probe("tilt_to_come", steer.tilt_to_come, (ROBOT, Range(-8191, 8191), INT30)),
    Probe("turn_level", steer.turn_level, (ROBOT, BRAD)),
    Probe("turn_along", steer.turn_along, (BRAD,)),
    _probe("rise", steer, (ROBOT, WALK, POSE)),
    _probe("go_on", clock, (ROBOT, WALK, FLAG)),
    _probe("hurried_step", clock, (ROBOT, WALK), ()),
    _probe("move_phase", clock, (ROBOT, WALK, FLAG), (WALK.state,)),
    _probe("stand_all", clock, (WALK,), fit=_done),
    _probe("react", react, (ROBOT, WALK, LEG), fit=_moving),
    _probe("held_up", react, (ROBOT, WALK, LEG), fit=_moving),
    _probe("may_be_late", react, (WALK, LEG), fit=_leg_moving),
    _probe("count_held", react, (ROBOT, WALK, LEG), fit=_moving),
    _probe("count_row", react, (WALK, LEG), fit=_leg_moving),
    _probe("swing_top", react, (ROBOT, WALK, LEG), fit=_moving),
    _probe("give_way", react, (WALK, LEG), fit=_leg_moving),
    _probe("land", react, (ROBOT, WALK, LEG), fit=_landing),
    _probe("meet_ground", react, (ROBOT, WALK, LEG, Range(1, 2)), fit=_moving),
    _probe("feel_slope", ground, (ROBOT, WALK), STATE + (WALK.heights,)),
    _probe("follow_feet", ground, (ROBOT, WALK, Range(1, 4), PLACE, PLACE, PLACE)),
    _probe("follow_slope", ground, (ROBOT, WALK, FLAG, INT30), (WALK.state,)),
    _probe("level_z", ground, (WALK, LEG), (), fit=_leg_moving),
    _probe("ground_z", ground, (WALK, PLACE, PLACE), (), fit=_done),
    _probe("follow_uneven", ground, (ROBOT, WALK, SHARE), (WALK.state,)),
    _probe("rise_q20", ground, (WALK,), (), fit=_done),
    _probe("climbs", ground, (ROBOT, WALK), ()),
    _probe("lift_on", react, (ROBOT, WALK)),
    _probe("count_high", react, (ROBOT, WALK)),
    _probe("stand_feet", feet, (ROBOT, WALK)),
    _probe("spare", feet, (ROBOT, WALK, LEG), fit=_moving),
    _probe("lift_off", feet, (WALK, LEG), fit=_leg_moving),
    Probe("cycloid_way_q15", feet.cycloid_way_q15, (SHARE,)),
    Probe("free_way_q15", feet.free_way_q15, (ROBOT, SHARE)),
    _probe("draw_back", feet, (ROBOT, WALK, LEG, SHARE), (WALK.feet,), fit=_moving),
    _probe("swing_feet", feet, (ROBOT, WALK, POSE), fit=_moving_first),
    _probe("swing_foot", feet, (ROBOT, WALK, LEG, POSE, SHARE, SHARE), fit=_moving),
    _probe("settle_foot", feet, (WALK, LEG, Range(0, 32767), Range(-32767, 0), SHARE), fit=_leg_moving),
    _probe("share_load", lead, (ROBOT, WALK)),
    _probe("solve", lead, (ROBOT, WALK), (WALK.joints, WALK.hip_feet)),
    _probe("lead", lead, (ROBOT, WALK, GOAL), (GOAL, WALK.met)),
    _probe("slide", lead, (ROBOT, WALK, LEG, GOAL), (GOAL,)),
    _probe("trot_start", trot, (ROBOT, WALK), (WALK.feet, WALK.joints)),
    _probe("trot_tick", trot, (ROBOT, WALK, SENSED, SPEED, POSE, GOAL), ALL + (GOAL, WALK.flags), vectors=4),
    _probe("forget", trot, (SENSED,), (SENSED.tilt, SENSED.turned), fit=None),
    _probe("keep_past", trot, (WALK,), (WALK.past_x, WALK.past_z, WALK.past_stands), fit=_done),
    _probe("trot_done", trot, (WALK,), fit=_done),
)
