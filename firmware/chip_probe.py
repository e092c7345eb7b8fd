"""The current step's interrupt with a clock on it: when it came, how long it took, what it saw; for the self-test.

Timer 1 itself is the clock, at 168 MHz: it stood at the top when the interrupt was asked for.
"""

from shared.joint.layout import CurrentLoop
from shared.record import field, record, vector
from shared.runtime import Ints, const, hot, reg32

from .chip import TIM1_CNT_32, TIM1_CR1_32
from .chip_setup import PERIOD
from .chip_step import interrupt
from .joint_run import BoardRun


@record
class Seen:
    """What the steps were like."""

    gap_least_us: int = field("us", "shortest time between two steps")
    gap_most_us: int = field("us", "longest time between two steps")
    entry_most: int = field("1/168 us", "longest time from the update to the first instruction here")
    end_most: int = field("1/168 us", "and to the end")
    stale_samples: int = field("", "steps without new samples")
    raw_low: Ints = vector(3, "count", "least reading of the shunts a, b, c")
    raw_high: Ints = vector(3, "count", "largest reading of the shunts a, b, c")


_DOWN = const(0x10)  # CR1: DIR
_MASK = const(0x3FFFFFFF)


@hot
def since_update(chip) -> int:
    """Return the ticks since the timer was at its top, 0 .. 8399."""
    c = reg32(chip)
    count = c[TIM1_CNT_32]
    if c[TIM1_CR1_32] & _DOWN:
        return PERIOD - count
    return PERIOD + count


@hot
def probed(chip, loop: CurrentLoop, run: BoardRun, seen: Seen, timer) -> int:
    """Do what the interrupt does, and note it; return what became of the bridge."""
    entry = since_update(chip)
    before = run.last_us
    bridge = interrupt(chip, loop, run, timer)
    if run.stale_steps:
        seen.stale_samples += 1
    for phase in range(3):
        raw = loop.raw[phase]
        if raw < seen.raw_low[phase]:
            seen.raw_low[phase] = raw
        if raw > seen.raw_high[phase]:
            seen.raw_high[phase] = raw
    if entry > seen.entry_most:
        seen.entry_most = entry
    end = since_update(chip)
    if end > seen.end_most:
        seen.end_most = end
    if before < 0:
        return bridge
    gap = (run.last_us - before) & _MASK
    if gap < seen.gap_least_us:
        seen.gap_least_us = gap
    if gap > seen.gap_most_us:
        seen.gap_most_us = gap
    return bridge
