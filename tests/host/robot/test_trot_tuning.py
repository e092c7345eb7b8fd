"""What the trot may do: as much as the robot file wants, and never more than legs can."""

import pytest

from host.control.planner import Driver
from host.robot.file import load_robot
from host.robot.trot_tuning import able, fastest


def limited(name, vx_m_s):
    """Return a robot whose file wants no more than that ahead."""
    robot = load_robot(name)
    limits = robot.speed_limits.model_copy(update={"vx_m_s": vx_m_s})
    return robot.model_copy(update={"speed_limits": limits})


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_the_robot_file_limits_it_and_what_the_legs_can(name):
    robot = load_robot(name)
    limits = robot.speed_limits
    assert fastest(robot) == (limits.vx_m_s, limits.vy_m_s, limits.wz_rad_s)
    assert fastest(limited(name, 0.7))[0] == able(robot)[0]


@pytest.mark.parametrize(("name", "wanted_m_s", "most_m_s", "key"), [
    ("caramelo", 0.2, 0.2, "speed_limits.vx_m_s"),
    ("parallel", 0.7, 0.626, "0.4 sqrt(g h), the highest that was tried"),
])
@pytest.mark.parametrize("gait", ["trot", "crawl"])
def test_the_planner_is_limited_so_and_names_what_limits(gait, name, wanted_m_s, most_m_s, key):
    most, named = Driver(limited(name, wanted_m_s)).speed_limit(gait)
    assert most == pytest.approx(most_m_s, rel=0.01)
    assert named == key
