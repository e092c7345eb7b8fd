"""A robot in space that somebody lifts, as its driver is told of it: on the page, in the status, in a program."""

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")

from host.control.hardware import Hardware
from host.control.planner import LET_GO, PUT_DOWN
from host.control.telemetry import Extra, status
from host.imu.attitude import Attitude
from host.library.errors import NotAchieved
from host.library.places import Place, SimulatedClock
from host.library.robot import Robot
from host.robot.file import load_robot
from host.sim.bus import SimulatedBus
from host.sim.imu import SimulatedImu
from host.sim.space.plant import SpacePlant
from tests.host.sim.space.hand import Hand

from .rig import AHEAD, REST, STILL, Rig

LIFT_M = 0.1


def told(rig):
    """Return state and reason as the page, the terminal and scripts get them."""
    news = status(rig.loop, Extra())
    return news["state"], news["reason"]


@pytest.fixture
def held():
    """Return a robot that was lifted in mid walk, and the hand that holds it."""
    plant = SpacePlant(load_robot("caramelo"))
    rig = Rig(plant=plant)
    rig.stand()
    rig.run(3.0, AHEAD)
    assert told(rig) == ("walking", "")
    hand = Hand(plant.world)
    rig.each = lambda: hand.hold(LIFT_M)
    rig.run(1.0, AHEAD)
    assert told(rig) == ("lifted", PUT_DOWN)
    return rig, hand


@pytest.mark.parametrize(("gait", "walks"), [("trot", "walking"), ("crawl", "crawling")])
def test_a_body_raised_by_its_pose_is_not_lifted(gait, walks):
    """Friction holds legs that have just been stretched. Where it walks their load shows, and a lift is noticed."""
    plant = SpacePlant(load_robot("caramelo"))
    rig = Rig(plant=plant)
    rig.stand()
    rig.send({"type": "gait", "gait": gait})
    raised = {"pose": [0.0, 0.0, 0.03, 0.0, 0.0, 0.0]}
    rig.run(3.0, {**STILL, **raised})
    assert rig.supervisor.state == "standing"
    assert rig.supervisor.driver.planner.status.feet_load_q12 < 1024, "this ground is to be one where friction holds"
    rig.run(2.0, {**AHEAD, **raised})
    assert rig.supervisor.state == walks
    hand = Hand(plant.world)
    rig.each = lambda: hand.hold(LIFT_M)
    rig.run(0.5, {**AHEAD, **raised})
    assert told(rig) == ("lifted", PUT_DOWN)


def test_the_driver_is_told_and_has_to_let_go_of_the_sticks(held):
    rig, hand = held
    rig.run(1.0, STILL)
    assert told(rig) == ("lifted", PUT_DOWN), "the sticks alone are not enough"
    place = rig.supervisor.driver.odometry
    rig.each = lambda: hand.hold(0.0)
    rig.run(0.6, AHEAD)
    hand.let_go()
    rig.each = lambda: None
    rig.run(2.5, AHEAD)
    assert told(rig) == ("lifted", LET_GO)
    rig.run(0.2, STILL)
    assert told(rig) == ("standing", "the sticks are at rest")
    assert rig.supervisor.driver.odometry.x_m == pytest.approx(place.x_m, abs=0.005)
    rig.run(1.0, AHEAD)
    assert told(rig) == ("walking", "")


def test_in_the_hand_it_sits_down_and_lets_go_as_told(held):
    rig, _ = held
    rig.run(4.0, first=REST)
    assert (rig.supervisor.state, rig.holding) == ("disarmed", False)


def test_a_program_that_walks_is_told():
    """The walk raises, and the next one waits until the robot stands on the ground."""
    robot = load_robot("caramelo")
    clock = SimulatedClock()
    plant = SpacePlant(robot)
    hand = None

    def advance(seconds):
        if hand is not None:
            hand.hold(LIFT_M)
        clock.advance(seconds)

    parts = Hardware(SimulatedBus(robot, clock, plant), Attitude(robot, SimulatedImu(robot, plant.inertial)),
                     plant.put_back)
    with Robot(Place(parts, clock, advance, plant.pose)) as caramelo:
        caramelo.stand()
        caramelo.walk(0.05, seconds=2.5)
        hand = Hand(plant.world)
        with pytest.raises(NotAchieved, match="lifted off the ground"):
            caramelo.walk(0.05, seconds=2.0)
        assert caramelo.sensed.state == "lifted"
        hand.let_go()
        hand = None
        caramelo.walk(0.05, seconds=0.5)
        assert caramelo.sensed.state == "standing"
