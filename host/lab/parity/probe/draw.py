"""Repeatable integers: a generator, ranges with edges, and the digest, all within 31-bit small integers.

Nothing here is ever larger than 2^30 - 1, so drawing and digesting allocate nothing on a 32-bit VM.
"""

from array import array

EDGES = (0, 1, 2, 127, 255, 256, 4095, 8191, 16384, 32767, 32768, 65535, 65536, 1 << 20, 1 << 24, 1 << 29)
WORD = 0x3FFFFFFF
ROW = 200  # no record has more integers that are fields of their own
_CELL = array("i", [0])


def small(value: int) -> int:
    """Return the same number as a small integer: a sum that left the small ones on its way stays on the heap."""
    _CELL[0] = value
    return int(_CELL[0])


class Dice:
    """Two multiply-with-carry generators (Marsaglia) of 29 bits; a 2^16 - 1 a safe prime, period > 2^27 each."""

    def __init__(self, seed: int) -> None:
        self.x = seed % 65521 + 1
        self.y = (seed * 7) % 65519 + 1

    def bits(self, count: int) -> int:
        """Return 0 .. 2^count - 1, count 1 .. 30."""
        self.x = 8055 * (self.x & 0xFFFF) + (self.x >> 16)
        self.y = 7563 * (self.y & 0xFFFF) + (self.y >> 16)
        return ((self.x & 0x7FFF) << 15 | (self.y >> 3 & 0x7FFF)) >> (30 - count)

    def below(self, count: int) -> int:
        """Return 0 .. count - 1, count 1 .. 2^30 - 1."""
        return self.bits(30) % count

    def choose(self, choices):
        """Return one of some objects."""
        return choices[self.below(len(choices))]


class Range:
    """Integers ``low .. high``: its edges first, then evenly spread and spread over the powers of two."""

    def __init__(self, low: int, high: int) -> None:
        low = small(low)
        high = small(high)
        self.low = low
        self.high = high
        found = []
        edges = [low, low + 1, high - 1, high]
        edges.extend(EDGES)
        edges.extend([-edge for edge in EDGES])
        for edge in edges:
            if low <= edge <= high and edge not in found:
                found.append(edge)
        self.edges = found
        self.even = high - low < WORD

    def edge(self, index: int) -> int:
        return self.edges[index % len(self.edges)]

    def any(self, dice: Dice) -> int:
        way = dice.bits(2)
        if way == 0:
            return dice.choose(self.edges)
        if way < 3 and self.even:
            return self.low + dice.below(self.high - self.low + 1)
        value = dice.bits(30)
        if way == 3:
            value >>= dice.below(30)
        if dice.bits(1):
            value = -1 - value
        while value < self.low or value > self.high:
            if value in (0, -1):
                return self.low if self.low > 0 else self.high
            value >>= 1
        return value


# What several modules draw from.
INT30 = Range(-(1 << 30), (1 << 30) - 1)
HALF30 = Range(-(1 << 29), (1 << 29) - 1)
INT16 = Range(-32768, 32767)
BRAD = INT16
UNIT = Range(-32767, 32767)  # Q15 of -1 .. 1, and places in lu
SHARE = Range(0, 32767)  # Q15 of 0 .. 1, and gains
FORCE = Range(-16383, 16383)  # Q12
LEG = Range(0, 3)
FLAG = Range(0, 1)


class Digest:
    """A running check number of 30 bits: two polynomials modulo primes below 2^15.

    ``row``, which all digests share, is for integers that are to be taken at once: most of a comparison's time goes
    by here.
    """

    row = [0] * ROW

    def __init__(self) -> None:
        self.a = 1
        self.b = 1

    def add(self, value: int) -> None:
        """Take one integer."""
        self.row[0] = value
        self.add_all(self.row, 1)

    def add_all(self, values, count: int) -> None:
        """Take the first ``count`` integers, within -2^30 .. 2^30-1; ValueError for anything else."""
        a, b = self.a, self.b
        for at in range(count):
            value = values[at]
            if not isinstance(value, int) or not -WORD - 1 <= value <= WORD:
                raise ValueError(f"not a small integer: {value!r}")
            a = (a * 30011 + value % 32749) % 32749
            b = (b * 29009 + value % 32719) % 32719
        self.a, self.b = a, b

    def number(self) -> int:
        return self.a << 15 | self.b
