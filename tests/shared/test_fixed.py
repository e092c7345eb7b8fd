"""shared/num/fixed.py against real numbers: every error stated in its docstrings, over the whole ranges."""

import math

import pytest
from hypothesis import example, given, settings

from host.boards.build import tables
from shared.num.fixed import (
    atan2_brad,
    atan2_brad18,
    cos_q15,
    fall_q15,
    hypot,
    isqrt,
    mul_q15,
    ratio,
    round_brad,
    round_sqrt,
    saturate,
    sin_q15,
    wrap_brad,
)
from tests.float_twin import fixed as twin
from tests.float_twin.joint_motion import fall

from .bars import LARGEST, integers

SIDES = integers(-LARGEST, LARGEST)
BRAD18_DEG = 360 / (1 << 18)


def test_sine_and_cosine_are_within_one_lsb_of_every_angle():
    worst = max(
        max(abs(sin_q15(a) - 32768 * twin.sine(a)), abs(cos_q15(a) - 32768 * twin.cosine(a))) for a in range(65536)
    )
    assert worst <= 1.0


def test_sine_is_odd_and_reaches_its_ends():
    assert all(sin_q15(-a) == -sin_q15(a) for a in range(32769))
    assert [sin_q15(a) for a in (0, 16384, 32768, 49152)] == [0, 32767, 0, -32767]


@settings(max_examples=300)
@given(integers(-LARGEST - 1, LARGEST - 16384))
def test_sine_and_cosine_wrap(angle):
    assert sin_q15(angle) == sin_q15(angle % 65536)
    assert cos_q15(angle) == cos_q15(angle % 65536)


def arctangent_error_deg(y, x):
    """Return how far atan2_brad18 is from the angle, on the circle."""
    away = atan2_brad18(y, x) * BRAD18_DEG - twin.angle_deg(y, x)
    return abs((away + 180) % 360 - 180)


def fan(count, radius):
    """Return points all round a circle, the axes and diagonals included."""
    steps = [2 * math.pi * i / count for i in range(count)]
    return [(round(radius * math.sin(a)), round(radius * math.cos(a))) for a in steps]


@pytest.mark.parametrize("radius", [1, 7, 300, 32767, 131071, 131072, 0x1FFFFF, 0x200001, 0x7FFFFF, 0x800003, LARGEST])
def test_arctangent_is_within_its_bar_in_all_octants(radius):
    assert max(arctangent_error_deg(y, x) for y, x in fan(2048, radius)) <= 0.0025


def test_arctangent_of_every_ratio_of_its_table():
    far = 1 << 17
    assert max(arctangent_error_deg(near, far) for near in range(0, far + 1, 7)) <= 0.0025


@settings(max_examples=2000)
@given(SIDES, SIDES)
@example(0, -LARGEST)
@example(LARGEST, -LARGEST)
@example(-1, -LARGEST)
@example(1, -1)
def test_arctangent_is_within_its_bar_anywhere(y, x):
    assert arctangent_error_deg(y, x) <= 0.0025
    assert -131072 <= atan2_brad18(y, x) <= 131071
    assert atan2_brad(y, x) == round_brad(atan2_brad18(y, x))


def test_arctangent_of_the_axes_is_exact():
    for size in (1, 5, 40000, LARGEST):
        assert [atan2_brad(*p) for p in ((0, size), (size, 0), (0, -size), (-size, 0))] == [0, 16384, -32768, -16384]
        assert atan2_brad(size, size) == 8192
    assert atan2_brad18(0, 0) == 0


@settings(max_examples=300)
@given(integers(-LARGEST + 3, LARGEST - 3))
def test_round_brad_wraps_and_is_half_a_unit_at_most(angle_brad18):
    rounded = round_brad(angle_brad18)
    assert -32768 <= rounded <= 32767
    assert abs((angle_brad18 / 4 - rounded + 32768) % 65536 - 32768) <= 0.5


def test_square_root_is_exact_next_to_every_square():
    for k in range(1, 32768):
        square = k * k
        assert isqrt(square - 1) == k - 1
        assert isqrt(square) == k
        assert isqrt(square + 1) == k


@settings(max_examples=2000)
@given(integers(0, LARGEST))
def test_square_root_is_the_exact_floor(n):
    assert isqrt(n) == math.isqrt(n)
    assert abs(round_sqrt(n) - math.sqrt(n)) <= 0.5


@pytest.mark.parametrize("n", [-1, -LARGEST - 1])
def test_square_root_of_a_negative_is_zero(n):
    assert isqrt(n) == round_sqrt(n) == 0


@settings(max_examples=2000)
@given(integers(-(1 << 29) + 1, (1 << 29) - 1), integers(-(1 << 29) + 1, (1 << 29) - 1))
@example((1 << 29) - 1, (1 << 29) - 1)
@example(32767, 5)
@example(23170, 23170)
def test_hypot_is_exact_below_30_bits_and_close_above(x, y):
    exact = x * x + y * y
    if exact < 1 << 30:
        assert hypot(x, y) == math.isqrt(exact)
    else:
        assert abs(hypot(x, y) - math.sqrt(exact)) <= math.sqrt(exact) / 8192


@settings(max_examples=500)
@given(integers(-LARGEST, LARGEST), integers(-32768, 32767))
def test_mul_q15_rounds_to_nearest(a, b):
    if abs(a * b) <= (1 << 30) - (1 << 15):
        assert abs(mul_q15(a, b) - a * b / 32768) <= 0.5


@settings(max_examples=300)
@given(integers(-LARGEST, LARGEST), integers(-LARGEST, LARGEST), integers(-LARGEST, LARGEST))
def test_saturate_limits(value, one, other):
    low, high = min(one, other), max(one, other)
    assert saturate(value, low, high) == twin.limit(value, low, high)


@given(integers(0, LARGEST), integers(1, 1 << 29), integers(0, 30))
def test_a_ratio_is_exact_or_at_its_end(numerator, denominator, bits):
    exact = (numerator << bits) // denominator
    found = ratio(numerator, denominator, bits)
    assert found == exact if exact < 1 << 29 else found <= min(exact, LARGEST)


def test_a_ratio_of_nothing_is_0():
    assert (ratio(5, 0, 3), ratio(-1, 7, 3)) == (0, 0)


@given(integers(-(1 << 28), 1 << 28), integers(-16383, 16383), integers(-16383, 16383))
def test_a_fall_is_linear_between_its_ends(value, start, end):
    exact = fall(value, start, end) if start <= end else fall(-value, -start, -end)
    assert abs(fall_q15(value, start, end) / 32768 - exact) <= 1 / 32768


@given(integers(-(1 << 29), 1 << 29))
def test_wrap_brad_takes_whole_turns_away(angle):
    wrapped = wrap_brad(angle)
    assert -32768 <= wrapped <= 32767
    assert (angle - wrapped) % 65536 == 0


def test_the_tables_are_what_their_generator_writes():
    assert tables.TARGET.read_text() == tables.render()
