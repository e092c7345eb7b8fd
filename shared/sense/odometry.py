"""Where the robot has walked to, by its legs: a loaded foot stays where it is, so the body moves against it.

In the body's level axes a foot's contact is at n now, and this point of the foot was at b a tick ago: b - n is how far
the foot's centre went, less what it rolled. If the body turned by t about z meanwhile, this foot shows the body's
shift, in axes turned by half of t (J turns by a quarter turn):

    d = b - n - t J (b + n) / 2,    t = (wz cos(pitch) - wx sin(pitch)) / cos(roll)

The shift is the mean of d over the feet, weighted by the square of the load that each carries at both ends of the tick:
a foot that lands within the tick has come a part of its way through the air. Near touchdown and lift-off the joints'
errors show the load better than the plan does. The turn is the gyroscope's; where there is none, in the plane, and
while the robot stands, when a gyroscope would drift, it is the feet's. Then t in the shift is averaged over 0.2 s: with
the turn of a single tick, two feet that disagree would count alike, whatever they carry. Slip stays in the result, and
so does the error of the gyroscope's bias: ``odometry_spread`` tells how much that is.
"""

from ..body.axes import Spot, Turn
from ..body.params import LEGS, Params
from ..num.fixed import cos_q15, saturate, sin_q15
from ..record import field, part, parts, record, vector
from ..runtime import Ints, const, hot
from .legs import Sensing
from .sensed import Sensed


@record
class Odometry:
    """Place and heading since the start, x ahead and y left of where the body was then, and how fast the body moves.

    The place is limited to +-2^30 lu (8 km where a lu is 2^-17 m), and so is the way; the heading counts 2^30 turns.
    """

    place: Spot = part(Spot, "of the middle of the hips")
    place_fraction: Spot = part(Spot, "its fraction of a lu, lu Q16")
    turns: int = field("turns", "whole turns to the left")
    heading: int = field("2^-24 turn", "beyond the whole turns, -2^23 .. 2^23 - 1")
    heading_fraction: int = field("2^-35 turn", "its fraction of a unit")
    speed: Spot = part(Spot, "of the body, averaged over 0.2 s, lf / tick")
    turning: int = field("2^-24 rad / tick", "about z, averaged over 0.2 s")
    known: int = field("", "1: ``rolled`` is of the tick before")
    gyro: int = field("", "1: the turn is the gyroscope's, 0: the feet's")
    rolled: list[Spot] = parts(LEGS, Spot, "``Sensing.rolled`` of the tick before")
    moved: list[Spot] = parts(LEGS, Spot, "b - n of each foot that counts, lu")
    arm: list[Spot] = parts(LEGS, Spot, "(b + n) / 2 of each foot that counts, 2 lu")
    moved_mean: Spot = part(Spot, "the feet's mean, lu Q2")
    arm_mean: Spot = part(Spot, "the feet's mean, 2 lu")
    stance_ticks: Ints = vector(LEGS, "ticks", "0: the foot swings; delay_ticks + 2: it stands; changes by 1 per tick")
    carried_q12: int = field("own weight Q12", "sum of the feet's forces; a foot that lands counts only if it presses")
    load_q6: Ints = vector(LEGS, "own weight Q6", "load of each foot a tick ago")
    weight: Ints = vector(LEGS, "", "weight of each foot in the mean; their sum is 253 .. 256 or 0")
    walked: int = field("lu", "distance walked, at most an eighth too long")
    slip: int = field("lu", "sum of how far the feet differed from their mean")
    heading_sigma_q26: int = field("rad Q26", "error of the heading for what was walked (one sigma)")
    heading_spread: Spot = part(Spot, "error of the place if the heading is off by that, lf")
    scale_spread: Spot = part(Spot, "error of the place if the way is counted too long or too short (one sigma), lu")
    place_spread: int = field("lu", "error of the place in any direction, besides these (one sigma)")


_FAR = const(0x3FFF0000)
_SUM_MAX = const(0x3F000000)  # of sums that grow by up to 2^24 in a tick: 15.75 rad Q26
_LEAST_LOAD_Q6 = const(16)  # a quarter: the feet of a robot that stands on them never carry less together
_MOVED_MAX = const(8191)  # lu, of a foot in a tick
_ARM_MAX = const(16383)
_TURN_MAX = const(0x8000)  # 2^-18 rad / tick, the attitude's limit
_TO_HEADING = const(20861)  # 2^35 / (2 pi) / 2^18 = 20860.76
_HALF_TURN = const(0x800000)
_BIAS_Q26 = const(8784)  # 0.0075 deg/s: an MPU6050's noise, 0.05 deg/s rms, over the second in which the bias is learnt


