"""What a robot can do before it walks, against lever arms worked out by hand and against what was measured."""

from math import cos, radians, sin, sqrt

import pytest

from host.robot.ability import ability, cannot
from host.robot.file import load_robot, robot_names
from host.robot.model import KNEE_CONFIGURATIONS
from host.robot.statics import push_on_two_N, pushes_on_four_N, sag_m, torques_Nm
from host.robot.swings import asked_speeds, most, poses_rad, within_limits
from host.robot.trot_tuning import (
    HIGH_LIFT,
    HIGHEST_ASKS,
    HIGHEST_LIFT,
    SWING_ASKS,
    able,
    highest_lift_m,
    top_lift_m,
    trot_figures,
)
from tests import ROOT
from tests.shared.robots import variant, with_trunk_at

G_M_S2 = 9.81


def without_legs_weight(name):
    """Return a robot whose legs weigh a gram: all the torque is the ground's push on a lever arm."""
    robot = load_robot(name)
    links = {
        joint: getattr(robot.links, joint).model_copy(update={"mass_kg": 0.001}) for joint in ("hip", "thigh", "calf")
    }
    return robot.model_copy(update={"links": robot.links.model_copy(update=links)})


def test_torques_are_lever_arms_where_legs_weigh_nothing():
    """Caramelo: hip axis 48 mm beside the foot, thigh above it, knee 0.120 sin 45 deg = 84.9 mm behind it."""
    hip, thigh, calf = torques_Nm(without_legs_weight("caramelo"), 0, 10.0)
    assert abs(hip) == pytest.approx(0.48, rel=0.01)
    assert abs(thigh) == pytest.approx(0.0, abs=0.002)
    assert abs(calf) == pytest.approx(10 * 0.120 * sin(radians(45)), rel=0.01)


def test_a_calf_driven_from_the_body_leaves_the_thigh_what_the_knee_carries():
    """Parallel at 0.25 m: both links 38.6 deg from upright, the knee 0.16 sin 38.6 deg = 99.9 mm behind the foot."""
    _, thigh, calf = torques_Nm(without_legs_weight("parallel"), 0, 10.0)
    assert abs(calf) == pytest.approx(0.999, rel=0.01)
    assert thigh == pytest.approx(-calf, rel=0.01)


def test_the_legs_own_weight_counts():
    """A calf of 35 g whose centre is ahead of the knee takes g (0.005 cos + 0.060 sin) 45 deg off the push on it."""
    robot, light = load_robot("caramelo"), without_legs_weight("caramelo")
    less = torques_Nm(light, 0, 10.0)[2] - torques_Nm(robot, 0, 10.0)[2]
    assert less == pytest.approx(0.034 * G_M_S2 * (0.005 * cos(radians(45)) + 0.060 * sin(radians(45))), rel=0.02)


@pytest.mark.parametrize("name", robot_names())
def test_the_ground_carries_the_robot(name):
    robot = load_robot(name)
    assert sum(pushes_on_four_N(robot)) == pytest.approx(robot.mass_kg * G_M_S2)
    assert 2 * push_on_two_N(robot) == pytest.approx(robot.mass_kg * G_M_S2)
    assert sag_m(robot) > 0


def with_drives(name, **values):
    """Return a robot with other values of its actuator."""
    robot = load_robot(name)
    return robot.model_copy(update={"actuator": robot.actuator.model_copy(update=values)})


def test_softer_drives_sag_more():
    robot = load_robot("unitree-a1")
    soft = with_drives("unitree-a1", stiffness_Nm_rad=robot.actuator.stiffness_Nm_rad / 2)
    assert sag_m(soft) == pytest.approx(2 * sag_m(robot), rel=0.25)


@pytest.mark.parametrize(("name", "walked_m_s"), [("caramelo", 0.30), ("parallel", 0.60)])
def test_legs_can_what_was_walked(name, walked_m_s):
    """tests/host/sim/space/test_trot.py walks so fast."""
    assert able(load_robot(name))[0] >= walked_m_s


def test_what_limits_is_named_and_is_at_its_limit():
    """Caramelo's thighs and, lifted high, its calves: a little more asks SWING_ASKS of their no-load speed."""
    robot = load_robot("caramelo")
    figures = trot_figures(robot)
    speed_m_s, why = able(robot)
    assert why == "the thigh's speed"
    poses = poses_rad(robot, 1, figures.swing(speed_m_s, 0.08 * figures.leg_m))
    asked = asked_speeds(robot, poses, figures.swing_s)
    assert asked.index(max(asked)) == 1
    assert max(asked) == pytest.approx(SWING_ASKS, rel=0.01)
    assert highest_lift_m(robot)[1] == "the calf's speed"


def test_the_highest_swing_is_as_high_as_slow_drives_go_in_time():
    """And no lower than the high ones, which edges need."""
    robot = load_robot("spotmicro")
    figures, lift_m = trot_figures(robot), top_lift_m(robot)
    poses = poses_rad(robot, 1, figures.swing(0.0, lift_m))
    assert max(asked_speeds(robot, poses, figures.swing_s)) == pytest.approx(HIGHEST_ASKS, rel=0.01)
    a1, slow = load_robot("unitree-a1"), with_drives("unitree-a1", no_load_rad_s=2.0)
    assert top_lift_m(a1) == pytest.approx(HIGHEST_LIFT * trot_figures(a1).leg_m)
    assert top_lift_m(slow) == pytest.approx(HIGH_LIFT * trot_figures(slow).leg_m)


