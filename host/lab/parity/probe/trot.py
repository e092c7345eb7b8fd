"""shared/trot: its parts in states that some ticks of anything bring about, for every robot and rate."""

from shared.body.axes import POSE_AXES, Pose, Turn, Twist
from shared.runtime import zeros
from shared.sense.legs import MeasuredFeet, Sensing, sense_legs
from shared.sense.odometry import Odometry
from shared.sense.sensed import Sensed
from shared.trot import clock, feel, feet, ground, lead, react, state, steer, trot

from .draw import BRAD, FLAG, INT30, LEG, SHARE, UNIT, Range
from .draws import ROBOT
from .probe import Block, Probe, probe_with
from .robots import PARAMS
from .row import clear

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
SWINGS = (WALK.stance, WALK.early_contact, WALK.apex, WALK.load_q12, WALK.ascent_lag, WALK.residual_x, WALK.residual_z)
HELD_UP = (WALK.held_up, WALK.rises_first, WALK.stuck_score, WALK.held_up_in_row)
LAGS = (WALK.peak_lag, WALK.usual_lag, WALK.shortened)
STATE = (WALK.state, WALK.feet, WALK.lift_offs) + SWINGS + HELD_UP + LAGS
PAST = (WALK.before, WALK.joints_before, WALK.last_pose, WALK.past_x, WALK.past_z)
FREE = (WALK.free_x_q4, WALK.free_z_q4)
ALL = STATE + (WALK.heights, WALK.measured, WALK.joints) + FREE + PAST


def _begin():
    sensed = (SENSED.tilt, SENSED.joints, SENSED.turned, SENSED.valid)
    for block in ALL + (WALK.wish, WALK.hip_feet, WALK.past_stance, GOAL, SENSING, ODOMETRY) + sensed:
        clear(block)
    state.trot_reset(PARAMS[0], WALK)


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
    WALK.stance[leg] = 0
    WALK.early_contact[leg] = 0
    WALK.state.known = 100
    WALK.state.swing_q15 = SHARE.any(dice)
    WALK.rises_first[leg] = dice.bits(1)
    for foot in range(4):
        WALK.residual_x[foot] = dice.bits(13) - 4096
        WALK.residual_z[foot] = dice.bits(13) - 4096


def _landing(values, dice):
    """The same, but the foot stands."""
    _moving(values, dice)
    WALK.stance[values[2]] = 1


def _leg_moving(values, dice):
    """For a function without a robot in its arguments."""
    given = [ROBOT.any(dice), WALK, values[1]]
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
        WALK.state.measured_speed[axis] = dice.bits(20) - (1 << 19)
    WALK.state.high_left = dice.bits(1)


_probe = probe_with(watch=STATE, fit=_live, begin=_begin)