@hot
def odometry_lost(odometry: Odometry) -> None:
    """Pause, because the legs do not stand or their joints are unknown; odometry later goes on from here, at rest."""
    odometry.known = 0
    odometry.turning = 0
    odometry.speed.x = 0
    odometry.speed.y = 0


@hot
def odometry_restart(odometry: Odometry) -> None:
    """Start again, at place and heading 0."""
    odometry_lost(odometry)
    odometry.turns = 0
    odometry.heading = 0
    odometry.walked = 0
    odometry.slip = 0
    odometry.heading_sigma_q26 = 0
    odometry.place.x = 0
    odometry.place.y = 0
    odometry.heading_spread.x = 0
    odometry.heading_spread.y = 0


@hot
def odometry_step(
    params: Params, sensing: Sensing, sensed: Sensed, swinging: int, walks: int, odometry: Odometry
) -> None:
    """Take one tick in which the robot stands or walks, after ``sensing`` has taken it.

    swinging: legs that are planned to swing, bits. walks 0: the robot stands. After 10 m over feet that do not slip the
    place is right within 2 mm, the heading within 0.05 deg. Intermediates: 2^15 * 2^14 * sqrt 2.
    """
    total = weigh_feet(params, sensing, swinging, odometry)
    measure_feet(sensing, total, odometry)
    if odometry.known:
        turn = 0
        odometry.gyro = 0
        if walks and sensed.valid.turned and sensed.valid.tilt and params.lateral_q12:
            odometry.gyro = 1
            turn = turn_of_body(sensing, sensed.turned)
        elif total:
            turn = turn_of_feet(odometry)
        move_body(params, turn, total, walks, odometry)
    odometry.known = 1


@hot
def weigh_feet(params: Params, sensing: Sensing, swinging: int, odometry: Odometry) -> int:
    """Write the weight of each foot by the load that it carries; return their sum, 0 if no foot counts.

    Feet count that are planned to stand, or were up to a tick before the goals that the joints answer: drives lag. If
    stiff joints show less than a quarter of the robot's weight, all feet that are planned to stand count alike.
    """
    total = 0
    carried = 0
    odometry.carried_q12 = 0
    for leg in range(LEGS):
        force = stance_force(params, swinging >> leg & 1, leg, sensing.force_q12[leg], odometry)
        weight = lasting_load_q6(force, leg, odometry)
        weight *= weight
        carried += odometry.load_q6[leg]
        odometry.weight[leg] = weight
        total += weight
    if carried < _LEAST_LOAD_Q6:
        total = 0
        for leg in range(LEGS):
            odometry.weight[leg] = 1 - (swinging >> leg & 1)
            total += odometry.weight[leg]
    whole = 0
    if total:
        for leg in range(LEGS):
            weight = (odometry.weight[leg] << 8) // total
            odometry.weight[leg] = weight
            whole += weight
    return whole


@hot
def stance_force(params: Params, swings: int, leg: int, force_q12: int, odometry: Odometry) -> int:
    """Let ``stance_ticks`` of a foot follow the plan; return the foot's force if it may carry, else 0. swings: 1 or 0.

    The forces are added to ``carried_q12``, that of a foot about to land only if it presses: a leg that brakes its
    swing pulls as hard as the robot weighs.
    """
    whole = params.delay_ticks + 2
    lands = 0
    if swings == 0 and odometry.stance_ticks[leg] < whole:
        odometry.stance_ticks[leg] += 1
        lands = whole - odometry.stance_ticks[leg]
    elif swings and odometry.stance_ticks[leg]:
        odometry.stance_ticks[leg] -= 1
    if odometry.stance_ticks[leg] == 0:
        return 0
    if lands == 0 or force_q12 > 0:
        odometry.carried_q12 += force_q12
    return force_q12


@hot
def lasting_load_q6(force_q12: int, leg: int, odometry: Odometry) -> int:
    """Return the load carried at both ends of the tick, own weight Q6 0 .. 64; keep that at the end, ``force_q12``."""
    before = odometry.load_q6[leg]
    now = saturate(force_q12 >> 6, 0, 64)
    odometry.load_q6[leg] = now
    if before < now:
        return before
    return now


