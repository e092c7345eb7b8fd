"""Limits of a frame's fields against the same said otherwise, over all that a field can hold."""

from hypothesis import given, settings

from shared.wire.limits import differs, limit_but, outside

from ..bars import WORD


@settings(max_examples=300)
@given(WORD, WORD, WORD, WORD)
def test_limits_are_kept_but_for_the_special_value(value, one, other, special):
    low, high = sorted((one, other))
    for drawn in (value, low, high, special):
        wanted = drawn if drawn == special else sorted((low, drawn, high))[1]
        assert limit_but(drawn, low, high, special) == wanted
        assert outside(drawn, low, high, special) == differs(wanted, drawn) == int(wanted != drawn)
