"""What the tests of the core share: integers of 30 bits."""

from hypothesis import strategies as st

LARGEST = (1 << 30) - 1


def integers(low, high):
    """Return integers of a range, with those next to the powers of two more often than chance has them."""
    edges = sorted({sign * (1 << k) + d for k in range(31) for d in (-1, 0, 1) for sign in (-1, 1)} | {low, high})
    inside = [edge for edge in edges if low <= edge <= high]
    return st.one_of(st.integers(low, high), st.sampled_from(inside))


WORD = integers(-LARGEST - 1, LARGEST)
INT16 = integers(-32768, 32767)
ANGLES = st.lists(INT16, min_size=12, max_size=12)  # of all joints, brad


def any_word(dice):
    """Return any 30-bit word, of any size."""
    return dice.randint(-(1 << 30), (1 << 30) - 1) >> dice.randrange(30)
