"""What the fast trot may do: as much as the robot file advises, else its speed limits, and never more than legs can."""

import pytest

from host.control.planner import Driver
from host.robot.stride_tuning import GAIT, fastest, stride_figures

from .advice import advising


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_the_robot_file_limits_it(name):
    robot = advising(name, {})
    able, limits = stride_figures(robot).fastest(robot.actuator.fastest_rad_s), robot.speed_limits
    assert fastest(robot) == (limits.vx_m_s, limits.vy_m_s, limits.wz_rad_s)
    assert fastest(advising(name, {GAIT: able[0] / 2})) == pytest.approx([value / 2 for value in able])
    assert fastest(advising(name, {GAIT: 3.0})) == pytest.approx(able)


@pytest.mark.parametrize(
    ("name", "advised_m_s", "most_m_s", "key"),
    [("caramelo", {GAIT: 0.2}, 0.2, f"gait.advised_m_s.{GAIT}"), ("parallel", {}, 0.15, "speed_limits.vx_m_s")],
)
def test_the_planner_is_limited_so_and_names_the_key(name, advised_m_s, most_m_s, key):
    driver = Driver(advising(name, advised_m_s))
    most, named = driver.speed_limit(GAIT)
    assert most == pytest.approx(most_m_s, rel=0.01)
    assert named == key
