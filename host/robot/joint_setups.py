"""What differs between the twelve joints of a robot: limits at the motor, and whether there is a joint encoder."""

from ..util.errors import UserError
from .joint_units import JointSetup
from .model import Robot


def joint_setups(robot: Robot) -> list[JointSetup]:
    """Return what differs from joint to joint; a coupled calf's limits are its motor's."""
    if robot.actuator.kind != "bldc":
        raise UserError(f"{robot.name} has no CAN joints: its actuators are {robot.actuator.kind}s")
    gear = robot.actuator.gear
    setups = []
    for leg in range(4):
        limits = robot.joint_limits_rad(leg)
        for joint in range(3):
            low, high = limits[joint]
            if joint == 2 and robot.calf_drive.coupled:
                low, high = low + limits[1][0], high + limits[1][1]
            setups.append(JointSetup(low, high, has_joint_encoder=joint != 1 or gear.thigh_encoder))
    return setups
