"""The world in three dimensions is to be trusted: it sags as the servo law says, stays put, senses the truth."""

import math

import numpy as np
import pytest

from host.imu.attitude import Attitude
from host.robot.file import load_robot
from host.sim.export.ground import Ground
from host.sim.export.mjcf import ModelOptions
from host.sim.grounds import GroundSpec, make_ground
from host.sim.imu import SimulatedImu
from host.sim.space.walk import FAST
from host.sim.space.world import World

ROBOT = load_robot("caramelo")
FLAT = Ground("flat")


@pytest.mark.parametrize("rate_hz", [20, 50, 60, 125, 200, 300, 500])
def test_a_second_has_as_many_ticks_as_its_rate(rate_hz):
    """At 200 Hz a tick is 2.5 of the usual steps: rounded to 2, a second of the robot took 0.8 s of the world."""
    world = World(ROBOT, ModelOptions(FLAT, dt_s=FAST[0]), rate_hz)
    for _ in range(rate_hz):
        world.advance()
    assert world.time_s == pytest.approx(1.0)
    assert world.data.time == pytest.approx(1.0)
    assert world.options.dt_s <= FAST[0]


def test_a_simple_drive_sags_as_the_servo_law_says_and_then_stays():
    """4.31 mm by the law without dry friction, which holds back 5 %; 2 s of standing move it by less than 0.01 mm."""
    world = World(ROBOT.simulated(honest=False), ModelOptions(FLAT), 50)
    for _ in range(150):
        world.advance()
    still = world.position_m()
    assert 0.182 - still[2] == pytest.approx(0.00431, rel=0.08)
    for _ in range(100):
        world.advance()
    assert np.linalg.norm(world.position_m() - still) < 1e-5
    loads, trunk, deepest = world.foot_loads_N()
    assert sum(loads) == pytest.approx(9.81 * ROBOT.mass_kg, rel=1e-3)
    assert not trunk
    assert deepest < 2e-5


def test_loose_stones_are_not_taken_for_the_body():
    world = World(ROBOT, ModelOptions(make_ground(GroundSpec("gravel"))), 50)
    assert world.position_m() == pytest.approx((0.0, 0.0, 0.182), abs=0.02)
    assert world.attitude_rad() == pytest.approx((0.0, 0.0, 0.0), abs=0.01)


def test_goals_act_late():
    world = World(ROBOT, ModelOptions(FLAT, on_a_stand=True), 50, bus_delay_s=0.06)
    goal = world.true_joints_rad()
    goal[1] += 0.2
    world.send(goal)
    turned = []
    for _ in range(5):
        world.advance()
        turned.append(world.true_joints_rad()[1])
    assert turned[2] - turned[1] < 0.01
    assert turned[3] - turned[2] > 0.05


def test_the_attitude_filter_finds_the_tilt_from_raw_counts():
    """Body tilted by the legs; the core's filter on int16 counts with bias and noise follows the truth within 1 deg."""
    world = World(ROBOT, ModelOptions(FLAT), 50)
    attitude = Attitude(ROBOT, SimulatedImu(ROBOT, world.motion, seed=3))
    rest, worst, largest, worst_rate = world.true_joints_rad(), 0.0, 0.0, 0.0
    while attitude.update() is None:
        assert world.time_s < 5
        world.advance()
    for tick in range(250):
        goal = rest.copy()
        goal[2::6] += 0.12 * math.sin(tick / 25)
        goal[5::6] -= 0.12 * math.sin(tick / 25)
        world.send(goal)
        before = world.attitude_rad()[0]
        world.advance()
        found, (roll, pitch, _) = attitude.update(), world.attitude_rad()
        worst = max(worst, abs(found[0] - roll), abs(found[1] - pitch))
        worst_rate = max(worst_rate, abs(attitude.rates_rad_s[0] - (roll - before) * 50))
        largest = max(largest, abs(roll))
    assert largest > math.radians(3)
    assert worst < math.radians(1.0)
    assert worst_rate < math.radians(0.5)
