"""Turns a gait table into ticks of one rate, and keeps the gait's clock.

Everything is whole ticks: a segment lasts round(ms * rate / 1000), at least 1, and the body's
advance is shared out so that one cycle moves it by exactly the commanded speed times the cycle,
whatever the rate. Nothing here runs per tick but ``gait_clock``.
"""

from .fixed import hypot
from .params import (
    LF_BITS,
    Params,
)
from .record import field, record
from .runtime import Ints, const, hot, zeros

G_SEGMENTS = const(0)  # number of segments
G_CYCLE = const(1)  # ticks of a whole cycle
G_HEIGHT_MM = const(2)
G_P_T_Q16 = const(3)
G_P_N_Q16 = const(4)
G_CYCLOID = const(5)  # 1: the body moves along a cycloid in each moving segment
G_STANCE_Q10 = const(6)  # 4 values: body advance while the leg stands, ticks Q10
G_VX_MAX = const(10)  # lf / tick, what the robot and the longest stride allow
G_VY_MAX = const(11)
G_WZ_MAX = const(12)  # yaw18 / tick
G_ROWS = const(13)  # the segments follow

ROW_TICKS = const(0)
ROW_SWING = const(1)  # legs in swing, bits
ROW_ADVANCE_Q4 = const(2)  # the body's advance in this segment, ticks Q4
ROW_START = const(3)  # 4 values: ticks of the swing that starts here, 0 if none
ROW_SWING_Q10 = const(7)  # 4 values: body advance during that swing, ticks Q10
ROW_SIZE = const(11)
MAX_SEGMENTS = const(16)
PEAK_Q10 = const(8191)  # the body may move at most 8 times its mean speed in any tick


def compile_gait(table, params: Params) -> Ints:
    """Return a gait table as an int block for one robot at its rate. Allocates: not for ticks.

    Raises ValueError with one sentence if the table can't be a gait for this robot.
    """
    head, rows = table
    count = len(rows)
    if not 1 <= count <= MAX_SEGMENTS:
        raise ValueError(f"a gait has 1 .. {MAX_SEGMENTS} segments, this one {count}")
    block = zeros(G_ROWS + count * ROW_SIZE)
    block[G_SEGMENTS] = count
    block[G_HEIGHT_MM] = head[0]
    block[G_P_T_Q16] = head[1] * 65536 // 100
    block[G_P_N_Q16] = (head[2] * 65536 + 99) // 100
    block[G_CYCLOID] = head[3]
    shares = 0
    for i in range(count):
        shares += time_segment(block, i, rows[i], params.rate_hz)
    if shares < 1:
        raise ValueError("the segments' shares of the advance add up to 0")
    for i in range(count):
        share_out_advance(block, i, rows[i][2], shares)
    for leg in range(4):
        share_out_swing(block, leg)
    limit_speeds(block, params)
    return block


def time_segment(block, i, row, rate_hz):
    """Fill in the length and the swing legs of segment ``i``; return its share of the advance."""
    milliseconds, swing, share = row
    if milliseconds < 1 or not 0 <= swing <= 15 or share < 0:
        raise ValueError(f"segment {i}: duration >= 1 ms, legs 0 .. 15, share >= 0; got {row}")
    if swing and share and block[G_CYCLOID]:
        raise ValueError(f"segment {i} moves the body while legs swing: that needs the even profile")
    ticks = max(1, (milliseconds * rate_hz + 500) // 1000)
    at = G_ROWS + i * ROW_SIZE
    block[at + ROW_TICKS] = ticks
    block[at + ROW_SWING] = swing
    block[G_CYCLE] += ticks
    if block[G_CYCLE] > 16383:
        raise ValueError(f"the cycle is longer than 16383 ticks at {rate_hz} Hz")
    return share


def share_out_advance(block, i, share, shares):
    """Fill in the body's advance during segment ``i``."""
    at = G_ROWS + i * ROW_SIZE
    advance_q4 = (block[G_CYCLE] * share * 16 + shares // 2) // shares
    fastest = 2 if block[G_CYCLOID] else 1
    intervals = max(1, block[at + ROW_TICKS] - block[G_CYCLOID])
    if (advance_q4 << 6) * fastest // intervals > PEAK_Q10:
        raise ValueError(f"segment {i} moves the body at more than 8 times its mean speed")
    block[at + ROW_ADVANCE_Q4] = advance_q4


def limit_speeds(block, params: Params):
    """Fill in the fastest command: the robot's own limit, or what makes the longest stride."""
    stance_ticks = 1
    for leg in range(4):
        stance_ticks = max(stance_ticks, block[G_STANCE_Q10 + leg] >> 10)
    radius = 1
    for leg in range(4):
        rest = params.legs[leg].rest
        radius = max(radius, int(hypot(rest[0], rest[1])))
    stride = params.stride_max
    block[G_VX_MAX] = min(params.speed_max[0], (stride << LF_BITS) // stance_ticks)
    block[G_VY_MAX] = min(params.speed_max[1], (stride << LF_BITS) // stance_ticks)
    block[G_WZ_MAX] = min(params.speed_max[2], ((stride << 13) // radius << 5) // stance_ticks)


def share_out_swing(block, leg):
    """Fill in where the swings of ``leg`` start, how long they last, and what the body does meanwhile."""
    count = block[G_SEGMENTS]
    bit = 1 << leg
    standing = block[G_CYCLE] << 10
    for i in range(count):
        row = G_ROWS + i * ROW_SIZE
        before = G_ROWS + (i - 1) % count * ROW_SIZE
        if not block[row + ROW_SWING] & bit or block[before + ROW_SWING] & bit:
            continue
        ticks = 0
        advance = 0
        j = i
        while block[G_ROWS + j * ROW_SIZE + ROW_SWING] & bit:
            ticks += block[G_ROWS + j * ROW_SIZE + ROW_TICKS]
            advance += block[G_ROWS + j * ROW_SIZE + ROW_ADVANCE_Q4] << 6
            j = (j + 1) % count
        block[row + ROW_START + leg] = ticks
        block[row + ROW_SWING_Q10 + leg] = advance
        standing -= advance
    block[G_STANCE_Q10 + leg] = standing




@record
class Clock:
    """Clock"""

    segment: int = field("", "segment")
    tick: int = field("", "tick within the segment")
    made_q10: int = field("", "the body's advance already made in the segment, ticks")




@hot
def gait_clock(gait: Ints, clock: Clock) -> int:
    """Move the clock one tick on; return 1 when that starts a new cycle, else 0."""
    clock.tick += 1
    if clock.tick < gait[G_ROWS + clock.segment * ROW_SIZE + ROW_TICKS]:
        return 0
    clock.tick = 0
    clock.made_q10 = 0
    clock.segment += 1
    if clock.segment < gait[G_SEGMENTS]:
        return 0
    clock.segment = 0
    return 1
