"""Streaming joints: limits, steps and the dead-man hold in every tick, whatever is sent."""

import random
from math import inf, nan

import numpy as np
import pytest

from caramelo import JOINT_NAMES, BadValue, Error, Fault, Robot
from host.control.arbiter import DEAD_MAN_S
from host.robot.scale import joints_rad
from tests.host.library.places import prompt, robot_in

FAST = 3.0  # rad/s
TINY = 1e-9


def written(robot):
    return robot._place.hardware.bus.written


def complaints(robot, goals, speed_rad_s):
    """Return what is wrong with the goals of consecutive ticks: a limit passed, a step too long."""
    step, wrong = speed_rad_s / 50, []
    for tick, row in enumerate(goals):
        for name, angle, (low, high) in zip(JOINT_NAMES, row, robot.joint_limits_rad, strict=True):
            if not low - TINY <= angle <= high + TINY:
                wrong.append(f"{name} {angle} in tick {tick}")
        if tick and max(abs(a - b) for a, b in zip(row, goals[tick - 1], strict=True)) > step + TINY:
            wrong.append(f"step in tick {tick}")
    return wrong


def hostile(dice):
    """Return something that nobody should send."""
    one = dice.choice([nan, inf, -inf, 1e308, -1e30, 10**400, 7.0, -7.0, None, "1", 1j, [], True, 3.2, np.float32(9)])
    return dice.choice(
        [
            lambda: [dice.uniform(-4, 4) for _ in range(12)],
            lambda: [dice.choice([-1e9, 1e9]) for _ in range(12)],
            lambda: [one] * 12,
            lambda: [0.0] * 11 + [one],
            lambda: [0.0] * dice.choice([0, 1, 11, 13, 1000]),
            lambda: np.full((12,), dice.uniform(-9, 9)),
            lambda: np.zeros((12, 3)),
            lambda: np.zeros((3, 4)),
            lambda: one,
            lambda: {dice.choice([*JOINT_NAMES, "FR", "", 3, None]): one},
            lambda: dict.fromkeys(JOINT_NAMES, dice.uniform(-9, 9)),
            lambda: b"123456789012",
            lambda: "123456789012",
            lambda: (angle for angle in [5.0] * 12),
        ]
    )()


@pytest.mark.parametrize("count", [300, pytest.param(10_000, marks=pytest.mark.slow)])
def test_hostile_streams_pass_no_limit_and_make_no_jump(robot, count):
    """Requirement: no stream, whatever it sends, moves a joint beyond its limit or faster than was asked."""
    dice, refused, seen = random.Random(18), 0, len(written(robot))
    for _ in range(count):
        for _ in robot.stream(hz=50, joint_rad_s=FAST, seconds=0.04):
            try:
                robot.set_joints(hostile(dice))
            except BadValue:
                refused += 1
            if dice.random() < 0.3:
                break
    assert complaints(robot, written(robot)[seen:], FAST) == []
    assert 0.5 * count < refused < 1.5 * count, "both kinds were sent: what is refused and what is limited"
    assert robot.sensed.fault == ""


@pytest.mark.parametrize(("row", "words"), [([9.0] * 12, "FR_hip 9.0 in tick 1"), ([0.5] * 12, "step in tick 1")])
def test_a_limit_passed_and_a_jump_are_found(robot, row, words):
    middle = [(low + high) / 2 for low, high in robot.joint_limits_rad]
    assert any(words in each for each in complaints(robot, [middle, row], FAST))


@pytest.mark.parametrize(
    ("goals", "words"),
    [
        ([0.0] * 11, "11 values: allowed 12"),
        (3, "int: allowed 12 angles"),
        ([0.0] * 11 + [nan], "RL_calf nan: allowed a finite angle in rad"),
        ([10**5000] * 12, "FR_hip inf: allowed a finite angle"),
        ([True] * 12, "FR_hip True: allowed a finite angle"),
        ({"tail": 1.0}, "joint 'tail': allowed FR_hip, "),
        (np.zeros((12, 2)), r"FR_hip .*: allowed a finite angle"),
    ],
)
def test_what_is_wrong_is_named_and_changes_nothing(robot, goals, words):
    for _ in robot.stream(seconds=0.1):
        robot.set_joints({"FR_hip": 0.1})
        before = list(robot._opened.supervisor.stream.wished)
        with pytest.raises(BadValue, match=words):
            robot.set_joints(goals)
        assert robot._opened.supervisor.stream.wished == before


def test_what_is_limited_is_told(robot):
    for _ in robot.stream(seconds=0.1):
        assert robot.set_joints({"FR_calf": 9.0, "RL_hip": 0.1}) == ("FR_calf",)