@pytest.mark.parametrize("name", ["caramelo", "spotmicro"])
def test_legs_of_two_shapes_are_as_fast_as_the_slower_ones(name):
    """Knee legs need faster joints than elbow legs do, ahead; elbow-knee robots are kept from making them lag."""
    fastest = {each: able(variant(name, knee_configuration=each))[0] for each in KNEE_CONFIGURATIONS}
    assert fastest["knee-elbow"] == fastest["full-knee"] < 0.9 * fastest["full-elbow"]
    assert fastest["elbow-knee"] < 0.7 * fastest["knee-elbow"]


def test_speeds_asked_are_those_of_a_hand_calculation():
    """A foot below its hip that goes 1 mm ahead in 1 ms turns leg and knee by 1 mm over 0.17 m: 5.9 rad/s."""
    robot = load_robot("caramelo")
    way = [(-0.0005, 0.0), (0.0005, 0.0)]
    _, thigh, calf = asked_speeds(robot, poses_rad(robot, 1, way), 0.001)
    assert thigh * robot.actuator.fastest_rad_s == pytest.approx(1 / 0.170, rel=0.01)
    assert calf == pytest.approx(0.0, abs=0.01)


def test_a_foot_beyond_its_reach_or_limits_is_told():
    robot = load_robot("caramelo")
    assert within_limits(robot, 1, poses_rad(robot, 1, [(0.0, 0.0), (0.0, 0.06)]))
    assert not within_limits(robot, 1, poses_rad(robot, 1, [(0.0, 0.0), (0.0, 0.07)]))
    assert poses_rad(robot, 1, [(0.0, 0.0), (0.3, 0.0)]) is None


def test_most_is_the_edge():
    assert most(1.0, lambda _: True) == 1.0
    assert most(1.0, lambda x: x <= 0.3) == pytest.approx(0.3, abs=1e-4)
    assert most(1.0, lambda _: False) == 0.0


@pytest.mark.parametrize("name", robot_names())
def test_every_robot_can_carry_itself(name):
    robot = load_robot(name)
    known = ability(robot)
    assert list(cannot(robot, known)) == []
    assert known.flat_m_s == pytest.approx(min(known.able_m_s, 0.25 * sqrt(G_M_S2 * robot.stance.rest_height_m)))
    assert 0 < known.step_m <= 0.8 * known.lift_m


def test_legs_that_lift_a_foot_less_step_up_less():
    known = ability(with_drives("unitree-a1", no_load_rad_s=4.0))
    assert known.lift_why == "the calf's speed"
    assert known.step_m == pytest.approx(0.78 * known.lift_m)


def test_legs_too_slow_for_a_step_on_the_spot_are_told():
    robot = with_drives("unitree-a1", no_load_rad_s=1.0)
    (sentence,) = cannot(robot, ability(robot))
    assert "too short for" in sentence


def test_joints_that_give_way_until_the_legs_fold_are_told():
    robot = with_drives("solo12", stiffness_Nm_rad=0.5)
    assert sag_m(robot) is None
    assert "fold up: raise actuator.stiffness_Nm_rad" in next(cannot(robot, ability(robot)))


@pytest.mark.parametrize(
    ("com_m", "sentences"), [((0.0, 0.18, 0.0), 0), ((-0.18, 0.0, 0.0), 1), ((0.0, 0.21, 0.0), 1), ((0.2, 0.3, 0.0), 2)]
)
def test_a_centre_of_mass_beyond_the_feet_is_told(com_m, sentences):
    """In space the first walks half a metre, and the others fall as soon as they stand."""
    robot = with_trunk_at("caramelo", com_m)
    told = list(cannot(robot, ability(robot)))
    assert len(told) == sentences
    assert all("tips over" in each and each.endswith("change links.trunk.com_m") for each in told)


def table(page, wanted):
    """Return the cells of a page's table, by robot, whose head has a column that starts so."""
    lines = (ROOT / "docs" / page).read_text().splitlines()
    start = next(at for at, line in enumerate(lines) if line.startswith("| robot |") and wanted in line)
    rows = []
    for line in lines[start + 2 :]:
        if not line.startswith("|"):
            break
        rows.append([cell.strip(" `") for cell in line.strip("|").split("|")])
    return {row[0]: row[1:] for row in rows}


def test_the_page_of_robots_says_what_the_check_says():
    shown = table("robots.md", "sags on four legs")
    assert sorted(shown) == robot_names()
    for name, cells in shown.items():
        robot = load_robot(name)
        known, leg_m = ability(robot), robot.geometry.thigh_m + robot.geometry.calf_m
        assert cells == [
            f"{robot.mass_kg:.1f}", f"{1000 * leg_m:.0f}", f"{1000 * known.sag_m:.1f}",
            f"{100 * max(known.on_two):.0f}", f"{known.able_m_s:.2f}", f"{known.flat_m_s:.2f}",
            f"{1000 * known.step_m:.0f}",
        ]  # fmt: skip


def test_the_page_of_robots_walks_at_what_is_advised():
    for name, cells in table("robots.md", "walked, m/s").items():
        assert float(cells[0]) == load_robot(name).gait.advised_m_s["trot"]
        assert 0.9 < float(cells[1]) / float(cells[0]) <= 1  # its start is slower
