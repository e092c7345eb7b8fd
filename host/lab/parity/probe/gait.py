"""shared/gait/table.py and gaits.py: the compiler of the tables, and the clock of every compiled gait at every rate."""


from shared.gait import gaits
from shared.gait import table as gait
from shared.gait.table import Clock, Gait
from shared.record import copy

from .draw import FLAG, LEG, Range
from .draws import ROBOT, TABLE, TABLES, gait_of
from .probe import Pick, Probe, probe_with
from .robots import PARAMS

CLOCK = Clock()
BLOCK = Gait()


def draw_clock(block: Gait, clock: Clock, dice):
    """Put the clock at any tick of any segment of the gait."""
    clock.segment = dice.below(block.segments)
    row = block.rows[clock.segment]
    clock.tick = dice.below(row.ticks)
    clock.made_q10 = dice.below(32769)


def any_clock(values, dice):
    """Put the gait of the drawn table for any robot in its place, and the clock anywhere in it."""
    values[0] = gait_of(ROBOT.any(dice), values[0])
    draw_clock(values[0], values[1], dice)


def _copy(params, dice):
    """Put a compiled gait into BLOCK, which the set-up functions then fill in again."""
    copy(gait_of(params, dice.below(len(TABLES))), BLOCK)


def _new_row(values, dice):
    _copy(PARAMS[0], dice)
    BLOCK.cycle = dice.below(2000)
    BLOCK.cycloid = 0
    values[1] %= BLOCK.segments
    values[2] = (1 + dice.below(2000), dice.below(16), dice.below(9))


def _new_swing(values, dice):
    _copy(ROBOT.any(dice), dice)


def _new_share(values, dice):
    _new_swing(values, dice)
    values[1] %= BLOCK.segments


def _new_limit(values, dice):
    _copy(values[1], dice)


_probe = probe_with(watch=(BLOCK,), ticks=False)

PROBES = (
    Probe(gait, "compile_gait", (Pick(*TABLES), ROBOT), ticks=False),
    Probe(gaits, "gait_for", (Pick(*gaits.GAITS), ROBOT), ticks=False),
    _probe(gait, "time_segment", (BLOCK, Range(0, 15), (), Pick(20, 50, 500)), fit=_new_row),
    _probe(gait, "share_out_advance", (BLOCK, Range(0, 15), FLAG, Range(20, 40)), fit=_new_share),
    _probe(gait, "limit_speeds", (BLOCK, ROBOT), fit=_new_limit),
    _probe(gait, "share_out_swing", (BLOCK, LEG), fit=_new_swing),
    Probe(gait, "gait_clock", (TABLE, CLOCK), watch=(CLOCK,), fit=any_clock),
)
