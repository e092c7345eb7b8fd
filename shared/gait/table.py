"""Turns a gait table into ticks of one rate, and keeps the gait's clock.

Everything is whole ticks: a segment lasts round(ms * rate / 1000), at least 1, and the body's
advance is shared out so that one cycle moves it by exactly the commanded speed times the cycle,
whatever the rate. Nothing here runs per tick but ``gait_clock``.
"""

from ..body.axes import Twist
from ..body.params import LEGS, LF_BITS, Params
from ..num.fixed import hypot
from ..record import field, part, parts, record, vector
from ..runtime import Ints, const, hot

MAX_SEGMENTS = const(8)

# What walks a gait (shared/planner/movers.py)
MOVER_TABLE = const(0)  # its table, blind
MOVER_TROT = const(1)  # the trot; the crawl where the trot is held up
MOVER_CRAWL = const(2)  # the crawl; the trot for what the crawl cannot follow


@record
class Segment:
    """A segment of a gait's cycle: which legs swing in it, how far the body advances."""

    ticks: int = field("ticks", "its length")
    swing: int = field("", "legs in swing, bits")
    advance_q4: int = field("ticks Q4", "the body's advance in it, at the mean speed")
    start: Ints = vector(LEGS, "ticks", "length of the swing that starts here, 0 if none")
    swing_q10: Ints = vector(LEGS, "ticks Q10", "the body's advance during that swing")


@record
class Gait:
    """A gait for one robot at its rate."""

    mover: int = field("", "MOVER_...")
    segments: int = field("", "number of segments")
    cycle: int = field("ticks", "a whole cycle")
    height_mm: int = field("mm", "lift of a swing")
    p_t_q16: int = field("Q16", "P_T of the swing's re-timing (paper A eq. 15)")
    p_n_q16: int = field("Q16", "P_N of the swing's re-timing")
    cycloid: int = field("", "1: the body moves along a cycloid in each moving segment")
    stance_q10: Ints = vector(LEGS, "ticks Q10", "the body's advance while the leg stands")
    speed_max: Twist = part(Twist, "what the robot and the longest stride allow")
    rows: list[Segment] = parts(MAX_SEGMENTS, Segment, "its segments")


@record
class Clock:
    """Where a gait is in its cycle."""

    segment: int = field("", "index of the segment")
    tick: int = field("ticks", "since the segment began")
    made_q10: int = field("ticks Q10", "the body's advance already made in the segment")


PEAK_Q10 = const(8191)  # the body may move at most 8 times its mean speed in any tick


def compile_gait(table: tuple, params: Params) -> Gait:
    """Return a gait table for one robot at its rate. Allocates: not for ticks.

    Raises ValueError with one sentence if the table can't be a gait for this robot.
    """
    head, rows = table
    count = len(rows)
    if not 1 <= count <= MAX_SEGMENTS:
        raise ValueError(f"a gait has 1 .. {MAX_SEGMENTS} segments, this one {count}")
    gait = Gait()
    gait.segments = count
    gait.height_mm = head[0]
    gait.p_t_q16 = head[1] * 65536 // 100
    gait.p_n_q16 = (head[2] * 65536 + 99) // 100
    gait.cycloid = head[3]
    shares = 0
    for i in range(count):
        shares += time_segment(gait, i, rows[i], params.rate_hz)
    if shares < 1:
        raise ValueError("the segments' shares of the advance add up to 0")
    for i in range(count):
        share_out_advance(gait, i, rows[i][2], shares)
    for leg in range(4):
        share_out_swing(gait, leg)
    limit_speeds(gait, params)
    return gait


def time_segment(gait: Gait, i: int, row: tuple, rate_hz: int) -> int:
    """Fill in the length and the swing legs of segment ``i``; return its share of the advance."""
    milliseconds, swing, share = row
    if milliseconds < 1 or not 0 <= swing <= 15 or share < 0:
        raise ValueError(f"segment {i}: duration >= 1 ms, legs 0 .. 15, share >= 0; got {row}")
    if swing and share and gait.cycloid:
        raise ValueError(f"segment {i} moves the body while legs swing: that needs the even profile")
    ticks = max(1, (milliseconds * rate_hz + 500) // 1000)
    segment = gait.rows[i]
    segment.ticks = ticks
    segment.swing = swing
    gait.cycle += ticks
    if gait.cycle > 16383:
        raise ValueError(f"the cycle is longer than 16383 ticks at {rate_hz} Hz")
    return share


def share_out_advance(gait: Gait, i: int, share: int, shares: int) -> None:
    """Fill in the body's advance during segment ``i``."""
    segment = gait.rows[i]
    advance_q4 = (gait.cycle * share * 16 + shares // 2) // shares
    fastest = 2 if gait.cycloid else 1
    intervals = max(1, segment.ticks - gait.cycloid)
    if (advance_q4 << 6) * fastest // intervals > PEAK_Q10:
        raise ValueError(f"segment {i} moves the body at more than 8 times its mean speed")
    segment.advance_q4 = advance_q4


def limit_speeds(gait: Gait, params: Params) -> None:
    """Fill in the limits of the command: the robot's own, or what makes the longest stride."""
    stance_ticks = 1
    for leg in range(4):
        stance_ticks = max(stance_ticks, gait.stance_q10[leg] >> 10)
    radius = 1
    for leg in range(4):
        rest = params.legs[leg].rest
        radius = max(radius, int(hypot(rest.x, rest.y)))
    stride = params.stride_max
    gait.speed_max.vx = min(params.speed_max.vx, (stride << LF_BITS) // stance_ticks)
    gait.speed_max.vy = min(params.speed_max.vy, (stride << LF_BITS) // stance_ticks)
    gait.speed_max.wz = min(params.speed_max.wz, ((stride << 13) // radius << 5) // stance_ticks)


def share_out_swing(gait: Gait, leg: int) -> None:
    """Fill in where the swings of ``leg`` start, how long they last, and how far the body advances meanwhile."""
    count = gait.segments
    bit = 1 << leg
    standing = gait.cycle << 10
    for i in range(count):
        row = gait.rows[i]
        before = gait.rows[(i - 1) % count]
        if not row.swing & bit or before.swing & bit:
            continue
        ticks = 0
        advance = 0
        j = i
        while gait.rows[j].swing & bit:
            ticks += gait.rows[j].ticks
            advance += gait.rows[j].advance_q4 << 6
            j = (j + 1) % count
        row.start[leg] = ticks
        row.swing_q10[leg] = advance
        standing -= advance
    gait.stance_q10[leg] = standing


@hot
def gait_clock(gait: Gait, clock: Clock) -> int:
    """Advance the clock by one tick; return 1 when that starts a new cycle, else 0."""
    clock.tick += 1
    if clock.tick < gait.rows[clock.segment].ticks:
        return 0
    clock.tick = 0
    clock.made_q10 = 0
    clock.segment += 1
    if clock.segment < gait.segments:
        return 0
    clock.segment = 0
    return 1
