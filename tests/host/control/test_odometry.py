"""Odometry of a robot that walks: right within some per cent, and within what it says itself."""

import random
from math import degrees, dist, hypot, remainder, tau

import pytest

from host.control.odometry import read_odometry
from host.library.robot import Robot
from host.robot.file import load_robot
from host.sim.grounds import GroundSpec
from host.sim.walk import WalkSpec
from shared.body.params import Params
from shared.sense.odometry import Odometry

FLAT, ROUGH = 0.02, 0.05  # of the way
LEVEL = ("flat", "ahead"), ("flat", "arc"), ("flat", "aside")
UNEVEN = ("stones", "ahead"), ("step", "ahead"), ("ramp", "ahead"), ("step-down", "ahead")
ROBOTS = ("caramelo", "parallel")
WALK_S = 30.0


def walks(count, seed):
    """Draw walks: robot, ground, commanded speeds, seed of the noise and of stones."""
    dice = random.Random(seed)
    for number in range(count):
        kinds = LEVEL if number % 2 else UNEVEN
        ground, way = kinds[number // 2 % len(kinds)]
        speed = dice.choice((0.05, 0.1, 0.15))
        turn, left = (dice.uniform(-0.3, 0.3), 0.0) if way == "arc" else (0.0, 0.04 if way == "aside" else 0.0)
        speeds = {"vx_m_s": speed, "vy_m_s": left, "wz_rad_s": turn}
        yield ROBOTS[number // 10 % 2], ground, speeds, number + 1000 * seed


def walked(name, ground, speeds, seed):
    """Walk in space; return the way gone, m, and what odometry says and was off: way_m, told, (x, y, yaw)."""
    from host.sim.space.walk import SpaceWalker

    robot = load_robot(name)
    over = GroundSpec(ground, seed=seed, length_m=8.0 if ground == "stones" else None)
    spec = WalkSpec(robot, robot.gait.default, ground=over, seed=seed)
    walker = SpaceWalker(spec)
    walker.stand_up()
    driver, world = walker.driver, walker.world
    driver.restart_odometry()
    (x, y, _), yaw = world.position_m(), world.attitude_rad()[2]
    start, way_m, last = (x, y, yaw), 0.0, (x, y)
    driver.set_command(mode="walk", **speeds)
    for tick in range(round((WALK_S + 2.0) * driver.rate_hz)):
        if tick == round(WALK_S * driver.rate_hz):
            driver.set_command(mode="stand")
        walker.tick()
        roll, pitch, now = world.attitude_rad()
        assert max(abs(roll), abs(pitch)) < 0.8, f"{name} fell: {ground}, {speeds}"
        yaw += remainder(now - yaw, tau)
        if tick % 25 == 0:
            here = tuple(world.position_m()[:2])
            way_m, last = way_m + dist(here, last), here
    told, (x, y, _) = driver.odometry, world.position_m()
    gone = x - start[0], y - start[1]  # it began at a heading of 0, but for some thousandths
    turned = told.yaw_rad - (yaw - start[2])
    return way_m, told, (told.x_m - gone[0], told.y_m - gone[1], turned)


@pytest.mark.parametrize(("count", "seed", "least"), [(6, 1, 5), pytest.param(40, 2, 38, marks=pytest.mark.slow)])
def test_walks_in_space_are_told_within_2_or_5_per_cent_and_mostly_within_2_sigma(count, seed, least):
    """Every walk within its share of the way; 2 sigma 5 times of 6, and 95 times of 100."""
    pytest.importorskip("mujoco")
    inside = 0
    for name, ground, speeds, number in walks(count, seed):
        way_m, told, off = walked(name, ground, speeds, number)
        most = FLAT if ground == "flat" else ROUGH
        assert hypot(off[0], off[1]) < most * way_m, f"{name}, {ground}, {speeds}, {number}: {off}"
        if ground == "flat":
            assert abs(degrees(off[2])) < 2.0 * max(1.0, way_m / 10)
        inside += all(abs(each) < 2 * sigma for each, sigma in zip(off, told.sigma, strict=True))
    assert inside >= least


def test_a_walk_in_the_plane_is_told_within_some_per_cent():
    with Robot("sim") as robot:
        robot.stand()
        start_m = robot.truth[0]
        robot.walk(0.05, seconds=8.0)
        assert robot.odometry.x_m == pytest.approx(robot.truth[0] - start_m, rel=0.05)
        assert robot.odometry.x_m > 0.25
        assert abs(robot.odometry.yaw_rad) < 2 * robot.odometry.sigma[2]


def test_the_covariance_is_that_of_its_error_vectors():
    params, block = Params(), Odometry()
    params.length_shift, params.rate_hz = 16, 50
    block.place.x, block.heading_spread.y = 65536 * 4, 65536 * 64
    block.walked, block.heading_sigma_q26 = 65536 * 4, 1 << 22
    told = read_odometry(params, block)
    place_spread_m, scale_spread_m, heading_spread_m, sigma_rad = 0.001 + 4 / 256, 4 / 256, 0.25, 1 / 16
    xx, xy, xt, yx, yy, yt, tx, ty, tt = told.covariance
    assert xx == pytest.approx(scale_spread_m**2 + place_spread_m**2, rel=1e-2)
    yy_told = heading_spread_m**2 + place_spread_m**2
    assert (yy, yt, tt) == pytest.approx((yy_told, heading_spread_m * sigma_rad, sigma_rad**2), rel=1e-2)
    assert (xy, xt) == (yx, tx) == (0.0, 0.0)
    assert ty == yt
