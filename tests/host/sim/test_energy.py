"""What the drives draw: a data sheet's power at stall, mechanical power, none back from braking, the rod's ratio."""

import numpy as np
import pytest

from host.robot.file import load_robot
from host.sim.energy import mean_power_W

ROBOT = load_robot("caramelo")


def test_a_stalled_servo_draws_its_data_sheets_power():
    """One servo stalled at 12 V: 12 V x 1.4 A, plus twelve servos' standby and the computer."""
    torque = np.zeros((5, 12))
    torque[:, 1] = 2.5
    rest = 12 * 0.1 * 12.0 + 5.0
    assert mean_power_W(ROBOT, torque * 0, torque * 0) == pytest.approx(rest)
    assert mean_power_W(ROBOT, torque, torque * 0) == pytest.approx(rest + 12 * 1.4)


def test_a_driven_joint_takes_mechanical_power_and_a_braked_one_gives_none_back():
    torque, speed = np.zeros((4, 12)), np.zeros((4, 12))
    torque[:, 0], speed[:, 0] = 1.0, 2.0
    current = 1.4 / 2.5
    rest = mean_power_W(ROBOT, torque * 0, torque * 0)
    assert mean_power_W(ROBOT, torque, speed) == pytest.approx(rest + current**2 * 12 / 1.4 + 2.0, abs=2e-3)
    assert mean_power_W(ROBOT, torque, -10 * speed) == pytest.approx(rest)


def test_the_rods_ratio_lowers_the_calf_motors_torque_not_its_power():
    torque, speed = np.zeros((2, 12)), np.zeros((2, 12))
    torque[:, 2], speed[:, 2] = 1.0, 1.0
    ratio = ROBOT.calf_drive.ratio
    rest = mean_power_W(ROBOT, torque * 0, torque * 0)
    copper = (ratio * 1.4 / 2.5) ** 2 * 12 / 1.4
    assert mean_power_W(ROBOT, torque, speed) == pytest.approx(rest + copper + 1.0, abs=2e-3)


def test_a_calfs_motor_on_the_body_turns_with_thigh_and_calf():
    """While only the thigh turns, both motors do; while the calf turns back as far, its motor rests."""
    robot = load_robot("parallel")
    torque, speed = np.zeros((2, 12)), np.zeros((2, 12))
    torque[:, 2], speed[:, 1] = 1.0, 3.0
    drive = robot.actuator
    held = mean_power_W(robot, torque, speed * 0)
    assert mean_power_W(robot, torque, speed) == pytest.approx(held + 3.0 / drive.gear.efficiency, abs=2e-3)
    speed[:, 2] = -3.0
    assert mean_power_W(robot, torque, speed) == pytest.approx(held, abs=2e-3)