PROBES = (
    _probe(state, "trot_reset", (ROBOT, WALK)),
    _probe(feel, "feel", (ROBOT, WALK, TURNED, FLAG), watch=ALL),
    _probe(feel, "see_speed", (ROBOT, WALK, TURNED)),
    _probe(feel, "free_feet", (ROBOT, WALK), watch=FREE),
    _probe(feel, "see_residual", (ROBOT, WALK), watch=FREE + (WALK.residual_x, WALK.residual_z)),
    _probe(steer, "steer", (ROBOT, WALK, SPEED, TURNED, POSE)),
    _probe(steer, "feel_push", (ROBOT, WALK), watch=(WALK.state,), fit=_lunging),
    Probe(steer, "overspeed", (Range(-(1 << 19), 1 << 19), SPEED18)),
    Probe(steer, "capture_point", (ROBOT, INT30)),
    Probe(steer, "reach_speed", (ROBOT, SPEED18, Range(-(1 << 22), 1 << 22), Range(-(1 << 26), 1 << 26))),
    _probe(steer, "wait_for_feet", (ROBOT, WALK, POSE)),
    _probe(steer, "lean", (ROBOT, WALK, TILT, TURNED, POSE)),
    Probe(steer, "tilt_to_come", (ROBOT, Range(-8191, 8191), INT30)),
    Probe(steer, "turn_level", (ROBOT, BRAD)),
    Probe(steer, "turn_along", (BRAD,)),
    _probe(steer, "rise", (ROBOT, WALK, POSE)),
    _probe(clock, "go_on", (ROBOT, WALK, FLAG)),
    _probe(clock, "hurried_step", (ROBOT, WALK), watch=()),
    _probe(clock, "move_phase", (ROBOT, WALK, FLAG), watch=(WALK.state,)),
    _probe(clock, "stand_all", (WALK,), fit=_done),
    _probe(react, "react", (ROBOT, WALK, LEG), fit=_moving),
    _probe(react, "see_held_up", (ROBOT, WALK, LEG), fit=_moving),
    _probe(react, "may_be_late", (WALK, LEG), fit=_leg_moving),
    _probe(react, "count_held_up", (ROBOT, WALK, LEG), fit=_moving),
    _probe(react, "count_in_row", (WALK, LEG), fit=_leg_moving),
    _probe(react, "swing_apex", (ROBOT, WALK, LEG), fit=_moving),
    _probe(react, "give_way", (WALK, LEG), fit=_leg_moving),
    _probe(react, "land", (ROBOT, WALK, LEG), fit=_landing),
    _probe(react, "meet_ground", (ROBOT, WALK, LEG, Range(1, 2)), fit=_moving),
    _probe(ground, "feel_slope", (ROBOT, WALK), watch=STATE + (WALK.heights,)),
    _probe(ground, "follow_feet", (ROBOT, WALK, Range(1, 4), UNIT, UNIT, UNIT)),
    _probe(ground, "follow_slope", (ROBOT, WALK, FLAG, INT30), watch=(WALK.state,)),
    _probe(ground, "level_z", (WALK, LEG), watch=(), fit=_leg_moving),
    _probe(ground, "ground_z", (WALK, UNIT, UNIT), watch=(), fit=_done),
    _probe(ground, "follow_uneven", (ROBOT, WALK, SHARE), watch=(WALK.state,)),
    _probe(ground, "rise_q20", (WALK,), watch=(), fit=_done),
    _probe(ground, "climbs", (ROBOT, WALK), watch=()),
    _probe(react, "lift_on", (ROBOT, WALK)),
    _probe(react, "count_high", (ROBOT, WALK)),
    _probe(feet, "stand_feet", (ROBOT, WALK)),
    _probe(feet, "spare", (ROBOT, WALK, LEG), fit=_moving),
    _probe(feet, "lift_off", (WALK, LEG), fit=_leg_moving),
    Probe(feet, "cycloid_way_q15", (SHARE,)),
    Probe(feet, "free_way_q15", (ROBOT, SHARE)),
    _probe(feet, "draw_back", (ROBOT, WALK, LEG, SHARE), watch=(WALK.feet,), fit=_moving),
    _probe(feet, "swing_feet", (ROBOT, WALK, POSE), fit=_moving_first),
    _probe(feet, "swing_foot", (ROBOT, WALK, LEG, POSE, SHARE, SHARE), fit=_moving),
    _probe(feet, "settle_foot", (WALK, LEG, SHARE, Range(-32767, 0), SHARE), fit=_leg_moving),
    _probe(lead, "share_load", (ROBOT, WALK)),
    _probe(lead, "solve", (ROBOT, WALK), watch=(WALK.joints, WALK.hip_feet)),
    _probe(lead, "lead", (ROBOT, WALK, GOAL), watch=(GOAL, WALK.early_contact)),
    _probe(lead, "slide", (ROBOT, WALK, LEG, GOAL), watch=(GOAL,)),
    _probe(trot, "trot_start", (ROBOT, WALK), watch=(WALK.feet, WALK.joints)),
    _probe(trot, "trot_tick", (ROBOT, WALK, SENSED, SPEED, POSE, GOAL), watch=ALL + (GOAL, WALK.flags), vectors=4),
    _probe(trot, "forget", (SENSED,), watch=(SENSED.tilt, SENSED.turned), fit=None),
    _probe(trot, "keep_past", (WALK,), watch=(WALK.past_x, WALK.past_z, WALK.past_stance), fit=_done),
    _probe(trot, "trot_done", (WALK,), fit=_done),
)
