"""The planner against the float planner, tick by tick: feet on the ground and in the air, joints, states."""

import math
import random
from types import SimpleNamespace

import pytest

from shared.planner import command as c
from shared.planner import status as n
from shared.record import unpack
from tests.float_twin import planner as twin
from tests.float_twin.gait import Gait
from tests.float_twin.si import planner_si, rad, scaled

from .walker import NAMES, TABLE_GAITS, TABLES, Walker


class Pair:
    """An integer planner and a float one with the same command and senses."""

    def __init__(self, name, rate_hz):
        self.walker = Walker(name, rate_hz)
        unpack(self.walker.params.sag_q16, (0, 0, 0))  # the float planner has no compensation
        self.walker.params.lateral_q12 = 0
        self.robot = planner_si(self.walker.params)
        self.twin = twin.Planner(self.robot, [Gait(table, rate_hz) for table in TABLES])

    def command_si(self):
        """Return the command in SI, as the float planner takes it."""
        block, robot = self.walker.command, self.robot
        return SimpleNamespace(
            mode=block.mode,
            gait=block.gait,
            speed=scaled(block.speed, robot.speed_unit),
            pose=scaled(block.pose, robot.pose_unit),
            balance=block.balance,
            height_m=block.height * robot.unit_m,
        )

    def sensed_si(self):
        """Return the senses in SI."""
        block = self.walker.sensed
        return SimpleNamespace(
            roll=rad(block.tilt[0]),
            pitch=rad(block.tilt[1]),
            attitude_ok=block.valid.tilt,
            joints=[rad(q) for q in block.joints],
            joints_ok=block.valid.joints,
        )

    def tick(self):
        """One tick of both; returns the largest distance of a foot in m and of a joint in rad."""
        self.twin.tick(self.command_si(), self.sensed_si())
        self.walker.tick()
        self.agree_on_reach()
        assert self.walker.swinging() == sum(1 << leg for leg in range(4) if self.twin.in_air[leg])
        feet = max(math.dist(a, b) for a, b in zip(self.walker.feet_m(), self.twin.planned, strict=True))
        joints = max(abs(rad(a) - b) for a, b in zip(self.walker.planner.joints, self.twin.joints, strict=True))
        return feet, joints

    def agree_on_reach(self):
        """Within rounding of the edge of its reach the float planner goes by the core, else they agree."""
        out_of_reach = bool(self.walker.planner.status.out_of_reach)
        if out_of_reach != any(self.twin.flagged):
            assert self.twin.edge_m < 0.1e-3 or self.twin.edge_rad < 1e-3
            self.twin.flagged = [out_of_reach] * 4

    def stand(self):
        """Both stand up; a rounded way may make one of them a tick later."""
        self.walker.mode(c.MODE_STAND)
        for _ in range(60 * self.walker.rate_hz):
            self.tick()
            if self.walker.state == self.twin.state == n.STANDING:
                return
        raise AssertionError("not standing after a minute")

    def walk(self, gait, speed_m_s, seconds):
        """Walk straight from standing; returns the largest distances. Speeds are made even, as half of them is used."""
        command = self.walker.command
        self.walker.gait(gait)
        self.walker.speed(*speed_m_s)
        for axis in range(3):
            command.speed[axis] &= ~1
        self.walker.mode(c.MODE_WALK)
        errors = []
        for _ in range(int(seconds * self.walker.rate_hz)):
            errors.append(self.tick())
            assert self.walker.state == self.twin.state
        return [max(error) for error in zip(*errors, strict=True)]


RATES = (20, 50, 100, 333, 500)
SPEEDS = ((0.05, 0.0, 0.0), (-0.02, 0.03, 0.0), (0.03, 0.02, -0.15), (0.0, 0.0, 0.15))


@pytest.mark.parametrize("gait", TABLE_GAITS)
@pytest.mark.parametrize("rate_hz", RATES)
def test_walks_are_the_float_walks_at_every_rate(rate_hz, gait):
    pair = Pair("caramelo", rate_hz)
    pair.stand()
    for speed in SPEEDS if rate_hz <= 100 else SPEEDS[2:3]:
        foot_m, joint_rad = pair.walk(gait, speed, 3.0)
        assert foot_m <= 0.05e-3
        assert math.degrees(joint_rad) <= 0.05


@pytest.mark.parametrize(("name", "bar_m"), [("parallel", 0.08e-3), ("long-leg", 0.15e-3), ("unequal", 0.08e-3)])
def test_walks_of_other_robots_are_the_float_walks(name, bar_m):
    pair = Pair(name, 50)
    pair.stand()
    for gait in TABLE_GAITS:
        foot_m, joint_rad = pair.walk(gait, SPEEDS[2], 4.0)
        assert foot_m <= bar_m
        assert math.degrees(joint_rad) <= 0.05


def test_a_restless_driver_is_followed_like_the_float_planner():
    """Speeds, gaits, poses, heights, balance and tilts that change: the same states, feet and joints throughout."""
    pair, dice = Pair("caramelo", 50), random.Random(4)
    pair.stand()
    command, sensed = pair.walker.command, pair.walker.sensed
    params = pair.walker.params
    states, errors = set(), []
    for tick in range(4000):
        if tick % 60 == 0:
            command.mode = dice.choice((c.MODE_STAND, c.MODE_WALK, c.MODE_WALK, c.MODE_WALK))
            command.gait = NAMES.index(dice.choice(list(TABLE_GAITS)))
            command.balance = dice.randrange(2)
            command.height = dice.choice((0, 2000, 5000))
            for axis in range(3):
                top = params.speed_max[axis] // 6
                command.speed[axis] = dice.randint(-top, top) * 2 * dice.randrange(2)
            for axis in range(6):
                command.pose[axis] = dice.randint(-800, 800)
        for axis in range(2):
            sensed.tilt[axis] += dice.randint(-40, 40) - (sensed.tilt[axis] >> 4)
        errors.append(pair.tick())
        assert pair.walker.state == pair.twin.state
        states.add(pair.walker.state)
    foot_m, joint_rad = [max(error) for error in zip(*errors, strict=True)]
    assert states == {n.STANDING, n.WALKING}
    assert foot_m <= 0.05e-3
    assert math.degrees(joint_rad) <= 0.1


def test_standing_up_and_sitting_down_are_the_float_moves():
    pair = Pair("caramelo", 50)
    pair.walker.mode(c.MODE_STAND)
    lag_rad = 2 * rad(pair.walker.params.joint_speed_slow)  # the moves may differ by a tick
    for mode, goal in ((c.MODE_STAND, n.STANDING), (c.MODE_SIT, n.SEATED), (c.MODE_STAND, n.STANDING)):
        pair.walker.mode(mode)
        while pair.walker.state != goal or pair.twin.state != goal:
            assert pair.tick()[1] <= lag_rad
        assert pair.tick()[1] <= math.radians(0.02)


def test_a_planted_error_in_the_twin_is_seen():
    """The comparison can fail: a foot 1 mm off, a swing one tick early."""
    pair = Pair("caramelo", 50)
    pair.stand()
    pair.robot.legs[2].rest[0] += 0.001
    assert pair.walk("even-trot", SPEEDS[0], 2.0)[0] > 0.5e-3
    other = Pair("caramelo", 50)
    other.stand()
    other.twin.gaits[NAMES.index("even-trot")].phases = lambda ticks: [(i + 1) / ticks for i in range(ticks)]
    assert other.walk("even-trot", SPEEDS[0], 2.0)[0] > 0.5e-3
