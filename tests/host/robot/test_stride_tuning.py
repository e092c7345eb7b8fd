"""What the fast trot may do: as much as the robot file advises, else its speed limits, and never more than legs can."""

import pytest

from host.control.planner import Driver
from host.robot.stride_tuning import GAIT, able, fastest

from .advice import advising


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_the_robot_file_limits_it(name):
    robot = advising(name, {})
    limits, most = robot.speed_limits, fastest(advising(name, {GAIT: 3.0}))
    assert fastest(robot) == (limits.vx_m_s, limits.vy_m_s, limits.wz_rad_s)
    assert most[0] == able(robot)[0]
    assert fastest(advising(name, {GAIT: most[0] / 2})) == pytest.approx([value / 2 for value in most])


@pytest.mark.parametrize(
    ("name", "advised_m_s", "most_m_s", "key"),
    [("caramelo", {GAIT: 0.2}, 0.2, f"gait.advised_m_s.{GAIT}"), ("parallel", {}, 0.15, "speed_limits.vx_m_s")],
)
def test_the_planner_is_limited_so_and_names_the_key(name, advised_m_s, most_m_s, key):
    driver = Driver(advising(name, advised_m_s))
    most, named = driver.speed_limit(GAIT)
    assert most == pytest.approx(most_m_s, rel=0.01)
    assert named == key
