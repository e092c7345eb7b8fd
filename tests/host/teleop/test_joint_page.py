"""The joints' page on simulated joints: what it reads, writes and refuses; arming, steps, stops, a page that goes."""

import math

import pytest

from host.bus.can.joints import CanJoints, new_session
from host.control.arbiter import Client
from host.control.messages import JOINT_KEYS, BadMessage, check
from host.protocol.parameters import load
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from host.sim.joints.sim_robot import SimRobot, sim_port
from host.teleop.joint_page import JointPage, about
from host.teleop.joint_step import Step

PAGE, OTHER = Client("web", 1), Client("web", 2)
ROBOT = load_robot("parallel")


@pytest.fixture
def page():
    """A page over twelve simulated joints, its clock theirs: it waits for nothing."""
    sim = SimRobot(ROBOT)
    bus = CanJoints(ROBOT, sim_port(sim), new_session(), seated_pose_rad(ROBOT))
    bus.listen()
    made = JointPage(bus, clock=lambda: math.inf)
    made.sim, made.bus = sim, bus
    yield made
    made.close()
    sim.close()


def say(page, client=PAGE, **message):
    """Say what a page may say; return what is told then."""
    assert page._receive(client, check(message, JOINT_KEYS))
    return page._told


def ticks_until(page, found):
    for _ in range(4000):
        page.tick()
        if found():
            return
    raise AssertionError(f"not within 4000 cycles; told: {page._told}")


def test_all_parameters_of_the_chosen_joint_are_read_in_their_units(page):
    page.tick()
    say(page, type="joint", node=5)
    ticks_until(page, lambda: len(page._values) == len(load()))
    assert page._node == 5
    assert page._values["node_id"] == 5
    assert page._values["gear_q8"] == 22.0
    rows = {row[0]: row for row in about(ROBOT, True)["parameters"]}
    assert rows["gear_q8"][1:3] == ["Gear and encoders", "rotor turn/joint turn"]
    assert all(row[1] for row in rows.values())
    assert rows.keys() == page._values.keys()


def test_a_parameter_is_written_within_its_limits_only(page):
    told = say(page, type="parameter", node=1, name="position_p", value=12.0)
    assert told == "FR hip (node 1): position_p is 12 rate/rc until it loses power; Keep saves it"
    assert page._values["position_p"] == 12.0
    told = say(page, type="parameter", node=1, name="position_p", value=900.0)
    assert "position_p: 900: allowed 0.015625 to 63.98" in told
    assert "can only be read" in say(page, type="parameter", node=1, name="uptime", value=1.0)
    assert "no such parameter" in say(page, type="parameter", node=1, name="nonsense", value=1.0)
    assert "its parameters are saved" in say(page, type="keep", node=1)


def test_a_step_tells_its_rise_and_comes_back(page):
    assert say(page, type="step", node=2, deg=5.0, seconds=0.3) == "a step: arm the joints first"
    assert say(page, type="arm", on=True) == "all joints hold their present angles"
    before = page.bus.cycle.goals_brad
    say(page, type="step", node=2, deg=5.0, seconds=0.3)
    assert "a step is running" in say(page, OTHER, type="step", node=3, deg=1.0, seconds=0.3)
    ticks_until(page, lambda: page._step is None)
    assert page._told.startswith("FR thigh (node 2): a step of 5 deg: 10 to 90 % in ")
    assert page.bus.cycle.goals_brad == pytest.approx(before, abs=0.01)
    assert "it is armed" in say(page, type="parameter", node=2, name="rate_max", value=1.0)
    assert say(page, type="arm", on=False) == "the joints are off"
    assert page.sim.torque_free


