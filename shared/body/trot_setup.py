"""The trot's numbers of one robot at one rate: a part of the robot's parameters."""

from ..record import field, part, record, vector
from ..runtime import Ints
from .axes import Twist


@record
class TrotSetup:
    """Times in ticks, lengths in lu, gains per tick. host/robot/trot_tuning.py fills it in, and says why."""

    speed_max: Twist = part(Twist, "fastest command")
    phase_step_q20: int = field("Q20 of a cycle / tick", "how fast the phase goes on, up to 2^17")
    hurried_step_q20: int = field("Q20 of a cycle / tick", "the same of one that is pushed, in swings, up to 2^18")
    pushed_speed: int = field("lf / tick", "more than this faster than told: pushed")
    hurries_high: int = field("", "1: the drives follow high swings at that pace, too")
    stance_q20: int = field("Q20 of a cycle", "share of a cycle in which a foot stands, 1/2 .. 3/4")
    landing_q20: int = field("Q20 of a cycle", "after touchdown, in which the joints still tell of a landing")
    swing_rate_q13: int = field("Q13", "cycles in a swing's length: 1 / (1 - share)")
    ahead_rate_q13: int = field("Q13", "how much earlier than its swing a foot's way along the ground ends")
    free_from_q15: int = field("Q15", "share of its swing after which a foot that was held up goes ahead")
    free_rate_q13: int = field("Q13", "swings per time in which it does, up to 2^14")
    draw_back: int = field("lu", "how far it is drawn back before that")
    swing_q8: int = field("ticks Q8", "time of a swing, up to 2^16")
    height: int = field("lu", "hips above the feet at rest")
    low_lift: int = field("lu", "top of a swing on even ground")
    high_lift: int = field("lu", "the same once something was met")
    highest_lift: int = field("lu", "the same of a foot that was held up in its last swing")
    turn_side: int = field("256 lu ticks", "how much farther behind than its mate a foot may be, per turn, up to 2^15")
    push_lag: int = field("lu", "farther behind than its mate, a foot pushes hard")
    late_lag_q8: int = field("Q8", "share by which one that goes ahead may be farther behind its mate, up to 2^12")
    high_way: int = field("lf", "way for which swings stay high")
    high_speed: int = field("lf / tick", "the fastest along x and y meanwhile")
    high_slowest: int = field("lf / tick", "slower counts as this for that way")
    neutral_q8: int = field("ticks Q8", "foothold ahead of rest, per speed")
    capture_q8: int = field("ticks Q8", "foothold further ahead, per speed that is too much")
    capture_max: int = field("lu", "of that")
    level_q12: int = field("2^-18 rad / brad Q12", "turn of the body per tick and tilt")
    raise_q16: int = field("Q16 / tick", "share of a wrong height taken back")
    odometry_q10: int = field("Q10 / tick", "how fast a measured speed is believed")
    speed_ki_q15: int = field("Q15 / tick", "integral of the speed's error")
    speed_integral_least: int = field("lf / tick", "limit of that at rest")
    heading_kp_q16: int = field("Q16 / tick", "turn per error of the heading")
    slope_q15: int = field("Q15 / tick", "how fast a slope of the ground is believed")
    rolling_q15: int = field("Q15", "speed of a round foot's centre per speed of the body")
    tilt_lead_q8: int = field("ticks Q8", "from measuring the tilt to the middle of the tick in which goals act")
    lag_q8: int = field("ticks Q8", "drives' lag: damping over stiffness")
    friction: Ints = vector(3, "brad", "what dry friction holds back of each motor, up to 2^12")
    friction_q12: int = field("Q12", "friction of the load, per what the joint gives under it, up to 2^13")
    slides_q16: int = field("Q16 / (brad / tick)", "share of that which is led per speed, up to 2^14")
    free_lag_q12: int = field("Q12 / tick", "share of the way to its reference that an unhindered foot goes")
    load_step_q12: int = field("own weight / tick Q12", "how fast a foot's expected load changes")
