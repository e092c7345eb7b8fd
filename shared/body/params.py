"""The robot as the core reads it: a record that the host fills in.

``host/robot/scale.py`` is the only writer. Units: ``lu`` is the robot's length unit, 2^-LENGTH_SHIFT m;
``lf`` is lu/256, used where small steps add up; ``brad`` is 1/65536 turn; ``yaw18`` is
2^-18 rad. Speeds are per tick of the planner, so the record belongs to one rate.
"""

from ..record import Axes, field, part, parts, record
from ..runtime import const
from .axes import Point, Pose, Twist
from .crawl_setup import CrawlSetup
from .trot_setup import TrotSetup

LEGS = const(4)
JOINTS = const(12)
FR = const(0)
FL = const(1)
RR = const(2)
RL = const(3)
THIGH = const(1)  # places of a leg's joints after its hip's
CALF = const(2)


@record
class Gains:
    """A balance's gains, as shared/num/pid.py takes them."""

    kp_q12: int = field("Q12", "proportional gain")
    ki_q16: int = field("Q16", "integral gain times the tick")
    kd_q10: int = field("Q10", "derivative gain over the tick")


@record
class LegJoints(Axes):
    """A value for each joint of a leg."""

    hip: int = field("", "of the hip")
    thigh: int = field("", "of the thigh")
    calf: int = field("", "of the calf")


@record
class Leg:
    """One leg; in the frame of its hip where no other is named."""

    hip_length: int = field("lu", "L1, + left, - right")
    thigh_length: int = field("lu", "L2")
    calf_length: int = field("lu", "L3")
    knee: int = field("", "-1 knee behind the hip (elbow), +1 in front (knee)")
    longest: int = field("lu", "floor of the longest hip-foot distance within the calf's limits")
    shortest: int = field("lu", "ceiling of the shortest within them")
    outer_sq: int = field("lu^2", "(L2 + L3)^2")
    inner_sq: int = field("lu^2", "(L2 - L3)^2")
    half_diff: int = field("lu^2", "(L2^2 - L3^2) / 2")
    lowest: LegJoints = part(LegJoints, "joint limits, brad")
    highest: LegJoints = part(LegJoints, "joint limits, brad")
    hip: Point = part(Point, "the hip in the body")
    rest: Point = part(Point, "the foot in the body at rest")
    folded: LegJoints = part(LegJoints, "its joints when folded beside a robot that lies on its belly, brad")
    clearance: int = field("lu", "highest place of a foot under a gait's table, from its hip (negative)")


@record
class Params:
    """One robot at one rate of its planner."""

    rate_hz: int = field("1/s", "planner ticks, 20 .. 500")
    average_q10: int = field("Q10 / tick", "share of a new value in averages over 0.2 s")
    length_shift: int = field("", "lu = 2^-shift m")
    speed_max: Twist = part(Twist, "largest speeds")
    speed_slew: Twist = part(Twist, "largest change of the speeds, lf / tick^2, yaw18 / tick^2")
    pose_max: Pose = part(Pose, "largest body pose")
    pose_slew: Pose = part(Pose, "largest change of the pose, lu / tick, brad / tick")
    joint_speed_slow: int = field("brad / tick", "largest joint speed while rising and sitting down")
    sit_z: int = field("lu", "foot below the hip when seated (negative)")
    gains: Gains = part(Gains, "of the balance over a gait's table")
    integral_max: int = field("brad", "limit of the balance's integral term")
    balance_max: int = field("brad", "limit of the roll and of the pitch correction as a whole")
    stride_max: int = field("lu", "longest travel of a foot along the ground in one stance")
    joint_speed_max: LegJoints = part(LegJoints, "the fastest that the motor turns its joint, brad / tick")
    legs: list[Leg] = parts(LEGS, Leg, "FR, FL, RR, RL")
    sag_q16: LegJoints = part(LegJoints, "sag that is fed forward, per lever at own weight, brad / lu Q16")
    stiff_q8: LegJoints = part(LegJoints, "stiffness: torque per joint error, own weight lu / brad Q8")
    damp_q8: LegJoints = part(LegJoints, "damping: torque per joint speed, own weight lu tick / brad Q8")
    coupled: int = field("", "1: the calf's motor is on the body and sets thigh + calf (paper B)")
    com_x: int = field("lu", "centre of mass in the body at rest, forward")
    com_y: int = field("lu", "centre of mass in the body at rest, left")
    foot_radius: int = field("lu", "of the round foot")
    delay_ticks: int = field("ticks", "age of the goals that the measured joints answer, 0 .. 15")
    leg_length: int = field("lu", "thigh + calf of leg FR")
    lateral_q12: int = field("Q12", "share of the sideways shift over the support, 0 in the plane")
    tilt_max: int = field("brad", "roll or pitch beyond which the robot has fallen")
    tilt_ticks: int = field("ticks", "for which it must be so tilted")
    read_step: int = field("brad", "a joint's reading is odd if it is farther from the one before")
    tilt_step: int = field("brad", "a reading of roll or pitch is odd if it is farther from the one before")
    joint_speed_safe: int = field("brad / tick", "what any joint of a leg can turn, whatever its other joints do")
    crawl: CrawlSetup = part(CrawlSetup, "the crawl over obstacles")
    trot: TrotSetup = part(TrotSetup, "the trot")


LF_BITS = const(8)  # lf = lu / 2^8
