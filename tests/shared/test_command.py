"""shared/planner/command.py: speeds and poses move towards any command by at most their slew, within limits."""

from hypothesis import given, settings
from hypothesis import strategies as st

from shared.body.axes import Pose, Twist
from shared.gait.gaits import PAPER_TROT
from shared.gait.table import compile_gait
from shared.planner import command as c
from shared.record import pack, unpack
from tests.float_twin.fixed import towards

from .bars import WORD, integers
from .robots import block

HALF = integers(-(1 << 29), (1 << 29) - 1)
PARAMS = block("caramelo")
GAIT = compile_gait(PAPER_TROT, PARAMS)


def test_a_frame_has_room_for_a_whole_command():
    assert len(pack(c.Command())) == c.COMMAND_SIZE


@settings(max_examples=300)
@given(HALF, HALF, integers(0, (1 << 29) - 1))
def test_slew_goes_towards(now, wanted, step):
    assert c.slew(now, wanted, step) == towards(now, wanted, step)


@settings(max_examples=200)
@given(st.lists(WORD, min_size=3, max_size=3), st.integers(0, 2), st.lists(st.integers(-9, 9), min_size=3, max_size=3))
def test_speed_is_slewed_within_its_limits(asked, halves, share):
    command, tops = c.Command(), pack(GAIT.speed_max)
    unpack(command.speed, asked)
    speed = unpack(Twist(), [top * part // 9 for top, part in zip(tops, share, strict=True)])
    before = pack(speed)
    still = c.slew_speed(PARAMS, GAIT.speed_max, command, halves, speed)
    for axis in range(3):
        limited = max(-tops[axis], min(tops[axis], asked[axis]))
        assert abs(speed[axis] - towards(before[axis], limited * halves / 2, PARAMS.speed_slew[axis])) <= 0.5
        assert abs(speed[axis]) <= tops[axis]
    assert still == (not any(pack(speed)))


@settings(max_examples=200)
@given(st.lists(WORD, min_size=6, max_size=6), st.integers(0, 1))
def test_pose_is_slewed_within_its_limits(asked, standing):
    command, pose = c.Command(), Pose()
    unpack(command.pose, asked)
    for _ in range(200):
        before = pack(pose)
        c.slew_pose(PARAMS, command, standing, pose)
        assert all(abs(pose[axis] - before[axis]) <= PARAMS.pose_slew[axis] for axis in range(6))
    tops = PARAMS.pose_max
    limited = [max(-top, min(top, value)) for top, value in zip(pack(tops), asked, strict=True)]
    assert pack(pose) == (limited if standing else [0] * 6)