def test_goals_are_approached_at_the_speed_asked_for(robot):
    start = robot.sensed.goals_rad[0]
    for _ in robot.stream(joint_rad_s=0.5, seconds=1.0):
        robot.set_joints({"FR_hip": start + 0.2})
    ways = [abs(b[0] - a[0]) for a, b in zip(written(robot), written(robot)[1:], strict=False)]
    assert max(ways) == pytest.approx(0.5 / 50)
    assert robot.sensed.goals_rad[0] == pytest.approx(start + 0.2)


def test_who_falls_silent_gets_the_stance_back(robot):
    """0.4 rad at 2 rad/s take 0.2 s of the dead-man's 0.3; the way back takes 0.5 s at the 0.8 rad/s of standing up."""
    for number, now in enumerate(robot.stream(joint_rad_s=2.0, seconds=2.0)):
        if number == 0:
            robot.set_joints({"FR_hip": 0.4})
        if number == round(DEAD_MAN_S * 50) - 1:
            assert now.goals_rad[0] == pytest.approx(0.4)
    assert now.goals_rad[0] == pytest.approx(joints_rad(robot._opened.supervisor.driver.planner.joints)[0])
    assert abs(now.goals_rad[0]) < 0.1


def test_after_a_stream_it_stands_again_before_it_walks(robot):
    for now in robot.stream(joint_rad_s=2.0, seconds=0.5):
        robot.set_joints([angle + 0.15 for angle in now.goals_rad])
    seen = len(written(robot))
    robot.walk(0.05, seconds=0.2)
    assert complaints(robot, written(robot)[seen - 1 : seen + 5], 0.8) == [], "as fast as it stands up"
    assert robot.sensed.state == "standing"


def test_joints_are_set_in_a_stream_only(robot):
    with pytest.raises(Error, match="only within a loop"):
        robot.set_joints([0.0] * 12)
    with Robot(prompt()) as limp, pytest.raises(Error, match="does not stand"):
        next(limp.stream())


def test_a_fault_ends_a_stream(robot):
    robot._place.hardware.bus.error[7] = "overload"
    with pytest.raises(Fault, match="RR thigh: overload"):
        list(robot.stream(seconds=1.0))
    with pytest.raises(Error, match="only within a loop"):
        robot.set_joints([0.0] * 12)


def test_an_emergency_stop_in_a_stream_lets_go(robot):
    stream = robot.stream(joint_rad_s=1.0)
    next(stream)
    robot.set_joints({"FR_hip": 0.2})
    robot.stop()
    count = len(written(robot))
    with pytest.raises(Fault, match="emergency stop"):
        next(stream)
    assert len(written(robot)) == count


def test_a_block_left_in_the_middle_of_a_stream_sits_down_from_there():
    robot = Robot(prompt())

    def program():
        with robot:
            robot.stand()
            for now in robot.stream(joint_rad_s=2.0):
                robot.set_joints({"FR_calf": now.goals_rad[2] - 0.3})
                if now.goals_rad[2] < robot.joint_limits_rad[2][0] + 0.1:
                    raise KeyError

    with pytest.raises(KeyError):
        program()
    assert robot._place.hardware.bus.stops == 0
    assert complaints(robot, written(robot), 2.0) == []


def test_a_speed_is_walked_until_nothing_is_set():
    """The arbiter's dead-man stops a walk; its 0.3 s and a cycle of the trot (1.12 s) later it stands."""
    states = []
    with robot_in("sim") as robot:
        robot.stand()
        for number, now in enumerate(robot.stream(hz=10, seconds=4.0)):
            if number < 10:
                robot.set_speed(0.05)
            states.append(now.state)
        assert robot.odometry.x_m > 0.02
    assert states[5:10] == ["walking"] * 5
    assert states[-1] == "standing"


def test_one_either_walks_or_sets_joints(robot):
    for _ in robot.stream(seconds=0.04):
        robot.set_joints({"FR_hip": 0.1})
        for drive in (lambda: robot.set_speed(0.05), lambda: robot.walk(0.05, seconds=1), lambda: robot.turn(deg=3)):
            with pytest.raises(Error, match="set_joints moves the joints"):
                drive()
    for now in robot.stream(seconds=0.4):
        robot.set_speed(0.05)
        if now.state == "walking":
            with pytest.raises(Error, match="does not stand, it is walking"):
                robot.set_joints({"FR_hip": 0.1})
    robot.turn(deg=3)
    assert robot.sensed.state == "standing"
    with pytest.raises(Error, match="set_speed: only within a loop"):
        robot.set_speed(0.05)
