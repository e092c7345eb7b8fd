"""Odometry by the legs: exact for feet that stay, within some per cent for a robot that walks."""

from math import cos, radians, sin

import pytest

from host.control.odometry import LegOdometry
from host.library.robot import Robot
from host.robot.file import load_robot
from host.robot.kinematics_si import leg_inverse
from host.robot.poses import rest_pose_rad
from host.robot.trot_tuning import rolling

CARAMELO = load_robot("caramelo")
ALL_STAND, FRONT_SWING = 0, 3
ROLLS = 1 / rolling(CARAMELO)  # a round foot rolls on below its centre


def joints_of(x_m, y_m, yaw_rad):
    """Return the joints of a body at this place over feet that stay where they are at rest."""
    joints = []
    for leg in range(4):
        hip_x, hip_y = CARAMELO.hip_m(leg)
        foot = CARAMELO.foot_m(leg, CARAMELO.stance.rest_height_m)
        dx, dy = foot[0] + hip_x - x_m, foot[1] + hip_y - y_m
        c, s = cos(yaw_rad), sin(yaw_rad)
        seen = c * dx + s * dy - hip_x, -s * dx + c * dy - hip_y, foot[2]
        links, side, knee = CARAMELO.geometry.links_m, CARAMELO.side(leg), CARAMELO.knee_sign(leg)
        joints += leg_inverse(links, side, knee, seen)
    return joints


def moved(ticks, swinging=ALL_STAND, gyro=True):
    """Move a body over its feet along a curve of 20 mm, 10 mm and 5 degrees; return what is told."""
    odometry, turn = LegOdometry(CARAMELO, 50), radians(5)
    for _ in range(10):
        odometry.update(rest_pose_rad(CARAMELO), swinging, (0.0, 0.0), 0.0 if gyro else None)
    for tick in range(1, ticks + 1):
        share = tick / ticks
        joints = joints_of(0.02 * share, 0.01 * share, turn * share)
        odometry.update(joints, swinging, (0.0, 0.0), 50 * turn / ticks if gyro else None)
    return odometry


@pytest.mark.parametrize("gyro", [True, False])
@pytest.mark.parametrize("swinging", [ALL_STAND, FRONT_SWING])
def test_it_is_exact_for_feet_that_stay(gyro, swinging):
    now = moved(100, swinging, gyro).now
    assert (now.x_m, now.y_m, now.yaw_rad) == pytest.approx((0.02 * ROLLS, 0.01 * ROLLS, radians(5)), abs=5e-5)
    assert now.wz_rad_s == pytest.approx(radians(2.5), rel=0.01)


def test_feet_in_the_air_move_nothing():
    assert moved(100, swinging=15).now.x_m == 0.0


def test_a_gap_moves_nothing():
    odometry = moved(100)
    before = odometry.now
    odometry.lost()
    odometry.update(joints_of(0.0, 0.0, 0.0), ALL_STAND, (0.0, 0.0), 0.0)
    assert (odometry.now.x_m, odometry.now.yaw_rad) == (before.x_m, before.yaw_rad)


@pytest.mark.parametrize("place", ["sim", "space"])
def test_a_walk_is_told_within_some_per_cent(place):
    """Measured: in the plane 2.2 % too short at 0.05 m/s, in space 1.8 %, and 0.3 % at 0.3 m/s; 5 % is allowed."""
    if place == "space":
        pytest.importorskip("mujoco")
    with Robot(place) as robot:
        robot.stand()
        start_m = robot.truth[0]
        robot.walk(0.05, seconds=8.0)
        assert robot.odometry.x_m == pytest.approx(robot.truth[0] - start_m, rel=0.05)
        assert robot.odometry.x_m > 0.25
