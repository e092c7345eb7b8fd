"""The table of a creeping round, 512 bins, and the amplitude in it of a wave of a given number per table.

The values of each bin are weighted by the rotor's way in both directions: friction cancels, and so do delays.
"""

from ..num.fixed import hypot, ratio, saturate
from ..runtime import const, hot
from .commission_state import COGGING_BINS, Commission
from .layout import COSINE_AT, CurrentLoop

_BINS = const(128)  # that are searched in a tick
_SINE_STEPS = const(1023)  # of the sine table, less one
_TABLE_MOST = const(0x1FFFFFFF)


@hot
def clear_table(commission: Commission, table_repeats: int) -> None:
    """Begin an empty table that repeats ``table_repeats`` times a turn of the rotor."""
    commission.table_repeats = table_repeats
    commission.way = 0
    for at_bin in range(COGGING_BINS):
        commission.cogging_bins[at_bin] = 0


@hot
def add_to_table(commission: Commission, value: int) -> None:
    """Add the value of the tick before over its way to the bin where the rotor was."""
    way = commission.moved_last * commission.sign
    at_bin = commission.bin_last
    commission.cogging_bins[at_bin] = saturate(commission.cogging_bins[at_bin] + value * way, -_TABLE_MOST, _TABLE_MOST)
    commission.way += way


@hot
def look_for(commission: Commission, order: int) -> int:
    """Begin to search the table for a wave that comes ``order`` times in it; return that."""
    commission.order = order
    commission.bin_next = 0
    commission.cosine_sum = 0
    commission.sine_sum = 0
    return order


@hot
def look_at_table(loop: CurrentLoop, commission: Commission) -> int:
    """Multiply a quarter of the table by the wave; return 1 after the last quarter, else 0."""
    begin = commission.bin_next
    cosine = commission.cosine_sum
    sine = commission.sine_sum
    for at_bin in range(begin, begin + _BINS):
        at = (at_bin + at_bin + 1) * commission.order & _SINE_STEPS
        value = saturate(commission.cogging_bins[at_bin] + 128 >> 8, -32767, 32767)
        cosine += value * loop.sine[at + COSINE_AT] + 0x4000 >> 15
        sine += value * loop.sine[at] + 0x4000 >> 15
    commission.cosine_sum = cosine
    commission.sine_sum = sine
    commission.bin_next = (begin + _BINS) % COGGING_BINS
    if commission.bin_next > 0:
        return 0
    return 1


@hot
def wave_amplitude(commission: Commission) -> int:
    """Return the amplitude of the wave that was searched for, in cu, Q4, or in rate if that was added up.

    A bin is 1/512 of the table wide: its mean is sin(x) / x of the wave in its middle, x = pi order / 512.
    """
    order = commission.order
    sums = hypot(commission.cosine_sum, commission.sine_sum)
    current = ratio(sums, saturate(commission.way, 1, _TABLE_MOST), 9) * 8 // 5
    current = saturate(current, 0, 0x7FFF)
    return current + (current * (order * order * 105 >> 12) >> 12)