@hot
def measure_feet(sensing: Sensing, total: int, odometry: Odometry) -> None:
    """Write how far each foot that counts has moved, the middle of that way, and their means; total: sum of weights.

    The means are weighted. Intermediates: 256 * 4 * 2^14.
    """
    moved_x = 0
    moved_y = 0
    arm_x = 0
    arm_y = 0
    for leg in range(LEGS):
        was = odometry.rolled[leg]
        now = sensing.rolled[leg]
        weight = odometry.weight[leg]
        if weight:
            moved = odometry.moved[leg]
            arm = odometry.arm[leg]
            moved.x = saturate(was.x - now.x, -_MOVED_MAX, _MOVED_MAX)
            moved.y = saturate(was.y - now.y, -_MOVED_MAX, _MOVED_MAX)
            arm.x = saturate((sensing.level[leg].x << 1) + moved.x >> 2, -_ARM_MAX, _ARM_MAX)
            arm.y = saturate((sensing.level[leg].y << 1) + moved.y >> 2, -_ARM_MAX, _ARM_MAX)
            moved_x += weight * moved.x
            moved_y += weight * moved.y
            arm_x += weight * arm.x
            arm_y += weight * arm.y
        was.x = now.x
        was.y = now.y
    if total:
        odometry.moved_mean.x = ((moved_x << 2) + (total >> 1)) // total
        odometry.moved_mean.y = ((moved_y << 2) + (total >> 1)) // total
        odometry.arm_mean.x = arm_x // total
        odometry.arm_mean.y = arm_y // total


