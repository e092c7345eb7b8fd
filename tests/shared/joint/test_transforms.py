"""Clarke, Park and their inverses against the float twin, over their whole ranges."""

import math

from hypothesis import given
from hypothesis import strategies as st

from shared.fixed import cos_q15, sin_q15
from shared.joint import transforms
from tests.float_twin import joint_current as twin

PHASE = st.integers(-16383, 16383)
ANGLE = st.integers(0, 65535)


def vector(length, turn):
    return round(length * math.cos(turn)), round(length * math.sin(turn))


@given(PHASE, PHASE, PHASE)
def test_clarke(a, b, c):
    assert abs(transforms.clarke_alpha(a, b, c) - twin.clarke_alpha(a, b, c)) <= 0.5 + abs(2 * a - b - c) / 8192
    assert abs(transforms.clarke_beta(b, c) - twin.clarke_beta(b, c)) <= 0.5 + abs(b - c) / 32768


def test_clarke_of_a_known_vector_and_of_an_offset():
    assert transforms.clarke_alpha(2000, 0, 0) == 1333
    assert transforms.clarke_beta(0, 0) == 0
    assert transforms.clarke_alpha(700, 700, 700) == 0


@given(st.integers(0, 31999), st.floats(0, math.tau), ANGLE)
def test_park_and_back(length, turn, angle_brad):
    x, y = vector(length, turn)
    s, c, angle = sin_q15(angle_brad), cos_q15(angle_brad), angle_brad / 65536 * math.tau
    allowed = 0.51 + length / 16000
    for name in ("park_d", "park_q", "unpark_alpha", "unpark_beta"):
        assert abs(getattr(transforms, name)(x, y, s, c) - getattr(twin, name)(x, y, angle)) <= allowed, name


def test_park_at_ninety_degrees():
    s, c = sin_q15(0x4000), cos_q15(0x4000)
    assert (transforms.park_d(4000, 0, s, c), transforms.park_q(4000, 0, s, c)) == (0, -4000)
