"""The crawl commanded in the middle of a trot, at an edge: the robot stops first."""

import math

import pytest

from host.robot.file import load_robot
from host.sim.grounds import FLAT, GroundSpec
from host.sim.space.walk import SpaceWalker
from host.sim.walk import WalkSpec
from shared.crawl.state import STILL
from shared.gait.table import MOVER_CRAWL

ROBOT = load_robot("caramelo")
RATE_HZ = 50
FALLEN_RAD = math.radians(45)
DROP_M = (0.35, 0.41, 0.4325, 0.44, 0.45, 0.4525, 0.4775, 0.485)  # feet slip off the rim, or hang over it
BEFORE_AND_ASTRIDE = [("up", 0.03, 0.26), ("up", 0.05, 0.26)] + [("down", 0.05, at_m) for at_m in DROP_M]


def crawl_from(ground, at_m, seconds=30.0, gait="trot"):
    """Command the crawl ``at_m`` into a walk at 0.05 m/s; return if it fell, and how long it waited, s."""
    walker = SpaceWalker(WalkSpec(ROBOT, gait, ground=ground))
    walker.stand_up()
    driver, world = walker.driver, walker.world
    start_m, commanded, began = world.position_m()[0], None, None
    driver.set_command(mode="walk", gait=gait, vx_m_s=0.05)
    for tick in range(round(seconds * RATE_HZ)):
        walker.tick()
        assert not driver.lifted
        if commanded is None and world.position_m()[0] - start_m >= at_m:
            commanded = tick
            driver.set_command(mode="walk", gait="crawl", vx_m_s=0.05)
        if began is None and driver.planner.status.mover == MOVER_CRAWL and driver.planner.crawl.stage.stage != STILL:
            began = tick
        if max(map(abs, world.attitude_rad()[:2])) > FALLEN_RAD:
            return True, None
    return False, None if began is None else (began - commanded) / RATE_HZ


@pytest.mark.parametrize(("kind", "height_m", "at_m"), BEFORE_AND_ASTRIDE)
def test_commanded_at_an_edge_it_stops_and_then_crawls(kind, height_m, at_m):
    """Of 65 places from 0.33 to 0.49 m before and astride of the drop it falls at none."""
    fell, waited_s = crawl_from(GroundSpec(f"step-{kind}", height_m, start_m=0.4), at_m)
    assert not fell
    assert waited_s is not None


@pytest.mark.parametrize("gait", ["trot", "paper-trot"])
def test_on_a_floor_it_begins_once_it_stands(gait):
    fell, waited_s = crawl_from(FLAT, 0.08, 20.0, gait)
    assert not fell
    assert waited_s < 4.5
