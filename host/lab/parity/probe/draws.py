"""Arguments that several modules of the core share: the robots, and a gait's table."""

from shared.gait.gaits import GAITS, PAPER_TROT
from shared.gait.table import compile_gait

from .draw import Range
from .probe import Pick
from .robots import PARAMS

ROBOT = Pick(*PARAMS)
GAIT = Range(0, len(GAITS) - 1)

# Of what a gait's table may be the papers' trot has one half: body moved on a cycloid, swings re-timed.
EVEN_TROT = ((35, 100, 100, 0), ((360, 0, 46), (200, 9, 10), (360, 0, 46), (200, 6, 10)))
TABLES = (PAPER_TROT, EVEN_TROT)
TABLE = Range(0, len(TABLES) - 1)

_COMPILED: list = [[None] * len(TABLES) for _ in PARAMS]


def gait_of(params, index):
    """Return the gait of table ``index`` for the robot and rate that ``params`` is; made when first asked for."""
    for at in range(len(PARAMS)):
        if PARAMS[at] is params:
            if _COMPILED[at][index] is None:
                _COMPILED[at][index] = compile_gait(TABLES[index], params)
            return _COMPILED[at][index]
    raise ValueError("not one of the robots")
