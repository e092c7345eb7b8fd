"""A calf whose motor sits on the body: that motor turns by thigh and calf together."""

from collections.abc import Sequence

from .model import Robot

JOINTS = 12


def to_motor(robot: Robot, joints: Sequence[float]) -> list[float]:
    """Return motor angles (or speeds) of joint angles."""
    motor = list(joints)
    if robot.calf_drive.coupled:
        for calf in range(2, JOINTS, 3):
            motor[calf] += motor[calf - 1]
    return motor


def to_joint(robot: Robot, motors: Sequence[float]) -> list[float]:
    """Return joint angles (or speeds) of motor angles."""
    joint = list(motors)
    if robot.calf_drive.coupled:
        for calf in range(2, JOINTS, 3):
            joint[calf] -= joint[calf - 1]
    return joint
