"""Somebody lifts a robot in space: noticed within half a second, its legs stop, it waits for a new command."""

import pytest

from host.robot.file import load_robot, robot_names
from host.sim.space.walk import SpaceWalker
from host.sim.walk import WalkSpec

from .hand import Hand, lifted_m

NOTICED_S, STILL_S = 0.5, 1.5
LIFT_M, HELD_S = 0.12, 3.0


class Lifted:
    """A robot that walks for 4 s and is then lifted for 3 s."""

    def __init__(self, name, gait="trot", speed=0.1, roll_rad=0.0, honest=None):
        self.walker = SpaceWalker(WalkSpec(load_robot(name).simulated(honest), gait))
        self.driver, self.world, self.roll_rad = self.walker.driver, self.walker.world, roll_rad
        self.walker.stand_up()
        self.tell(speed)
        self.go(4.0)
        assert not self.driver.lifted
        self.touched_s = self.noticed_s = self.moved_s = 0.0
        self.hand = Hand(self.world)
        self.go(HELD_S, self.held)
        self.hand.let_go()

    def tell(self, speed):
        self.driver.set_command(mode="walk" if speed else "stand", vx_m_s=speed)

    def go(self, seconds, each=lambda time_s: None):
        for tick in range(round(seconds * self.driver.rate_hz)):
            each(tick / self.driver.rate_hz)
            self.walker.tick()

    def held(self, time_s):
        """Hold it, and keep when it last touched the ground, was noticed to be lifted, and moved its goals last."""
        up_m = lifted_m(time_s, LIFT_M, HELD_S)
        self.hand.hold(up_m, self.roll_rad * up_m / LIFT_M)
        in_air = up_m == LIFT_M
        if not in_air and not self.noticed_s and sum(self.world.foot_loads_N()[0]) > 0:
            self.touched_s = time_s
        if self.driver.lifted and not self.noticed_s:
            self.noticed_s, self.odometry = time_s, self.driver.odometry
        if in_air and self.noticed_s:
            assert self.driver.odometry.x_m == self.odometry.x_m
            goals = list(self.walker.goals)
            self.moved_s = self.moved_s if goals == getattr(self, "goals", None) else time_s
            self.goals = goals

    def x_m(self):
        return float(self.world.position_m()[0])


WALKS = [
    ("caramelo", "trot", 0.25, {}),
    ("caramelo", "trot", 0.1, {"honest": True, "roll_rad": 0.5}),
    ("caramelo", "crawl", 0.05, {}),
    ("caramelo", "paper-trot", 0.05, {}),
    ("caramelo", "trot", 0.0, {}),
    ("parallel", "trot", 0.25, {}),
    ("parallel", "trot", 0.1, {"honest": True, "roll_rad": 0.5}),
    ("parallel", "crawl", 0.05, {}),
]


@pytest.mark.parametrize(("name", "gait", "speed", "more"), WALKS)
def test_lifted_its_legs_stop_and_wait(name, gait, speed, more):
    """Requirement: noticed within 0.5 s. Measured 0.10 to 0.28 s; the legs are still in the stance after 0.4 to 1.1."""
    robot = Lifted(name, gait, speed, **more)
    assert 0 < robot.noticed_s - robot.touched_s <= NOTICED_S
    assert robot.moved_s - robot.touched_s < STILL_S
    before_m = robot.x_m()
    robot.go(3.0)
    assert robot.x_m() == pytest.approx(before_m, abs=0.02)  # put down, still told to walk: it settles
    assert bool(robot.driver.lifted) == bool(speed)
    robot.tell(0.0)
    robot.go(0.1)
    assert not robot.driver.lifted
    robot.driver.set_command(mode="walk", gait="trot", vx_m_s=0.1)
    robot.go(3.0)
    assert robot.x_m() > before_m + 0.2


@pytest.mark.slow
@pytest.mark.parametrize("honest", [False, True])
@pytest.mark.parametrize("name", robot_names())
def test_every_robot_notices_it(name, honest):
    robot = Lifted(name, honest=honest)
    assert 0 < robot.noticed_s - robot.touched_s <= NOTICED_S
