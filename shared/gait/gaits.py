"""The registry of gaits: a gait is one entry in GAITS, its name, its mover and its table, None if it needs none.

A mover is the code that stands and walks (shared/planner/movers.py). A table is a head and a row per segment:

    head     swing height mm, P_T and P_N of the swing in 1/100 (100, 100 = even samples),
             body profile in moving segments: 0 even, 1 cycloid
    segment  duration ms, legs in swing (bits: FR 1, FL 2, RR 4, RL 8), share of the body's
             advance made in it

A leg swings for as long as its bit stays set in consecutive segments; shares are relative. A
segment that moves the body while legs swing needs the even profile.
"""

from ..body.axes import TWIST_AXES
from ..body.params import Params
from ..runtime import const
from .table import MOVER_CRAWL, MOVER_TABLE, MOVER_TROT, Gait, compile_gait

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

# Commands and boards count gaits in this order: new ones go to the end.
GAITS = (
    ("paper-trot", MOVER_TABLE, PAPER_TROT),
    ("trot", MOVER_TROT, None),
    ("crawl", MOVER_CRAWL, None),
)
GAIT_NAMES = tuple([entry[0] for entry in GAITS])


def gait_for(entry: tuple, params: Params) -> Gait:
    """Return the gait of an entry for one robot at its rate. Allocates; ValueError as compile_gait.

    Without a table it gets the trot's speeds and swing height, the crawl too: what that cannot follow is trotted.
    """
    _, mover, table = entry
    if table:
        gait = compile_gait(table, params)
    else:
        gait = Gait()
        gait.height_mm = (params.trot.low_lift * 1000 >> params.length_shift) + 1
        for axis in range(TWIST_AXES):
            gait.speed_max[axis] = params.trot.speed_max[axis]
    gait.mover = mover
    return gait
