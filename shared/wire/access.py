"""Whether a parameter may be read or written, as RESULT_*; a value out of range is refused, never limited."""

from ..runtime import const, hot, ptr16, ptr32
from .names import RESULT_NEEDS_DISARMED, RESULT_OK, RESULT_OUT_OF_RANGE, RESULT_READ_ONLY, RESULT_UNKNOWN_PARAMETER
from .parameters import PARAMETER_FLAGS, PARAMETER_HIGH, PARAMETER_LOW, PARAMETERS

_ACCESS_MASK = const(3)
_ACCESS_DISARMED = const(2)
_STORED = const(4)
_NOT_ZERO = const(8)


@hot
def may_read(parameter: int) -> int:
    """Return RESULT_OK or RESULT_UNKNOWN_PARAMETER for any id."""
    if parameter < 0 or parameter >= PARAMETERS:
        return RESULT_UNKNOWN_PARAMETER
    return RESULT_OK


@hot
def may_write(parameter: int, value: int, armed: int) -> int:
    """Return RESULT_OK if ``value`` (raw, within +-2^30) may be written to any id, else the reason why not.

    ``armed`` is not 0 while the drive is enabled. Checked in this order: unknown, read only, armed, out of range.
    """
    if parameter < 0 or parameter >= PARAMETERS:
        return RESULT_UNKNOWN_PARAMETER
    flags = ptr16(PARAMETER_FLAGS)
    low = ptr32(PARAMETER_LOW)
    high = ptr32(PARAMETER_HIGH)
    access = flags[parameter] & _ACCESS_MASK
    if access == 0:
        return RESULT_READ_ONLY
    if access == _ACCESS_DISARMED and armed:
        return RESULT_NEEDS_DISARMED
    if value < low[parameter] or value > high[parameter]:
        return RESULT_OUT_OF_RANGE
    if value == 0 and flags[parameter] & _NOT_ZERO:
        return RESULT_OUT_OF_RANGE
    return RESULT_OK


@hot
def is_stored(parameter: int) -> int:
    """Return 1 if save_parameters keeps this id over a power cycle, else 0."""
    if parameter < 0 or parameter >= PARAMETERS:
        return 0
    flags = ptr16(PARAMETER_FLAGS)
    return (flags[parameter] & _STORED) >> 2
