"""The registry of gaits: a gait is one entry in GAITS, its name, its mover and its table.

A mover is what stands and walks (shared/planner/movers.py). A table is a head and a row per segment of the cycle:

    head     swing height mm, P_T and P_N of the swing in 1/100 (100, 100 = even samples),
             body profile in moving segments: 0 even, 1 cycloid
    segment  duration ms, legs in swing (bits: FR 1, FL 2, RR 4, RL 8), share of the body's
             advance made in it

A leg swings for as long as its bit stays set in consecutive segments; shares are relative. A
segment that moves the body while legs swing needs the even profile.
"""

from ..body.params import Params
from ..runtime import const
from .table import MOVER_CRAWL, MOVER_STRIDE, MOVER_TABLE, MOVER_TROT, Gait, compile_gait

_FR = const(1)
_FL = const(2)
_RR = const(4)
_RL = const(8)

# Paper A, section 3.3: half a stride of the body, one diagonal, half a stride, the other, 0.5 s each,
# 0.05 m high, re-timed with P_T = 0.66 and P_N = 0.33.
PAPER_TROT = (
    (50, 66, 33, 1),
    ((500, 0, 1), (500, _FR | _RL, 0), (500, 0, 1), (500, _FL | _RR, 0)),
)

# The trot at its slow speed; shared/trot/trot.py re-times it. While a diagonal swings the body moves at half its mean
# speed. P_T = P_N = 0: even samples of which the last is the foothold.
TROT = (
    (35, 0, 0, 0),
    ((360, 0, 46), (200, _FR | _RL, 10), (360, 0, 46), (200, _FL | _RR, 10)),
)

# Commands and boards count gaits in this order: new ones go to the end. The crawl goes straight on; what it cannot
# follow is trotted, hence its table.
GAITS = (
    ("paper-trot", MOVER_TABLE, PAPER_TROT),
    ("trot", MOVER_TROT, TROT),
    ("crawl", MOVER_CRAWL, TROT),
    ("fast-trot", MOVER_STRIDE, TROT),
)
GAIT_NAMES = tuple([entry[0] for entry in GAITS])


def gait_for(entry: tuple, params: Params) -> Gait:
    """Return the gait of an entry for one robot at its rate. Allocates; ValueError as compile_gait."""
    _, mover, table = entry
    gait = compile_gait(table, params)
    gait.mover = mover
    if mover == MOVER_STRIDE:
        for axis in range(3):
            gait.speed_max[axis] = params.stride.speed_max[axis]
    return gait
