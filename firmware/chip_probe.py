"""The current step's interrupt with a clock on it: when it came, how long it took, what it saw; for the self-test.

Timer 1 itself is the clock, at 168 MHz: it stood at the top when the interrupt was asked for.
"""

from shared.joint.layout import F_RAW_A
from shared.runtime import Ints, const, hot, reg32

from .chip import TIM1_CNT_32, TIM1_CR1_32
from .chip_setup import PERIOD
from .chip_step import interrupt
from .joint_run import RUN_LAST_US, RUN_STALE

SEEN_GAP_LEAST = const(0)  # us between two steps
SEEN_GAP_MOST = const(1)
SEEN_ENTRY_MOST = const(2)  # ticks of 1/168 us from the update to the first instruction here
SEEN_END_MOST = const(3)  # and to the end
SEEN_STALE = const(4)  # steps without new samples
SEEN_RAW_LOW = const(5)  # of three shunts, counts
SEEN_RAW_HIGH = const(8)
SEEN_SIZE = const(11)
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
def probed(chip, foc: Ints, run: Ints, seen: Ints, timer) -> int:
    """Do what the interrupt does, and note it; return what became of the bridge."""
    entry = since_update(chip)
    before = run[RUN_LAST_US]
    bridge = interrupt(chip, foc, run, timer)
    if run[RUN_STALE]:
        seen[SEEN_STALE] += 1
    for phase in range(3):
        raw = foc[F_RAW_A + phase]
        if raw < seen[SEEN_RAW_LOW + phase]:
            seen[SEEN_RAW_LOW + phase] = raw
        if raw > seen[SEEN_RAW_HIGH + phase]:
            seen[SEEN_RAW_HIGH + phase] = raw
    if entry > seen[SEEN_ENTRY_MOST]:
        seen[SEEN_ENTRY_MOST] = entry
    end = since_update(chip)
    if end > seen[SEEN_END_MOST]:
        seen[SEEN_END_MOST] = end
    if before < 0:
        return bridge
    gap = (run[RUN_LAST_US] - before) & _MASK
    if gap < seen[SEEN_GAP_LEAST]:
        seen[SEEN_GAP_LEAST] = gap
    if gap > seen[SEEN_GAP_MOST]:
        seen[SEEN_GAP_MOST] = gap
    return bridge
