"""The trot's numbers of one robot at one rate: a part of the robot's parameters."""

from ..record import field, part, record, vector
from ..runtime import Ints
from .axes import Twist


@record
class TrotSetup:
    """Times in ticks, lengths in lu, gains per tick. host/robot/trot_tuning.py fills it in, and says why."""

    speed_max: Twist = part(Twist, "fastest command")
    phase_step_q20: int = field("Q20 of a cycle / tick", "how far the phase advances, up to 2^17")
    hurried_step_q20: int = field("Q20 of a cycle / tick", "the same in swings while the robot is pushed, up to 2^18")
    pushed_speed: int = field("lf / tick", "a robot is pushed if faster than commanded by more than this")
    hurries_high: int = field("", "1: the drives can follow high swings at that pace, too")
    stance_q20: int = field("Q20 of a cycle", "share of a cycle in which a foot stands, 1/2 .. 3/4")
    landing_q20: int = field("Q20 of a cycle", "after touchdown, while the joints still show the landing")
    swing_rate_q13: int = field("Q13", "cycle over swing time: 1 / (1 - stance share)")
    ahead_rate_q13: int = field("Q13", "swing time over the time in which the foot moves along the ground")
    rise_first_q15: int = field("Q15", "share of its swing after which a foot that was held up goes ahead")
    rise_first_rate_q13: int = field("Q13", "swing time over the time in which it goes ahead, up to 2^14")
    draw_back: int = field("lu", "how far such a foot is drawn back before that")
    swing_q8: int = field("ticks Q8", "time of a swing, up to 2^16")
    height: int = field("lu", "hips above the feet at rest")
    low_lift: int = field("lu", "apex of a swing on even ground")
    high_lift: int = field("lu", "apex after something was met")
    highest_lift: int = field("lu", "apex of a foot that was held up in its last swing")
    turn_side: int = field("256 lu ticks", "how much farther behind its mate a foot may be, per turn, up to 2^15")
    push_lag: int = field("lu", "a foot farther than this behind its mate pushes hard")
    late_lag_q8: int = field("Q8", "share by which a foot that goes ahead may be farther behind its mate, up to 2^12")
    high_distance: int = field("lf", "for which swings stay high")
    high_speed: int = field("lf / tick", "limit of the speed along x and y while swings are high")
    high_slowest: int = field("lf / tick", "a lower speed counts as this when that distance is counted")
    neutral_q8: int = field("ticks Q8", "foothold ahead of rest, per speed")
    capture_q8: int = field("ticks Q8", "capture step, per speed that is too high")
    capture_max: int = field("lu", "longest capture step")
    level_kp_q12: int = field("2^-18 rad / brad Q12", "turn of the body per tick and tilt")
    careful_speed: int = field("lf / tick", "up to this speed a robot walks with care on uneven ground")
    careful_kp_q12: int = field("2^-18 rad / brad Q12", "then: turn of the body per tick and tilt, below 2^17")
    careful_lead_q12: int = field("brad / (2^-18 rad / tick) Q12", "then: how far ahead a tilt is foreseen, up to 2^13")
    careful_lift: int = field("lu", "then: apex of a swing")
    careful_step_q20: int = field("Q20 of a cycle / tick", "then: how far the phase advances while all feet stand")
    height_kp_q16: int = field("Q16 / tick", "share of a height error that is corrected")
    speed_filter_q10: int = field("Q10 / tick", "share of a new measured speed in the filtered one")
    speed_ki_q15: int = field("Q15 / tick", "integral gain for the speed's error")
    speed_integral_least: int = field("lf / tick", "limit of the integral at commanded speed 0")
    heading_kp_q16: int = field("Q16 / tick", "turn per error of the heading")
    slope_gain_q15: int = field("Q15 / tick", "gain with which the slope of the ground is updated")
    rolling_q15: int = field("Q15", "speed of a round foot's centre per speed of the body")
    tilt_lead_q8: int = field("ticks Q8", "how far ahead a tilt is foreseen, at most until goals act")
    lag_q8: int = field("ticks Q8", "lag of the drives: damping over stiffness")
    friction: Ints = vector(3, "brad", "dry friction of each motor, as the joint error that overcomes it, up to 2^12")
    load_friction_q12: int = field("Q12", "friction of the load, per sag of the joint, up to 2^13")
    friction_rate_q16: int = field("Q16 / (brad / tick)", "share of friction compensated, per speed, up to 2^14")
    response_q12: int = field("Q12 / tick", "share of the way to its planned place that an unhindered foot goes")
    load_step_q12: int = field("own weight / tick Q12", "how fast a foot's expected load changes")
