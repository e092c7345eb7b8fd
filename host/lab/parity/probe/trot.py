"""shared/trot: its parts in states that some ticks of anything bring about, for every robot and rate."""

from shared.body.axes import POSE_AXES, Pose, Turn, Twist
from shared.runtime import zeros
from shared.sense.legs import MeasuredFeet, Sensing, sense_legs
from shared.sense.odometry import Odometry
from shared.sense.sensed import Sensed
from shared.trot import clock, estimate, feedforward, feet, ground, react, state, steer, trot

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
LAG = Range(-(1 << 16), 1 << 16)  # of a foot, lu
SENSED = Sensed()
FEET = MeasuredFeet()
SENSING = Sensing()
ODOMETRY = Odometry()
TROT = state.Trot(FEET, ODOMETRY)
SWINGS = (TROT.stance, TROT.early_contact, TROT.apex, TROT.load_q12, TROT.swing_top, TROT.residual_x, TROT.residual_z)
HELD_UP = (TROT.held_up, TROT.rises_first, TROT.stuck_score, TROT.held_up_in_row)
LAGS = (TROT.peak_lag, TROT.usual_lag, TROT.shortened, TROT.residual_rate)
STATE = (TROT.state, TROT.feet, TROT.lift_offs) + SWINGS + HELD_UP + LAGS
PAST = (TROT.before, TROT.joints_before, TROT.last_pose, TROT.past_x, TROT.past_z)
EXPECTED = (TROT.expected_x_q4, TROT.expected_z_q4)
RESIDUALS = (TROT.residual_x, TROT.residual_z, TROT.residual_rate)
ALL = STATE + (TROT.heights, TROT.measured, TROT.joints) + EXPECTED + PAST


def _begin():
    sensed = (SENSED.tilt, SENSED.joints, SENSED.turned, SENSED.valid)
    for block in ALL + (TROT.command, TROT.hip_feet, TROT.past_stance, GOAL, SENSING, ODOMETRY) + sensed:
        clear(block)
    state.trot_reset(PARAMS[0], TROT)


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
    """Two ticks of anything on the drawn robot; after them it mostly may walk with care, and often does."""
    params = values[0]
    if dice.below(40) == 0:
        state.trot_reset(params, TROT)
    SPEED.fill(dice)
    POSE.fill(dice)
    for axis in range(POSE_AXES):
        POSE.row[axis] >>= 3
    for _ in range(2):
        _sense(dice)
        _any_command(dice)
        for axis in range(2):
            ODOMETRY.speed[axis] = dice.bits(23) - (1 << 22) if dice.below(8) == 0 else dice.bits(17) - (1 << 16)
        sense_legs(params, SENSED.joints, SENSED.tilt[0], SENSED.tilt[1], FEET, SENSING)
        trot.trot_tick(params, TROT, SENSED, SPEED.array, POSE.array, GOAL)
    TROT.state.careful = dice.bits(2) - 2


def _any_command(dice):
    """Mostly walk, mostly level, mostly with the robot's own lift."""
    command = TROT.command
    command.moving = 1 if dice.bits(5) else 0
    command.balance = 1 if dice.bits(3) else 0
    command.height = 0 if dice.bits(2) else INT30.any(dice)


def _moving(values, dice):
    """The same, with a foot of the drawn leg in the air, mostly far from where it was sent."""
    _live(values, dice)
    leg = values[2]
    TROT.stance[leg] = 0
    TROT.early_contact[leg] = 0
    TROT.state.known = 100
    TROT.state.swing_q15 = SHARE.any(dice)
    TROT.rises_first[leg] = dice.bits(1)
    for foot in range(4):
        TROT.residual_x[foot] = dice.bits(13) - 4096
        TROT.residual_z[foot] = dice.bits(13) - 4096


def _landing(values, dice):
    """The same, but the foot stands."""
    _moving(values, dice)
    TROT.stance[values[2]] = 1


def _leg_moving(values, dice):
    """For a function without a robot in its arguments."""
    given = [ROBOT.any(dice), TROT, values[1]]
    _live(given, dice)


def _done(values, dice):
    _leg_moving([TROT, 0], dice)
    TROT.state.still_q20 = dice.bits(22)


def _moving_first(values, dice):
    """With leg FR in the air."""
    given = [values[0], TROT, 0]
    _moving(given, dice)


def _lunging(values, dice):
    """At speeds about those of a push."""
    _live(values, dice)
    for axis in range(2):
        TROT.state.measured_speed[axis] = dice.bits(20) - (1 << 19)
    TROT.state.high_left = dice.bits(1)


def _slow(values, dice):
    """About where it walks with care: at such speeds, tilts, slopes and grounds, mostly after low swings."""
    _live(values, dice)
    now = TROT.state
    for axis in range(2):
        now.foot_speed[axis] = dice.bits(16) - (1 << 15)
        now.tilt_q14[axis] = dice.bits(11) - (1 << 10)
        now.slope_q20[axis] = dice.bits(18) - (1 << 17)
    now.uneven_q4 = dice.bits(13)
    if dice.bits(2):
        now.high_left = 0


_probe = probe_with(watch=STATE, fit=_live, begin=_begin)