def test_a_step_beyond_a_joints_limits_is_refused(page):
    say(page, type="arm", on=True)
    goals = [math.radians(goal * 360 / 65536) for goal in page.bus.cycle.goals_brad]
    low, high = ROBOT.joint_limits_rad(0)[0]
    page.bus.cycle.set_goals([high - math.radians(3.0), *goals[1:]])
    page.tick()
    told = say(page, type="step", node=1, deg=5.0, seconds=0.3)
    assert told == f"FR hip (node 1) would go to {math.degrees(high) + 2:.1f} deg: allowed " \
                   f"{math.degrees(low):.1f} .. {math.degrees(high):.1f} deg"
    assert page._step is None


@pytest.mark.parametrize("during", ["armed", "step", "disarmed"])
def test_a_stop_takes_the_torque_in_every_state(page, during):
    if during != "disarmed":
        say(page, type="arm", on=True)
    if during == "step":
        say(page, type="step", node=2, deg=5.0, seconds=1.0)
        page.tick()
    assert say(page, OTHER, type="stop") == "emergency stop: all joints are off"
    ticks_until(page, lambda: page.sim.torque_free and not page.bus.cycle.letting_go)
    assert not page._status()["armed"]
    assert not page._status()["stepping"]


def test_the_torque_goes_with_the_page_that_armed_and_with_no_other(page):
    say(page, type="arm", on=True)
    page._drop(OTHER)
    page.tick()
    assert page._status()["armed"]
    page._drop(PAGE)
    assert page.sim.torque_free
    assert page._told == "the page that armed the joints is gone: they are off"


def test_what_the_guard_sees_ends_a_step_and_is_told(page):
    say(page, type="arm", on=True)
    say(page, type="step", node=2, deg=5.0, seconds=1.0)
    page.bus.link.emergency_stop()  # as another program on the bus would pull it
    ticks_until(page, lambda: page._armer is None)
    assert page._step is None
    assert "FR thigh (node 2): emergency stop: an emergency stop was commanded" in page._told


def test_the_signals_are_the_joints(page):
    page.tick()
    say(page, type="arm", on=True)
    for _ in range(5):
        page.tick()
    time_s, goal, angle, speed, current, winding, supply = page._status()["samples"][-1]
    assert time_s == pytest.approx(page.bus.now(), abs=0.01)
    assert goal == pytest.approx(angle, abs=3.0)
    assert None not in (speed, current)
    assert supply == pytest.approx(24.0, rel=0.2)
    assert winding is None or winding > 0
    assert page._status()["joints"][0] == "operation enabled"


@pytest.mark.parametrize("message", [
    {"type": "joint", "node": 0}, {"type": "joint", "node": True}, {"type": "drive"}, {"type": "arm", "on": 1},
    {"type": "step", "node": 1, "deg": 21.0, "seconds": 1.0}, {"type": "step", "node": 1, "deg": 1.0, "seconds": 6.0},
    {"type": "parameter", "node": 1, "name": "x" * 31, "value": 1.0}, {"type": "parameter", "node": 1, "name": "x"},
])  # fmt: skip
def test_what_is_no_message_is_refused(message):
    with pytest.raises(BadMessage):
        check(message, JOINT_KEYS)


def told_of(share, seconds=1.0):
    """Return a finished step of 10 deg whose answer is ``share`` of time."""
    step = Step(2, 66.0, 10.0, 5.0, seconds)
    turned = [step.take(5.0 + ms / 1000, 67.0 + 10 * share(ms / 1000)) for ms in range(0, round(2000 * seconds) + 1, 5)]
    assert turned.count(True) == 2
    assert step.over
    return step.told()


def test_the_figures_of_a_step_are_those_of_its_answer():
    tau_s = 0.1 / math.log(9)  # rises from 10 to 90 % in 100 ms
    risen = "a step of 10 deg: 10 to 90 % in 100 ms, 0 % over, 0.00 deg left"
    assert told_of(lambda t: 1 - math.exp(-t / tau_s)) == risen
    assert told_of(lambda t: 1.25 if 0.1 < t < 0.2 else 0.95 if t > 0.2 else 0.0).endswith("25 % over, 0.50 deg left")
    assert told_of(lambda t: 0.5) == "a step of 10 deg: the joint did not get there within 1 s"
