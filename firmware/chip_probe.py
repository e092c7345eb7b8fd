"""The current step's interrupt with a clock on it: when it came, how long it took, what it saw; for the self-test.

Timer 1 itself is the clock, at 168 MHz: it stood at the top when the interrupt was asked for.
"""

from shared.joint.layout import F_RAW_A
from shared.runtime import const, hot, ptr32, reg32

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
def probed(chip, foc, run, seen, timer) -> int:
    """Do what the interrupt does, and note it; return what became of the bridge."""
    f = ptr32(foc)
    r = ptr32(run)
    s = ptr32(seen)
    entry = since_update(chip)
    before = r[RUN_LAST_US]
    bridge = interrupt(chip, foc, run, timer)
    if r[RUN_STALE]:
        s[SEEN_STALE] += 1
    for phase in range(3):
        raw = f[F_RAW_A + phase]
        if raw < s[SEEN_RAW_LOW + phase]:
            s[SEEN_RAW_LOW + phase] = raw
        if raw > s[SEEN_RAW_HIGH + phase]:
            s[SEEN_RAW_HIGH + phase] = raw
    if entry > s[SEEN_ENTRY_MOST]:
        s[SEEN_ENTRY_MOST] = entry
    end = since_update(chip)
    if end > s[SEEN_END_MOST]:
        s[SEEN_END_MOST] = end
    if before < 0:
        return bridge
    gap = (r[RUN_LAST_US] - before) & _MASK
    if gap < s[SEEN_GAP_LEAST]:
        s[SEEN_GAP_LEAST] = gap
    if gap > s[SEEN_GAP_MOST]:
        s[SEEN_GAP_MOST] = gap
    return bridge
