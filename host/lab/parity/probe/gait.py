"""shared/gait/table.py and gaits.py: the compiler of the tables, and the clock of every compiled gait at every rate."""


from shared.gait import table as gait
from shared.gait.gaits import GAITS, gait_for
from shared.gait.table import Clock, Gait
from shared.record import copy

from .draw import Range
from .draws import LEG, ROBOT, TABLE, TABLES, gait_of
from .probe import Pick, Probe

CLOCK = Clock()
BLOCK = Gait()


def draw_clock(block: Gait, clock: Clock, dice):
    """Put the clock at any tick of any segment of the gait."""
    clock.segment = dice.below(block.segments)
    row = block.rows[clock.segment]
    clock.tick = dice.below(row.ticks)
    clock.made_q10 = dice.below(32769)


def _any_clock(values, dice):
    values[0] = gait_of(ROBOT.choices[dice.below(len(ROBOT.choices))], values[0])
    draw_clock(values[0], values[1], dice)


def _copy(params, dice):
    """Put a compiled gait into BLOCK, which the set-up functions then fill in again."""
    source = gait_of(params, dice.below(len(TABLES)))
    copy(source, BLOCK)


def _new_row(values, dice):
    _copy(ROBOT.choices[0], dice)
    BLOCK.cycle = dice.below(2000)
    BLOCK.cycloid = 0
    values[1] %= BLOCK.segments
    values[2] = (1 + dice.below(2000), dice.below(16), dice.below(9))


def _new_share(values, dice):
    _copy(ROBOT.choices[dice.below(len(ROBOT.choices))], dice)
    values[1] %= BLOCK.segments


def _new_limit(values, dice):
    _copy(values[1], dice)


def _new_swing(values, dice):
    _copy(ROBOT.choices[dice.below(len(ROBOT.choices))], dice)


PROBES = (
    Probe("compile_gait", gait.compile_gait, (Pick(*TABLES), ROBOT), ticks=False),
    Probe("gait_for", gait_for, (Pick(*GAITS), ROBOT), ticks=False),
    Probe(
        "time_segment",
        gait.time_segment,
        (BLOCK, Range(0, 15), (), Pick(20, 50, 500)),
        watch=(BLOCK,),
        fit=_new_row,
        ticks=False,
    ),
    Probe(
        "share_out_advance",
        gait.share_out_advance,
        (BLOCK, Range(0, 15), Range(0, 1), Range(20, 40)),
        watch=(BLOCK,),
        fit=_new_share,
        ticks=False,
    ),
    Probe("limit_speeds", gait.limit_speeds, (BLOCK, ROBOT), watch=(BLOCK,), fit=_new_limit, ticks=False),
    Probe("share_out_swing", gait.share_out_swing, (BLOCK, LEG), watch=(BLOCK,), fit=_new_swing, ticks=False),
    Probe("gait_clock", gait.gait_clock, (TABLE, CLOCK), watch=(CLOCK,), fit=_any_clock),
)