PROBES = (
    _probe(state, "trot_reset", (ROBOT, TROT)),
    _probe(estimate, "estimate", (ROBOT, TROT, TURNED, FLAG), watch=ALL),
    _probe(estimate, "estimate_speed", (ROBOT, TROT, TURNED)),
    _probe(estimate, "start_residual", (ROBOT, TROT), watch=EXPECTED + (TROT.residual_x,)),
    _probe(estimate, "update_residual", (ROBOT, TROT), watch=EXPECTED + RESIDUALS),
    _probe(steer, "steer", (ROBOT, TROT, SPEED, TURNED, POSE)),
    _probe(steer, "detect_push", (ROBOT, TROT), watch=(TROT.state,), fit=_lunging),
    Probe(steer, "overspeed", (Range(-(1 << 19), 1 << 19), SPEED18)),
    Probe(steer, "capture_point", (ROBOT, INT30)),
    Probe(steer, "integrate_speed", (ROBOT, SPEED18, Range(-(1 << 22), 1 << 22), Range(-(1 << 26), 1 << 26))),
    _probe(steer, "wait_for_feet", (ROBOT, TROT, POSE)),
    _probe(steer, "level_body", (ROBOT, TROT, TILT, TURNED, POSE)),
    Probe(steer, "predict_tilt", (ROBOT, Range(-8191, 8191), INT30)),
    Probe(steer, "turn_level", (Range(0, (1 << 17) - 1), INT30)),
    Probe(steer, "turn_along", (BRAD,)),
    _probe(steer, "rise", (ROBOT, TROT, POSE)),
    _probe(clock, "advance_legs", (ROBOT, TROT, FLAG)),
    _probe(clock, "hurried_step", (ROBOT, TROT), watch=()),
    _probe(clock, "advance_phase", (ROBOT, TROT, FLAG), watch=(TROT.state,)),
    _probe(clock, "stand_all", (TROT,), fit=_done),
    _probe(react, "react", (ROBOT, TROT, LEG), fit=_moving),
    _probe(react, "stands_high", (ROBOT, TROT, LEG, Range(0, 1023)), fit=_moving),
    _probe(react, "detect_held_up", (ROBOT, TROT, LEG), fit=_moving),
    _probe(react, "most_behind", (ROBOT, TROT, LEG, LAG, LAG), watch=(), fit=_moving),
    _probe(react, "strikes", (ROBOT, TROT, LEG, LAG), watch=(), fit=_moving),
    _probe(react, "may_be_late", (TROT, LEG), fit=_leg_moving),
    _probe(react, "count_held_up", (ROBOT, TROT, LEG), fit=_moving),
    _probe(react, "count_slow", (ROBOT, TROT, SPEED18, SPEED18)),
    _probe(react, "count_in_row", (TROT, LEG), fit=_leg_moving),
    _probe(react, "swing_apex", (ROBOT, TROT, LEG), fit=_moving),
    _probe(react, "shorten_swing", (TROT, LEG), fit=_leg_moving),
    _probe(react, "check_landing", (ROBOT, TROT, LEG), fit=_landing),
    _probe(react, "meet_ground", (ROBOT, TROT, LEG, Range(1, 2)), fit=_moving),
    _probe(ground, "update_slope", (ROBOT, TROT), watch=STATE + (TROT.heights,)),
    _probe(ground, "update_plane", (ROBOT, TROT, Range(1, 4), UNIT, UNIT, UNIT)),
    _probe(ground, "correct_slope", (ROBOT, TROT, FLAG, INT30), watch=(TROT.state,)),
    _probe(ground, "level_z", (TROT, LEG), watch=(), fit=_leg_moving),
    _probe(ground, "ground_z", (TROT, UNIT, UNIT), watch=(), fit=_done),
    _probe(ground, "update_uneven", (ROBOT, TROT, SHARE), watch=(TROT.state,)),
    _probe(ground, "slope_ahead_q20", (TROT,), watch=(), fit=_done),
    _probe(ground, "climbs", (ROBOT, TROT), watch=()),
    _probe(ground, "choose_care", (ROBOT, TROT), watch=(TROT.state,), fit=_slow),
    Probe(ground, "off_level", (Range(-2000, 2000),)),
    _probe(react, "choose_lift", (ROBOT, TROT)),
    _probe(react, "count_high", (ROBOT, TROT)),
    _probe(feet, "stand_feet", (ROBOT, TROT)),
    _probe(feet, "limit_push", (ROBOT, TROT, LEG), fit=_moving),
    _probe(feet, "lift_off", (TROT, LEG), fit=_leg_moving),
    Probe(feet, "cycloid_way_q15", (SHARE,)),
    Probe(feet, "held_up_way_q15", (ROBOT, SHARE)),
    _probe(feet, "draw_back", (ROBOT, TROT, LEG, SHARE), watch=(TROT.feet,), fit=_moving),
    _probe(feet, "swing_feet", (ROBOT, TROT, POSE), fit=_moving_first),
    _probe(feet, "swing_foot", (ROBOT, TROT, LEG, POSE, SHARE, SHARE), fit=_moving),
    _probe(feet, "settle_foot", (TROT, LEG, SHARE, Range(-32767, 0), SHARE), fit=_leg_moving),
    _probe(feedforward, "share_load", (ROBOT, TROT)),
    _probe(feedforward, "solve", (ROBOT, TROT), watch=(TROT.joints, TROT.hip_feet)),
    _probe(feedforward, "feed_forward", (ROBOT, TROT, GOAL), watch=(GOAL, TROT.early_contact)),
    _probe(feedforward, "compensate_friction", (ROBOT, TROT, LEG, GOAL), watch=(GOAL,)),
    _probe(trot, "trot_start", (ROBOT, TROT), watch=(TROT.feet, TROT.joints)),
    _probe(trot, "trot_tick", (ROBOT, TROT, SENSED, SPEED, POSE, GOAL), watch=ALL + (GOAL, TROT.flags), vectors=4),
    _probe(trot, "assume_level", (SENSED,), watch=(SENSED.tilt, SENSED.turned), fit=None),
    _probe(trot, "keep_past", (TROT,), watch=(TROT.past_x, TROT.past_z, TROT.past_stance), fit=_done),
    _probe(trot, "trot_done", (TROT,), fit=_done),
)
