"""From disarmed to walking and back; stops, faults and reasons; on the simulated robot, in simulated time."""

import re
from dataclasses import replace

import pytest

from host.control.supervisor import STATES
from host.control.telemetry import Extra, status
from host.teleop.terminal import screen_lines
from shared.gait.table import MOVER_CRAWL
from shared.planner import handover
from shared.record import pack

from .rig import AHEAD, KEYS, PAD, PAGE, RESET, REST, SCRIPT, SIT, STAND, STILL, STOP, Rig, Silence


@pytest.fixture
def rig():
    return Rig()


def test_up_walk_and_down_again(rig):
    rig.run(0.1)
    assert (rig.supervisor.state, rig.reason) == ("disarmed", "the joints are off: stand up first")
    assert not rig.holding
    rig.run(0.1, first=STAND)
    assert (rig.supervisor.state, rig.holding) == ("standing up", True)
    assert rig.bus.plant.drives.limit[0] == rig.robot.stand.torque_fraction
    rig.run(3.0, STILL)
    assert (rig.supervisor.state, rig.reason) == ("standing", "the sticks are at rest")
    assert rig.bus.plant.drives.limit[0] == 1.0
    rig.run(1.0, AHEAD)
    assert (rig.supervisor.state, rig.reason) == ("walking", "")
    rig.run(8.0, first=REST)
    assert (rig.supervisor.state, rig.holding) == ("disarmed", False)
    states = [change.state for change in rig.supervisor.changes]
    order = [state for at, state in enumerate(states) if at == 0 or states[at - 1] != state]
    assert order == ["disarmed", "standing up", "standing", "walking", "standing", "sitting", "disarmed"]


def test_crawling_and_sitting_have_their_names(rig):
    rig.stand()
    rig.run(0.5, AHEAD, first={"type": "gait", "gait": "crawl"})
    assert rig.supervisor.state == "crawling"
    rig.run(10.0, first=SIT)
    assert (rig.supervisor.state, rig.holding) == ("sitting", True)
    assert rig.reason == "seated: stand up first"
    assert {change.state for change in rig.supervisor.changes} <= set(STATES)


def test_a_silent_driver_stops_the_robot(rig):
    rig.stand()
    rig.run(1.0, AHEAD)
    rig.run(0.32)
    assert rig.supervisor.driver.command.mode == "stand"
    assert rig.reason.startswith("no command from script 1 for 0.")
    rig.run(4.0)
    assert rig.supervisor.state == "standing"
    assert rig.reason == "nobody drives: take the controls"


@pytest.mark.parametrize("who", [SCRIPT, PAGE, PAD, KEYS], ids=str)
def test_a_stop_lets_go_before_the_next_tick(rig, who):
    rig.stand()
    rig.run(0.5, AHEAD)
    rig.send(STOP, who)
    assert not rig.holding
    rig.run(1.0, AHEAD)
    assert (rig.supervisor.state, rig.holding) == ("disarmed", False)
    assert rig.reason == f"emergency stop by {who}: reset it, then stand up"
    rig.run(0.5, AHEAD, first=RESET)
    assert not rig.holding, "a reset alone moves nothing"
    rig.run(0.1, first=STAND)
    assert rig.supervisor.state == "standing up"


def test_a_tripped_joint_is_named_and_the_robot_sits_down(rig, monkeypatch):
    rig.stand()
    read = rig.bus.read
    monkeypatch.setattr(rig.bus, "read", lambda: replace(read(), error=("", "", "", "", "overload", *[""] * 7)))
    rig.run(0.1, AHEAD)
    assert rig.supervisor.state == "fault"
    assert rig.reason == "FL thigh: overload; then reset"
    rig.run(6.0, AHEAD)
    assert not rig.holding
    rig.send(RESET)
    assert rig.supervisor.state == "fault", "it is still there"
    monkeypatch.undo()
    rig.run(0.1)
    rig.run(0.5, STILL, first=RESET)
    assert (rig.supervisor.state, rig.holding) == ("disarmed", False)


def test_a_dead_bus_lets_go(rig, monkeypatch):
    rig.stand()
    read = rig.bus.read
    monkeypatch.setattr(rig.bus, "read", lambda: replace(read(), age_s=(1.0,) * 12))
    rig.run(0.1, AHEAD)
    assert not rig.holding
    assert "12 joints do not answer" in rig.reason


def test_a_fall_lets_go_in_the_tick_that_senses_it(rig, monkeypatch):
    """Nothing is asked again or waited for: from the reading to the packet it takes a part of a tick."""
    rig.stand()
    monkeypatch.setattr(rig.supervisor, "_read_attitude", lambda: (1.2, 0.0))
    assert rig.holding
    rig.loop.tick(Silence())
    assert not rig.holding
    fallen = "the robot has fallen over onto its right side: put it on its feet, because it can't turn"
    assert rig.reason.startswith(fallen)


QUICK = {**STILL, "vx_m_s": 0.3}


@pytest.mark.parametrize(("walked_s", "stretched"), [(0.9, True), (1.5, False), (1.9, True), (2.8, True)])
def test_after_a_stop_in_mid_walk_it_gets_up_again(rig, walked_s, stretched):
    """Limp, it may lie on its belly, the legs to the rear; rising from there would tip it over its nose."""
    rig.stand()
    rig.run(walked_s, QUICK)
    rig.run(2.0, first=STOP)
    assert bool(rig.supervisor.stretched()) == stretched
    rig.run(0.1, first=RESET)
    assert rig.put_back == stretched
    assert rig.reason == "the joints are off: stand up first"
    rig.run(4.0, STILL, first=STAND)
    assert (rig.supervisor.state, rig.reason) == ("standing", "the sticks are at rest")


