"""shared/planner/posture.py: slow moves start where the joints are, end at the goal, and are nowhere too fast."""

import random
from array import array
from itertools import pairwise

from hypothesis import given, settings

from shared.planner import posture as m
from tests.float_twin.swing import advance

from .bars import ANGLES, integers
from .robots import block


def moved(start, goal, step):
    """Return the joints at every tick of a move, the start first."""
    params, move = block("caramelo"), m.Move()
    params.joint_speed_slow = step
    joints = array("i", start)
    ticks = m.posture_start(params, move, joints, array("i", goal))
    found = [list(joints)]
    for left in range(ticks - 1, -1, -1):
        assert m.posture_step(move, joints) == left
        found.append(list(joints))
    assert m.posture_step(move, joints) == 0
    return found


@settings(max_examples=60)
@given(ANGLES, ANGLES, integers(40, 2000))
def test_a_move_keeps_its_speed_starts_at_the_start_and_ends_at_the_goal(start, goal, step):
    found = moved(start, goal, step)
    assert found[0] == list(start)
    assert found[-1] == list(goal)
    fastest = max(abs(b - a) for one, two in pairwise(found) for a, b in zip(one, two, strict=True))
    assert fastest <= step + 4


def test_a_move_is_the_cycloid():
    dice = random.Random(5)
    start, goal = [[dice.randint(-32768, 32767) for _ in range(12)] for _ in range(2)]
    found = moved(start, goal, 120)
    ticks = len(found) - 1
    for tick, joints in enumerate(found[:-1]):
        share = advance(tick / ticks)
        assert max(abs(q - a - (b - a) * share) for q, a, b in zip(joints, start, goal, strict=True)) <= 4.5


def test_the_slowest_move_there_is_takes_its_time_and_ends():
    found = moved([-32768] * 12, [32767] * 12, 1)
    assert len(found) == 2 + 2 * 65535
    assert found[-1] == [32767] * 12


def test_a_step_of_nothing_is_taken_as_one():
    assert len(moved([0] * 12, [10] * 12, 0)) == len(moved([0] * 12, [10] * 12, 1))


@settings(max_examples=200)
@given(integers(1, 1 << 20), integers(0, 1 << 20))
def test_phase_of_is_the_ratio(ticks, tick):
    tick = tick % (ticks + 1)
    assert abs(m.phase_of(tick, ticks) - 65536 * tick / ticks) <= 9
    assert m.phase_of(ticks, ticks) == 65536
