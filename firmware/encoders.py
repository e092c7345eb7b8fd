"""A 14-bit magnetic encoder over SPI, AS5047P's frames (data sheet section SPI): even parity, error flag, angle.

The answer to a read comes with the next one, so an angle is as old as the time between two reads. Which encoders
the joint has is not published: these frames are assumed.
"""

from shared.runtime import const, hot

READ_ANGLE = const(0xFFFF)  # read 0x3FFF with its parity
_ERROR = const(0x4000)


@hot
def angle_of(word: int) -> int:
    """Return the angle, 0 .. 16383, or -1 if parity, the error flag or an idle line says it is none."""
    if word < 0 or word & _ERROR or word == 0xFFFF or parity(word):
        return -1
    return word & 0x3FFF


@hot
def parity(word: int) -> int:
    """Return 1 if a 16-bit word has an odd number of ones, else 0."""
    word ^= word >> 8
    word ^= word >> 4
    word ^= word >> 2
    word ^= word >> 1
    return word & 1
