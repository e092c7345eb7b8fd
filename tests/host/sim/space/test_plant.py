"""The robot in space behind switched drives: limp it sinks, driven it holds, limited it gives."""

import pytest

from host.robot.file import load_robot
from host.robot.poses import rest_pose_rad, seated_pose_rad
from host.sim.space.plant import SpacePlant
from host.util.errors import UserError

ROBOTS = [load_robot(name).simulated(honest) for name in ("caramelo", "parallel") for honest in (False, True)]


def held(plant, pose_rad, seconds, limit=1.0):
    """Tell all drives to go to a pose and let time pass; return how far the body is above the ground's level."""
    plant.drives.on[:] = [True] * 12
    plant.drives.limit[:] = [limit] * 12
    plant.drives.goal_rad[:] = pose_rad
    for _ in range(round(seconds / 0.02)):
        plant.advance_to(plant.time_s + 0.02)
    return float(plant.world.position_m()[2])


@pytest.mark.parametrize("robot", ROBOTS)
def test_driven_it_stands_up_from_where_it_sits(robot):
    plant = SpacePlant(robot)
    sits_m = held(plant, seated_pose_rad(robot), 0.5)
    stands_m = held(plant, rest_pose_rad(robot), 1.0)
    higher_m = robot.stance.rest_height_m - robot.stance.sit_height_m
    assert stands_m - sits_m == pytest.approx(higher_m, rel=0.25), "but for its sag"
    assert max(map(abs, plant.drives.load)) <= 1.0


@pytest.mark.parametrize("robot", ROBOTS)
def test_off_it_gives_nothing_and_sinks(robot):
    plant = SpacePlant(robot)
    stands_m = held(plant, rest_pose_rad(robot), 1.0)
    plant.drives.on[:] = [False] * 12
    plant.advance_to(plant.time_s + 0.2)
    assert plant.drives.load == [0.0] * 12
    for _ in range(20):
        plant.advance_to(plant.time_s + 0.1)
    assert float(plant.world.position_m()[2]) < stands_m - 0.02


def test_no_drive_gives_more_than_its_limit():
    robot = load_robot("caramelo")
    plant = SpacePlant(robot)
    high_m = held(plant, rest_pose_rad(robot), 1.0, limit=0.05)
    assert max(map(abs, plant.drives.load)) == pytest.approx(0.05, rel=0.01), "in steps of the duty"
    assert high_m < held(plant, rest_pose_rad(robot), 1.0) - 0.02


def test_put_back_it_sits_where_it_began_and_time_goes_on():
    robot = load_robot("caramelo")
    plant = SpacePlant(robot)
    held(plant, rest_pose_rad(robot), 0.5)
    plant.put_back()
    assert plant.position_rad == pytest.approx(seated_pose_rad(robot), abs=0.001)
    assert plant.time_s == pytest.approx(0.5)
    assert plant.pose() == pytest.approx((0.0, 0.0, 0.0))
    with pytest.raises(UserError, match="can't be turned by hand"):
        plant.push(0, 0.1)
