"""shared/body/pose.py against the float matrices: the rotation, the foot error."""

import math
import random
from array import array
from statistics import median_high

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from shared.body.axes import POSE_AXES, Pose
from shared.body.feet import Feet
from shared.body.pose import body_rotation, body_to_hip, mul_unit
from shared.record import pack, unpack
from tests.float_twin import body as twin
from tests.float_twin.si import leg_si, rad

from .bars import LARGEST, integers
from .robots import NAMES, block

BLOCKS = {name: block(name) for name in NAMES}
ANGLES = st.tuples(*[integers(-65536, 65536)] * 3)


def pose_si(pose, unit_m):
    """Return an integer pose in m and rad."""
    return [v * unit_m for v in pose[:3]] + [rad(v) for v in pose[3:]]


def rotated(pose):
    """Return the nine Q14 numbers of a pose."""
    rotation = array("i", [0] * 9)
    body_rotation(unpack(Pose(), pose), rotation)
    return rotation


@settings(max_examples=1500)
@given(ANGLES)
def test_rotation_is_eq_8_within_its_error(angles):
    exact = twin.rotation(pose_si((0, 0, 0, *angles), 1))
    got = rotated((0, 0, 0, *angles))
    assert max(abs(got[i] - 16384 * exact[i // 3][i % 3]) for i in range(9)) <= 2.5


def test_rotation_order_is_the_papers_and_not_that_of_ros():
    """Rx(a) Ry(b) Rz(g) turns the body's own z axis to (sb, -sa cb, ca cb); Rz Ry Rx would not."""
    a, b, g = 0.3, 0.2, 0.5
    r = twin.rotation((0, 0, 0, a, b, g))
    axis = math.sin(b), -math.sin(a) * math.cos(b), math.cos(a) * math.cos(b)
    assert [row[2] for row in r] == pytest.approx(axis)
    other = twin.product(twin.product(twin.about(2, g), twin.about(1, b)), twin.about(0, a))
    assert [row[2] for row in other] != pytest.approx(axis, abs=0.01)


def test_no_rotation_is_exactly_none():
    assert list(rotated([0] * POSE_AXES)) == [16384, 0, 0, 0, 16384, 0, 0, 0, 16384]


def unit(value_q15):
    """Return a Q15 number with 32767 read as 1."""
    return 32768 if value_q15 == 32767 else value_q15


@settings(max_examples=500)
@given(integers(-32767, 32767), integers(-32767, 32767))
def test_mul_unit_reads_32767_as_one(a, b):
    exact = unit(a) * unit(b) / 32768
    got = mul_unit(a, b)
    assert min(abs(got - exact), abs(unit(got) - exact)) <= 0.5


def poses(params, count, seed):
    """Return poses over the whole range of a robot's body limits, every corner of it first."""
    dice = random.Random(seed)
    top = pack(params.pose_max)
    corners = [[top[i] if k >> i & 1 else -top[i] for i in range(POSE_AXES)] for k in range(1 << POSE_AXES)]
    return corners + [[dice.randint(-v, v) for v in top] for _ in range(count)]


def body_errors_m(name, count):
    """Return how far the feet that the integers give to the hips are from the float ones."""
    params, feet, hip_feet = BLOCKS[name], Feet(), Feet()
    dice, errors = random.Random(3), []
    for pose in poses(params, count, 5):
        rotation = rotated(pose)
        for leg in range(4):
            si = leg_si(params, leg)
            foot = [round(v / si.unit_m) + dice.randint(-6000, 6000) for v in si.rest]
            unpack(feet.legs[leg], foot)
            body_to_hip(params, leg, unpack(Pose(), pose), rotation, feet, hip_feet)
            exact = twin.from_base(pose_si(pose, si.unit_m), [v * si.unit_m for v in foot], si.hip)
            errors.append(math.dist([v * si.unit_m for v in pack(hip_feet.legs[leg])], exact))
    return errors


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_body_error_at_the_foot(name):
    errors = body_errors_m(name, 3000)
    assert max(errors) <= 0.08e-3
    assert median_high(errors) <= 0.03e-3


@settings(max_examples=300)
@given(st.sampled_from(NAMES), st.tuples(*[integers(-(1 << 29), 1 << 29)] * 3), ANGLES, st.integers(0, 3))
def test_far_away_feet_are_limited_not_wrapped(name, place, angles, leg):
    params, hip_feet = BLOCKS[name], Feet()
    feet = unpack(Feet(), list(place) * 4)
    body_to_hip(params, leg, unpack(Pose(), (0, 0, 0, *angles)), rotated((0, 0, 0, *angles)), feet, hip_feet)
    assert max(abs(v) for v in pack(hip_feet)) <= 3 * 65535 + LARGEST // 30000
