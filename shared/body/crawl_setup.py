"""What is tuned of the crawl, and what of it follows from the robot's shape: a part of the robot's parameters.

Found on Caramelo (leg 240 mm, in MuJoCo, on steps of 2 to 6 cm). host/robot/crawl_tuning.py makes of this table what a
robot takes, in proportion to its leg; a robot file's table ``crawl`` changes single values of it.
"""

from ..record import field, record


@record
class CrawlSetup:
    """The third column is the value tuned, in mm, mm/s, mm/s^2 of a leg of 240 mm, ms, mrad ...; 0: from the shape.

    lu takes mm, lf / tick mm/s, lf / tick^2 and lu / s^2 mm/s^2; ticks take ms, and a share Q15 / tick, with which
    something is followed or fades, its time constant in ms; own weights (Q12) take 1/10000, other shares (Q15) 1/1000.
    Measured in simulation where no other source is named.
    """

    # Stance: where the body is to be over its feet
    stride: int = field("lu", "a third of the hip distance: front footholds lie where the hind feet want them")
    long_stride: int = field("lu", "on even ground: one and a half of that, half the hip distance")
    height: int = field("lu", "hips above the mean of the feet: 0.865 of the straightest leg")
    half_length: int = field("lu", "from the body's middle to its hips, forward")
    half_width: int = field("lu", "from the body's middle to the planes of its legs, sideways")
    reach: int = field("lu", "longest planned leg, thigh joint to foot: bent enough to feel its load")
    swing_reach: int = field("lu", "longest leg in the air, thigh joint to foot")
    folded: int = field("lu", "a leg as short as this is folded")
    payload_height: int = field("lu", "hips that much higher under full load: straighter knees", 22)
    payload_forward: int = field("lu", "centre of mass that much further forward under full load: eases rear knees", 18)
    margin: int = field("lu", "centre of mass inside every edge of the support triangle", 28)
    com_z: int = field("lu", "centre of mass above the hips", -9)
    body_acceleration: int = field("lu / s^2", "of the body's moves: the zero-moment point stays in the support", 600)
    quick_body_acceleration: int = field("lu / s^2", "of the body's moves on even ground", 1250)
    body_speed: int = field("lf / tick", "of the body up and down, and of the hips under pitch", 60)
    body_ticks: int = field("ticks", "shortest move of the body", 250)
    settle_ticks: int = field("ticks", "after a move", 40)
    share_ticks: int = field("ticks", "in which a leg takes all of its share of the load, or leaves it", 300)
    slope_share_q15: int = field("Q15", "of the feet's slope that the body pitches; the rest is left to the legs", 800)
    pitch_max: int = field("brad", "of that pitch", 300)
    free_q12: int = field("own weight", "with less a leg is free, and a foot tells of no slip: 2 N of 21.6", 925)
    diagonal_error_q12: int = field("own weight", "off on the diagonals that is good enough to lift: 4 N of 21.6", 1851)
    diagonal_gain: int = field("lf / tick", "diagonal offset per own weight on the wrong one: 0.8 mm/s per newton", 17)
    diagonal_speed: int = field("lf / tick", "of the diagonal offset, at most", 30)
    diagonal_max: int = field("lu", "the largest diagonal offset", 40)
    diagonal_ticks: int = field("ticks", "longest wait for the diagonals", 1500)
    # Swing: up, across, hanging, down
    front_lift: int = field("lu", "over unknown ground: the highest step, 60 mm, and 5", 65)
    hind_lift: int = field("lu", "over known ground: what odometry and sag err", 35)
    lift_speed: int = field("lf / tick", "the fastest upwards", 240)
    lift_acceleration: int = field("lf / tick^2", "upwards", 3000)
    lift_brake: int = field("lf / tick^2", "twice the deceleration below the apex", 5000)
    apex_speed: int = field("lf / tick", "left at the apex", 20)
    swing_ticks: int = field("ticks", "shortest way across", 120)
    swing_speed: int = field("lf / tick", "mean of the way across; the quintic's peak is 0.25 m/s", 156)
    quick_swing_speed: int = field("lf / tick", "mean of the way across on even ground; the peak is 0.94 m/s", 500)
    hang_ticks: int = field("ticks", "in which the hanging leg's tare is taken", 100)
    hang_skip_ticks: int = field("ticks", "of these without one", 60)
    hang_speed: int = field("lf / tick", "down meanwhile", 20)
    lower_acceleration: int = field("lf / tick^2", "downwards", 500)
    quick_lower_acceleration: int = field("lf / tick^2", "downwards on even ground", 3000)
    unknown_lower_speed: int = field("lf / tick", "over unknown ground: contact may come at any time", 100)
    known_lower_speed: int = field("lf / tick", "far above a foothold where a front foot has stood", 192)
    quick_lower_speed: int = field("lf / tick", "far above even ground, less for legs that would push hard", 192)
    loaded_lower_speed: int = field("lf / tick", "as soon as there is load on the foot", 60)
    near_foothold: int = field("lu", "above a foothold: there it has braked to the speed over unknown ground", 8)
    # Contact: what a leg in the air meets
    touch_q12: int = field("own weight", "above the tare: the least load of a contact, 2 N of Caramelo's 21.6", 925)
    peak_q12: int = field("own weight", "load that a contact has once, 2.7 N of 21.6", 1250)
    contact_ticks: int = field("ticks", "of load that make a contact", 60)
    highest_contact: int = field("lu", "above the expected height: higher there is none", 65)
    deepest: int = field("lu", "below the expected height: given up", 85)
    edge_height: int = field("lu", "a step's least: 10 deg over one stride are 13 mm, and 4 mm of sag", 18)
    drop_depth: int = field("lu", "below the expected height with nothing there", 24)
    edge_advance: int = field("lu", "further on after a corner: a foot stands at most its radius before it", 25)
    drop_advance: int = field("lu", "further out over a drop: 60 mm deep under a calf that slopes 33 .. 45 deg", 45)
    edge_retreat: int = field("lu", "a hind foot back off a corner, or its foothold off what may be a rim", 28)
    clear_contact: int = field("lu", "apex of another try above the contact", 20)
    clear_ground: int = field("lu", "apex of another try above the expected height", 10)
    riser_lag: int = field("lu", "a foot that far behind its command has run into a riser", 12)
    riser_retreat: int = field("lu", "back from it", 20)
    riser_skip_ticks: int = field("ticks", "of a way across before a riser can be noticed", 100)
    swing_lag_ticks: int = field("ticks", "a moving foot is that late anyway", 20)
    goal_lag_ticks: int = field("ticks", "from a goal sent to it reached", 60)
    stand_lift: int = field("lu", "the body's corner pushed up by that, the foot on its expected ground: it stands", 5)
    calf_lift: int = field("lu", "the body's corner pushed up by that: the calf stands on an edge", 9)
    sink: int = field("lu", "the body's corner down by that over a leg in the air: it tips; 5 in 99 % of the steps", 15)
    calf_clear: int = field("lu", "lift off that edge", 25)
    # Filters
    force_q15: int = field("Q15 / tick", "force on a foot: joint speeds are counts a tick, coarse at high rates", 20)
    weight_q15: int = field("Q15 / tick", "weight that is carried", 2000)
    tare_in_q15: int = field("Q15 / tick", "tare of the hanging leg", 67)
    tare_down_q15: int = field("Q15 / tick", "tare of the leg that is lowered", 400)
    slip_level_q15: int = field("Q15 / tick", "foothold along the ground, to where the foot is measured", 1000)
    slip_height_q15: int = field("Q15 / tick", "foothold's height, to where the foot is measured", 3000)
    slip_far_q15: int = field("Q15 / tick", "the same of a foot that is far off: what it stood on gave way", 200)
    slip_far: int = field("lu", "that far", 8)
    lag_q15: int = field("Q15 / tick", "servos and bus behind the pose that is wanted", 60)
    error_q15: int = field("Q15", "share of the error that the pose loop adds to the command", 300)
    integral_q15: int = field("Q15 / tick", "integral of the pose loop", 333)
    deviation_q15: int = field("Q15 / tick", "measured less wanted pose, from which a swing leg starts", 100)
    position_limit: int = field("lu", "of the pose loop's terms", 30)
    angle_limit: int = field("brad", "of the pose loop's terms", 200)
    jump_q15: int = field("Q15 / tick", "what is left of a goal's jump where a foot lifts", 150)
    land_jump_q15: int = field("Q15 / tick", "the same where it lands: it keeps its load", 600)