def test_it_does_not_rise_on_stretched_legs_and_says_so(rig, monkeypatch):
    rig.stand()
    rig.run(0.9, QUICK)
    rig.run(2.0, first=STOP)
    monkeypatch.setattr(rig.supervisor, "_put_back", lambda: None)  # a real robot
    rig.run(0.1, first=RESET)
    told = (
        r"FR lies stretched out, its foot \d+ mm behind the hip, allowed 120: put the robot on its feet, seated, then"
    )
    assert re.match(told, rig.reason)
    rig.run(0.5, first=STAND)
    assert re.match(told, rig.reason)
    assert not rig.holding
    rig.bus.plant.put_back()
    rig.run(0.5)
    assert (rig.reason, rig.holding) == ("the joints are off: stand up first", False), "it waits to be told again"
    rig.run(4.0, STILL, first=STAND)
    assert rig.supervisor.state == "standing"


def test_unknown_joints_are_not_armed(rig, monkeypatch):
    read = rig.bus.read
    monkeypatch.setattr(rig.bus, "read", lambda: replace(read(), age_s=(float("inf"),) + (0.0,) * 11))
    rig.run(0.2, first=STAND)
    assert (rig.holding, rig.reason) == (False, "the joints' positions are not known yet")


def test_the_pose_is_limited_and_kept_by_the_planner(rig):
    rig.stand()
    rig.run(2.0, {**STILL, "pose": [0, 2.0, 0, 0, 0, 0]})
    top = rig.robot.body_limits.y_m
    assert rig.supervisor.driver.planner.pose[1] == rig.supervisor.driver.scale.lu(top)


def test_turning_speeds_reach_the_planner_where_there_are_any(rig, monkeypatch):
    rig.run(0.1)
    sensed = rig.supervisor.driver._sensed
    assert sensed.valid.turned == 0
    monkeypatch.setattr(rig.supervisor, "_read_rates", lambda: (0.1, 0.0, -0.2))
    rig.run(0.1)
    scale = rig.supervisor.driver.scale
    assert sensed.valid.turned == 1
    assert pack(sensed.turned) == [scale.yaw18_per_tick(rate) for rate in (0.1, 0.0, -0.2)]


def test_a_crawl_that_the_planner_chose_is_told_with_its_reason(rig):
    rig.stand()
    rig.run(1.0, AHEAD)
    assert (rig.supervisor.state, rig.supervisor.remark) == ("walking", "")
    planned = rig.supervisor.driver.planner.status
    planned.mover, planned.reason = MOVER_CRAWL, handover.REASON_HELD
    rig.supervisor._watch_gait()
    assert rig.supervisor.state == "crawling"
    assert rig.supervisor.remark.startswith("held up: ")
    told = status(rig.loop, Extra())
    assert (told["walks"], told["remark"]) == ("crawl", rig.supervisor.remark)
    assert any(line.startswith("held up: ") for line in screen_lines(told))
    lost = status(rig.loop, Extra(attitude_note="the IMU is stuck")) | {"attitude_rad": None}
    assert any("attitude unknown: the IMU is stuck" in line for line in screen_lines(lost))


HELD, ODD = "pose out of reach: held at the nearest", "a reading of joints or tilt was odd and was left out"


def shown(rig):
    """Return the remark after seeing that the screen shows it too."""
    told = status(rig.loop, Extra())
    assert told["remark"] in screen_lines(told)
    return told["remark"]


def test_a_pose_out_of_reach_is_told_for_as_long_as_it_is_held(rig):
    limits = rig.robot.body_limits
    rig.stand()
    rig.run(3.0, {**STILL, "pose": [0.0, 0.0, limits.z_m, 0.0, limits.angles_rad[1], 0.0]})
    assert (rig.supervisor.state, shown(rig)) == ("standing", HELD)
    rig.run(3.0, STILL)
    assert shown(rig) == ""


def test_an_odd_reading_is_told_for_a_while(rig, monkeypatch):
    rig.stand()
    real = rig.bus.read

    def odd():
        measured = real()
        places = [angle + (joint == 4) for joint, angle in enumerate(measured.position_rad)]
        return replace(measured, position_rad=tuple(places))

    assert shown(rig) == ""
    monkeypatch.setattr(rig.bus, "read", odd)
    rig.run(0.02, STILL)
    monkeypatch.setattr(rig.bus, "read", real)
    rig.run(1.0, STILL)
    assert shown(rig) == ODD
    rig.run(3.0, STILL)
    assert shown(rig) == ""


def test_the_robot_with_coupled_calves_stands_up_with_limited_torque_and_walks():
    rig = Rig("parallel")
    rig.run(0.2)
    rig.send(STAND)
    share, most = rig.robot.stand.torque_fraction, 0.0
    for _ in range(100):
        rig.run(0.1, STILL)
        if rig.supervisor.state == "standing":
            break
        most = max(most, *map(abs, rig.bus.plant.drives.load))
    assert rig.supervisor.state == "standing"
    assert 0 < most <= share + 0.001
    torso = rig.bus.plant.world.parts.bodies[0]
    before_m = torso.position.x
    rig.run(8.0, AHEAD)
    assert rig.supervisor.state == "walking"
    assert torso.position.x - before_m > 0.25
    assert abs(rig.supervisor.attitude[1]) < 0.1
