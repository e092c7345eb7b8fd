"""Where the four feet are: footholds that pass under the body, and swings to the next ones.

A stance foot stays on the ground, so in the base frame it moves against the body. A swing foot does the same, plus a
cycloid to its next foothold, so it touches down without speed over the ground. Each next foothold is the rest position
plus half of the body's way in the coming stance (the symmetric point of Raibert's foot placement), so nothing
accumulates.
"""

from ..body.axes import Twist
from ..body.feet import Feet
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import saturate
from ..record import field, parts, record
from ..runtime import const, hot
from .swing import cycloid_q15, lift_q15, swing_phase_q16
from .table import Clock, Gait


@record
class Step:
    """One foot: its foothold, and its swing to the next one."""

    x: int = field("lf", "the foothold in the base frame")
    y: int = field("lf", "the foothold in the base frame")
    z: int = field("lu", "the foothold in the base frame")
    ticks: int = field("ticks", "samples of the swing, 0 in stance")
    tick: int = field("ticks", "the next sample")
    left_q10: int = field("ticks Q10", "how far the body will still advance during the swing")
    to_z: int = field("lu", "height of the next foothold")
    height: int = field("lu", "lift of the swing, as commanded when the foot left")


@record
class Steps:
    """All four feet."""

    legs: list[Step] = parts(LEGS, Step, "FR, FL, RR, RL")


_TURN_MAX = const(0xFFFFF)  # 2^-22 rad: a quarter of a radian in a tick


@hot
def steps_reset(params: Params, steps: Steps) -> None:
    """Put all four feet at rest, standing."""
    for leg in range(LEGS):
        step = steps.legs[leg]
        rest = params.legs[leg].rest
        step.x = rest.x << LF_BITS
        step.y = rest.y << LF_BITS
        step.z = rest.z
        step.to_z = rest.z
        step.ticks = 0
        step.tick = 0


@hot
def steps_at_rest(params: Params, steps: Steps) -> int:
    """Return 1 if all four feet stand within 1/16 lu of their rest positions, else 0."""
    for leg in range(LEGS):
        step = steps.legs[leg]
        rest = params.legs[leg].rest
        if step.ticks:
            return 0
        away_x = step.x - (rest.x << LF_BITS)
        away_y = step.y - (rest.y << LF_BITS)
        if away_x > 16 or away_x < -16 or away_y > 16 or away_y < -16:
            return 0
    return 1


@hot
def start_swings(gait: Gait, clock: Clock, steps: Steps) -> None:
    """Lift the legs whose swing starts in the clock's segment."""
    row = gait.rows[clock.segment]
    lifted = 0
    for leg in range(LEGS):
        ticks = row.start[leg]
        if ticks:
            step = steps.legs[leg]
            step.ticks = ticks
            step.tick = 0
            step.left_q10 = row.swing_q10[leg]
            lifted |= 1 << leg


@hot
def body_advance(gait: Gait, clock: Clock) -> int:
    """Return how far the body moves in this tick, in ticks of the commanded speed, Q10.

    The sum over a segment is exactly the segment's ``advance_q4``. 0 .. 8192, because compile_gait refuses faster
    segments. Intermediates below 4096 * 32768 + 2^15.
    """
    row = gait.rows[clock.segment]
    advance_q4 = row.advance_q4
    if advance_q4 == 0:
        return 0
    ticks = row.ticks
    tick = clock.tick
    share = ((tick + 1) << 15) // ticks
    if gait.cycloid and ticks > 1:
        share = cycloid_q15(swing_phase_q16(tick, ticks, 65536, 65536))
    made = (advance_q4 >> 6) * share + ((advance_q4 & 63) * share >> 6) + 4 >> 3
    advance = made - clock.made_q10
    clock.made_q10 = made
    return advance


@hot
def travel(speed: int, ticks_q10: int) -> int:
    """Return speed * ticks: lf from lf / tick and ticks in Q10.

    Range: \\|speed\\| < 2^19, ticks_q10 < 2^24, and the way below 2^29 lf. Error at most 1/2 lf. Whole ticks
    and the rest of one are taken apart: the largest intermediate is below the way + 2^29.
    """
    return speed * (ticks_q10 >> 10) + (speed * (ticks_q10 & 1023) + 512 >> 10)


@hot
def turned_travel(turn_yaw18: int, arm_lf: int, ticks_q10: int) -> int:
    """Return the way in lf of a foot at ``arm_lf`` from the turning body: turn * ticks * arm.

    Range: \\|turn\\| * ticks below 1 rad = 2^18, beyond which it is taken as 1 rad; arm within 65535 lu. Error
    at most 2 lf + 1/30000 of the arm. Largest intermediate 65535 * 2^14 < 2^30.
    """
    angle_yaw14 = saturate(travel(turn_yaw18, ticks_q10), -0x3FFFF, 0x3FFFF) + 8 >> 4
    return (arm_lf >> LF_BITS) * angle_yaw14 >> (14 - LF_BITS)