@hot
def turn_of_body(sensing: Sensing, turned: Turn) -> int:
    """Return the turn of the heading, 2^-18 rad, for ``turned``, 2^-18 rad about the body's own axes.

    Limited to +-2^15. Error at most 1 + 3e-4 of it up to a roll of 60 deg. Intermediates: 2 * 2^15 * 2^13.
    """
    about_x = saturate(turned.x, -_TURN_MAX, _TURN_MAX)
    about_z = saturate(turned.z, -_TURN_MAX, _TURN_MAX)
    level = about_z * sensing.pitch_cosine_q13 - about_x * sensing.pitch_sine_q13
    cosine = saturate(sensing.roll_cosine_q13, 4096, 8191)
    return saturate((level + (cosine >> 1)) // cosine, -_TURN_MAX, _TURN_MAX)


@hot
def turn_of_feet(odometry: Odometry) -> int:
    """Return the turn that the feet show together, 2^-18 rad within +-2^15: least squares over their ways.

    A single foot shows none. Error at most 1/500 of it. Intermediates: 256 * 2 * 2^14 * 2^13 >> 10, by 2^3 is 2^29.
    """
    across = 0
    along = 0
    for leg in range(LEGS):
        weight = odometry.weight[leg]
        if weight:
            moved = odometry.moved[leg]
            arm = odometry.arm[leg]
            x = saturate(arm.x - odometry.arm_mean.x, -_ARM_MAX, _ARM_MAX)
            y = saturate(arm.y - odometry.arm_mean.y, -_ARM_MAX, _ARM_MAX)
            ahead = saturate(moved.x - (odometry.moved_mean.x >> 2), -_MOVED_MAX, _MOVED_MAX)
            aside = saturate(moved.y - (odometry.moved_mean.y >> 2), -_MOVED_MAX, _MOVED_MAX)
            across += weight * (x * aside - y * ahead + 512 >> 10)
            along += weight * (x * x + y * y >> 10)
    if along <= 0:
        return 0
    across = saturate(across, -(along >> 2) - 1, (along >> 2) + 1)
    while along < 0x4000000:
        along <<= 1
        across <<= 1
    return saturate((across << 3) // (along >> 14), -_TURN_MAX, _TURN_MAX)


@hot
def move_body(params: Params, turn: int, total: int, walks: int, odometry: Odometry) -> None:
    """Shift and turn the body by what the feet show, or on at its last speed if no foot counts.

    turn: 2^-18 rad, total: sum of the weights. ``slip`` is the feet's mean distance from the shift, x plus y, lu Q2.
    Intermediates: 2^15 * 2^14; 256 * 2^18; speeds 2^22 * 205 at the lowest rate, 20 Hz.
    """
    share_q10 = params.average_q10
    odometry.turning += ((turn << 6) - odometry.turning) * share_q10 + 512 >> 10
    turn_mean = turn
    if odometry.gyro == 0:
        turn_mean = odometry.turning + 32 >> 6
    ahead = odometry.speed.x >> 6
    aside = odometry.speed.y >> 6
    slip = 0
    if total:
        ahead = saturate(odometry.moved_mean.x + (turn_mean * odometry.arm_mean.y + 0x4000 >> 15), -32767, 32767)
        aside = saturate(odometry.moved_mean.y - (turn_mean * odometry.arm_mean.x + 0x4000 >> 15), -32767, 32767)
        for leg in range(LEGS):
            if odometry.weight[leg]:
                moved = odometry.moved[leg]
                arm = odometry.arm[leg]
                x = (moved.x << 2) + (turn_mean * arm.y + 0x4000 >> 15) - ahead
                y = (moved.y << 2) - (turn_mean * arm.x + 0x4000 >> 15) - aside
                if x < 0:
                    x = -x
                if y < 0:
                    y = -y
                slip += odometry.weight[leg] * (x + y)
        slip >>= 8
    if walks:
        add_distance(params, ahead, aside, slip, odometry)
    odometry.speed.x += ((ahead << 6) - odometry.speed.x) * share_q10 + 512 >> 10
    odometry.speed.y += ((aside << 6) - odometry.speed.y) * share_q10 + 512 >> 10
    place_body(ahead, aside, turn, walks, odometry)


@hot
def place_body(ahead: int, aside: int, turn: int, walks: int, odometry: Odometry) -> None:
    """Move place and heading by a shift, lu Q2, and a turn, 2^-18 rad.

    No remainder is lost. Intermediates: 32767 * 2^14 * sqrt 2 + 2^16; 2^15 * 20861; 2^15.5 * 2^13 of
    ``heading_spread``.
    """
    turned = turn * _TO_HEADING + odometry.heading_fraction
    odometry.heading_fraction = turned & 2047
    turned >>= 11
    half = odometry.heading + (turned >> 1) >> 8
    cosine = cos_q15(half) + 1 >> 1
    sine = sin_q15(half) + 1 >> 1
    turned += odometry.heading + _HALF_TURN
    odometry.turns += turned >> 24
    odometry.heading = (turned & 0xFFFFFF) - _HALF_TURN
    x = ahead * cosine - aside * sine
    y = ahead * sine + aside * cosine
    rest = odometry.place_fraction
    rest.x += x
    rest.y += y
    odometry.place.x = saturate(odometry.place.x + (rest.x >> 16), -_FAR, _FAR)
    odometry.place.y = saturate(odometry.place.y + (rest.y >> 16), -_FAR, _FAR)
    rest.x &= 0xFFFF
    rest.y &= 0xFFFF
    if walks:
        sigma_q14 = saturate(odometry.heading_sigma_q26 >> 12, 0, 8191)
        spread = odometry.heading_spread
        spread.x = saturate(spread.x - ((y >> 14) * sigma_q14 >> 8), -_SUM_MAX, _SUM_MAX)
        spread.y = saturate(spread.y + ((x >> 14) * sigma_q14 >> 8), -_SUM_MAX, _SUM_MAX)


@hot
def add_distance(params: Params, ahead: int, aside: int, slip: int, odometry: Odometry) -> None:
    """Add a shift, and how far the feet differ from it, lu Q2, to the sums from which the uncertainties follow.

    A heading by the gyroscope is wrong by its bias, and by 1/256 rad per slip of a leg's length; a heading by the feet
    by 1/16 rad instead (both from walks in space, over stones and stairs). Intermediates: 2^13 * 2^16.
    """
    if ahead < 0:
        ahead = -ahead
    if aside < 0:
        aside = -aside
    if aside > ahead:
        ahead, aside = aside, ahead
    odometry.walked = saturate(odometry.walked + (ahead + (aside >> 1) + 2 >> 2), 0, _FAR)
    odometry.slip = saturate(odometry.slip + (slip + 2 >> 2), 0, _FAR)
    sigma = saturate((saturate(slip, 0, 8191) << 16) // params.leg_length, 0, 0xFFFFF)
    if odometry.gyro:
        sigma += _BIAS_Q26 // params.rate_hz
    else:
        sigma <<= 4
    odometry.heading_sigma_q26 = saturate(odometry.heading_sigma_q26 + sigma, 0, _SUM_MAX)


@hot
def odometry_spread(params: Params, odometry: Odometry) -> None:
    """Write scale_spread and place_spread. With heading_spread they make the covariance of x, y and heading.

    One sigma each, as seen in walks of four robots in space: a way is wrong by 1/256 of it and an eighth of the slip, a
    place in any direction by 1 mm, 1/256 of the way and 1/32 of the slip. The covariance is s s' + g g' + a a I with
    s = (scale_spread, 0), g = (heading_spread, heading_sigma), a = place_spread for x and y, 0 for the heading.
    Intermediates: 2^20 * 512.
    """
    way = odometry.walked
    slip = odometry.slip
    while way > 0xFFFFF or slip > 0xFFFFF:
        way >>= 1
        slip >>= 1
    share_q12 = 16
    if way:
        share_q12 = saturate(16 + slip * 512 // way, 0, 4096)
    place = odometry.place
    odometry.scale_spread.x = (place.x >> 12) * share_q12 + ((place.x & 4095) * share_q12 >> 12)
    odometry.scale_spread.y = (place.y >> 12) * share_q12 + ((place.y & 4095) * share_q12 >> 12)
    odometry.place_spread = (1 << params.length_shift) // 1000 + (odometry.walked >> 8) + (odometry.slip >> 5)
