"""A 14-bit magnetic encoder over SPI, AS5047P's frames (data sheet section SPI): even parity, error flag, angle.

The answer to a read comes with the next one, so an angle is as old as the time between two reads. Which encoders
the joint has is not published: these frames are assumed.
"""

from shared.runtime import const

_READ_ANGLE_HIGH = const(0xFF)  # read 0x3FFF with its parity: 0xFFFF
_READ_ANGLE_LOW = const(0xFF)
_ERROR = const(0x4000)


class MagneticEncoder:
    """``spi`` is a machine.SPI in mode 1, ``select`` the chip select pin (active low)."""

    def __init__(self, spi, select):
        self._spi = spi
        self._select = select
        self._out = bytearray((_READ_ANGLE_HIGH, _READ_ANGLE_LOW))
        self._in = bytearray(2)
        select(1)

    def read(self):
        """Return the angle, 0 .. 16383, or -1 if parity, the error flag or an idle line says it is none."""
        self._select(0)
        self._spi.write_readinto(self._out, self._in)
        self._select(1)
        word = self._in[0] << 8 | self._in[1]
        if word & _ERROR or word == 0xFFFF or parity(word):
            return -1
        return word & 0x3FFF


def parity(word):
    """Return 1 if a 16-bit word has an odd number of ones, else 0."""
    word ^= word >> 8
    word ^= word >> 4
    word ^= word >> 2
    word ^= word >> 1
    return word & 1
