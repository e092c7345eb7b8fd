"""The robot as one block of integers: what the host fills in and the core reads.

``host/scale.py`` is the only writer. Units: ``lu`` is the robot's length unit, 2^-LENGTH_SHIFT m;
``lf`` is lu/256, used where small steps add up; ``brad`` is 1/65536 turn; ``yaw18`` is
2^-18 rad. Speeds are per tick of the planner, so a block belongs to one rate.
"""

from ..record import field, part, parts, record, vector
from ..runtime import Ints, const
from .crawl_setup import CrawlSetup

LEGS = const(4)
JOINTS = const(12)
FR = const(0)
FL = const(1)
RR = const(2)
RL = const(3)



@record
class Gains:
    """A balance's gains, as shared/num/pid.py takes them."""

    kp_q12: int = field("Q12", "proportional gain")
    ki_q16: int = field("Q16", "integral gain times the tick")
    kd_q10: int = field("Q10", "derivative gain over the tick")



@record
class Leg:
    """One leg; in the frame of its hip where no other is named."""

    hip_length: int = field("lu", "hip offset, + left, - right")
    thigh_length: int = field("lu", "thigh")
    calf_length: int = field("lu", "calf")
    knee: int = field("", "-1 knee behind the hip (elbow), +1 in front (knee)")
    longest: int = field("lu", "floor of the longest hip-foot distance within the calf's limits")
    shortest: int = field("lu", "ceiling of the shortest within them")
    outer_sq: int = field("", "(L2 + L3)^2")
    inner_sq: int = field("", "(L2 - L3)^2")
    half_diff: int = field("", "(L2^2 - L3^2) / 2")
    lowest: Ints = vector(3, "", "lowest hip, thigh, calf angle, brad")
    highest: Ints = vector(3, "", "highest")
    hip: Ints = vector(3, "", "the hip in the body, lu")
    rest: Ints = vector(3, "", "the foot in the body at rest, lu")
    clearance: int = field("lu", "the highest a trot's foot is put, from its hip (negative)")




@record
class Params:
    """One robot at one rate of its planner."""

    rate_hz: int = field("", "planner ticks a second, 20 .. 500")
    length_shift: int = field("", "lu = 2^-shift m")
    speed_max: Ints = vector(3, "lf / tick", "speed max")
    speed_slew: Ints = vector(3, "lf / tick^2", "speed slew")
    pose_max: Ints = vector(6, "", "x, y, z in lu; roll, pitch, yaw in brad")
    pose_slew: Ints = vector(6, "", ", per tick")
    joint_step: int = field("brad / tick", "largest joint speed while rising and sitting down")
    sit_z: int = field("lu", "foot below the hip when seated (negative)")
    gains: list[Gains] = parts(2, Gains, "of the balance: of a gait's table, and of the trot that feels")
    integral_max: int = field("brad", "limit of the integral term")
    balance_max: int = field("brad", "limit of roll and pitch correction together")
    stride_max: int = field("lu", "longest way of a foot along the ground in one stance")
    balance_on: int = field("", "1: balance acts unless the command says otherwise")
    joint_top: Ints = vector(3, "", "hip, thigh, calf; brad / tick, the fastest the motor turns its joint")
    legs: list[Leg] = parts(LEGS, Leg, "FR, FL, RR, RL")
    sag_q16: Ints = vector(3, "", "hip, thigh, calf; brad of sag that is fed forward, per lu of lever at own weight")
    stiff_q8: Ints = vector(3, "own weight times lu", "per brad of joint error")
    damp_q8: Ints = vector(3, "own weight times lu", "per brad a tick of joint speed")
    coupled: int = field("", "1: the calf's motor is on the body and sets thigh + calf (paper B)")
    sags: int = field("", "1: the joints give under load, so their error tells the load")
    com_x: int = field("lu", "centre of mass in the body at rest")
    com_y: int = field("lu", "com y")
    foot_radius: int = field("lu", "foot radius")
    sent_ticks: int = field("", "age of the goals that the measured joints answer, ticks, 0 .. 15")
    load_slew_q12: int = field("of the own weight", "per tick: how fast a foot's expected load moves")
    leg_length: int = field("lu", "thigh + calf of leg FR")
    lateral_q12: int = field("", "share of the sideways shift over the support, 0 in the plane")
    body_raise: int = field("lu", "body above the rest height")
    body_forward: int = field("lu", "body ahead of the feet")
    leg_longest: int = field("lu", "hip to foot in the leg's plane, beyond which the body crouches")
    height_slew: int = field("", "lu / tick upwards; twice as fast downwards")
    start_speed: int = field("lf / tick", "the fastest of the first step")
    start_slew: int = field("lf / tick^2", "how the fastest grows")
    slow_speed: int = field("lf / tick", "up to which the segments have their slow lengths")
    fast_speed: int = field("lf / tick", "from which they have their fast ones")
    body_slow: int = field("", "ticks on four feet")
    body_fast: int = field("", "body fast")
    swing_slow: int = field("", "ticks on two feet")
    swing_fast: int = field("", "swing fast")
    stand_ticks: int = field("", "from a foot's planned touchdown until it surely stands")
    tip_ticks: int = field("", "from a goal to its effect on the attitude")
    load_gain_q15: int = field("per tick", "of the measured weight")
    warp_gain_q15: int = field("per tick", "of the ground's twist")
    press: int = field("lu / tick", "how fast a foothold's height is corrected")
    hold_q16: int = field("speed per error", "ticks^-1: position and heading")
    rough_decay_q15: int = field("per tick", "of the remembered tilt")
    late_ticks: int = field("", "lag behind the reference that is normal, ticks of the speed")
    sway_slew: int = field("lu / tick", "back to the middle when standing")
    tilt_max: int = field("brad", "roll or pitch beyond which the robot has fallen")
    tilt_ticks: int = field("", "for so long")
    advice_ticks: int = field("", "how long trouble lasts before another gait is advised")
    read_step: int = field("brad", "how far a joint's reading may be from the one before")
    tilt_step: int = field("brad", "how far roll and pitch may be")
    joint_near: int = field("brad / tick that every joint of a leg can turn", "whatever the others do")
    crawl: CrawlSetup = part(CrawlSetup, "the crawl over obstacles")



LF_BITS = const(8)  # lf = lu / 2^8
