"""One script, four places: stands, walks, turns, poses, streams, sits."""

from math import degrees

import pytest

from tests.host.library.places import robot_in, robot_on_terminal

CALF = 2  # FR's


def script(robot):
    """What a user writes, who need not know where the robot is. Returns what was sensed after each part."""
    robot.stand()
    stood = robot.sensed
    robot.walk(0.05, seconds=2.0)
    walked = robot.sensed
    robot.turn(deg=10, wz_rad_s=0.3)
    turned = robot.sensed
    robot.pose(z_m=-0.02)
    crouched = robot.sensed  # beside the turn's end: before the first walk the legs' sag is not fed forward
    robot.pose()
    lifted = stood.goals_rad[CALF] - 0.2  # more bent: the foot leaves the ground
    for _ in robot.stream(hz=25, joint_rad_s=0.5, seconds=0.8):
        robot.set_joints({"FR_calf": lifted})
    streamed = robot.sensed
    robot.sit()
    return stood, walked, turned, crouched, streamed


@pytest.mark.parametrize("place", ["sim", "space", "servos", "can"])
def test_one_script_runs_everywhere(place):
    """Requirement: ten lines, the same in each place. With 3 s and 20 deg it printed there, in the order above:

    walked 0.134, 0.119, 0.139, 0.156 m; turned 18.8, 19.4, 18.6, 20.4 deg. Then, with 2 s and 10 deg, a calf crouched
    by 0.164, 0.161, 0.145, 0.115 rad and answered a goal 0.2 rad off with 0.144, 0.150, 0.143, 0.154 rad.
    """
    if place == "space":
        pytest.importorskip("mujoco")
    with robot_in(place) as robot:
        stood, walked, turned, crouched, streamed = script(robot)
        assert robot.sensed.state == "disarmed"
    assert 0.06 < walked.odometry.x_m < 0.15
    assert abs(walked.odometry.y_m) < 0.03
    most_deg = 13 if place in ("sim", "space") else 25  # joints without a ground go on turning in the air
    assert 7 < degrees(turned.odometry.yaw_rad - walked.odometry.yaw_rad) < most_deg
    assert crouched.joints_rad[CALF] - turned.joints_rad[CALF] < -0.04
    assert streamed.goals_rad[CALF] - stood.goals_rad[CALF] == pytest.approx(-0.2)
    assert -0.25 < streamed.joints_rad[CALF] - stood.joints_rad[CALF] < -0.10


@pytest.mark.slow
def test_it_runs_in_real_time_on_servos_behind_a_terminal(tmp_path):
    with robot_on_terminal(tmp_path) as robot:
        robot.stand()
        robot.walk(0.05, seconds=1.0)
        assert robot.odometry.x_m > 0.02
        robot.sit()
        assert robot.sensed.state == "disarmed"