@hot
def move_feet(steps: Steps, speed: Twist, ticks_q10: int) -> None:
    """Move all footholds against the body by ``ticks_q10`` of its speed.

    A turn is made in three shears, half of one axis, the other, the other half: they keep areas, so feet
    neither creep out nor in. It is taken in 2^-22 rad, or as fine as leaves it 14 bits; at most 1/4 rad a tick.
    Range: feet within 65535 lu. Largest intermediate 65535 * 16384 + 2^14 < 2^30.
    """
    dx = travel(speed.vx, ticks_q10)
    dy = travel(speed.vy, ticks_q10)
    turn = saturate(travel(speed.wz, ticks_q10 << 4), -_TURN_MAX, _TURN_MAX)
    shift = 22 - LF_BITS
    while turn > 16383 or turn < -16383:
        turn >>= 1
        shift -= 1
    half = 1 << shift
    for leg in range(LEGS):
        step = steps.legs[leg]
        x = step.x
        y = step.y
        if turn:
            x += (y + 128 >> LF_BITS) * turn + half >> shift + 1
            y -= (x + 128 >> LF_BITS) * turn + (half >> 1) >> shift
            x += (y + 128 >> LF_BITS) * turn + half >> shift + 1
        step.x = x - dx
        step.y = y - dy
        if step.ticks:
            step.left_q10 -= ticks_q10


@hot
def place_feet(params: Params, gait: Gait, steps: Steps, speed: Twist, height_lu: int, feet: Feet) -> int:
    """Write the places of all four feet in this tick into ``feet``; return the legs in swing, bits.

    feet: lu in the base frame. height_lu: lift above the line from foothold to foothold.
    """
    swinging = 0
    for leg in range(LEGS):
        step = steps.legs[leg]
        if step.ticks:
            swinging |= 1 << leg
            swing_foot(params, gait, steps, speed, leg, height_lu, feet)
        else:
            foot = feet.legs[leg]
            foot.x = step.x >> LF_BITS
            foot.y = step.y >> LF_BITS
            foot.z = step.z
    return swinging


@hot
def swing_foot(
    params: Params, gait: Gait, steps: Steps, speed: Twist, leg: int, height_lu: int, feet: Feet
) -> None:
    """Write one swing foot into ``feet`` (paper A eqs 11-14) and take its sample.

    Its next foothold follows the command as that changes, so it lands where it should; its height is that of the first
    sample. Re-timed samples include both ends, as in the paper; even samples leave out the last, which is where the
    foot stands in the tick after. Intermediates: 32767 * 32768 < 2^30.
    """
    step = steps.legs[leg]
    foot = feet.legs[leg]
    samples = step.ticks
    sample = step.tick
    if sample == 0:
        step.height = height_lu
    ends = samples
    if gait.p_t_q16 >= 65536 or gait.p_n_q16 >= 65536:
        ends = samples + 1
    phase = swing_phase_q16(sample, ends, gait.p_t_q16, gait.p_n_q16)
    share = cycloid_q15(phase)
    sample += 1
    if sample >= samples:
        step.left_q10 = 0
    ahead = (gait.stance_q10[leg] >> 1) + step.left_q10
    to_x = foothold_x(params, leg, speed, ahead)
    to_y = foothold_y(params, leg, speed, ahead)
    foot.x = between(step.x, to_x, share)
    foot.y = between(step.y, to_y, share)
    rise = (step.to_z - step.z) * share + 0x4000 >> 15
    foot.z = step.z + rise + (step.height * lift_q15(phase) + 0x4000 >> 15)
    step.tick = sample
    if sample >= samples:
        step.x = to_x
        step.y = to_y
        step.z = step.to_z
        step.ticks = 0


@hot
def between(from_lf: int, to_lf: int, share_q15: int) -> int:
    """Return the point ``share`` of the way, in lu. The way is limited to +-32767 lu, share 0 .. 32768."""
    gap = saturate((to_lf - from_lf) >> LF_BITS, -32767, 32767)
    return (from_lf >> LF_BITS) + (gap * share_q15 + 0x4000 >> 15)


@hot
def foothold_x(params: Params, leg: int, speed: Twist, ahead_q10: int) -> int:
    """Return x in lf of the foothold that is ahead of rest by the body's way in ``ahead_q10`` ticks."""
    rest = params.legs[leg].rest
    turned = turned_travel(speed.wz, rest.y << LF_BITS, ahead_q10)
    return (rest.x << LF_BITS) + travel(speed.vx, ahead_q10) - turned


@hot
def foothold_y(params: Params, leg: int, speed: Twist, ahead_q10: int) -> int:
    """Return y in lf of the foothold that is ahead of rest by the body's way in ``ahead_q10`` ticks."""
    rest = params.legs[leg].rest
    turned = turned_travel(speed.wz, rest.x << LF_BITS, ahead_q10)
    return (rest.y << LF_BITS) + travel(speed.vy, ahead_q10) + turned
