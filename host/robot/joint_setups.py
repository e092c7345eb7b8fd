"""What differs between a robot's twelve joints: limits at the motor, the leg's inertia at it, joint encoders."""

from ..util.errors import UserError
from .joint_units import JointSetup
from .mass import leg_inertia_kg_m2
from .model import Robot


def joint_setups(robot: Robot) -> list[JointSetup]:
    """Return what differs between the joints; a coupled calf's limits are its motor's."""
    if robot.actuator.kind != "bldc":
        raise UserError(f"{robot.name} has no CAN joints: its actuators are {robot.actuator.kind}s")
    gear, inertias = robot.actuator.gear, leg_inertia_kg_m2(robot)
    setups = []
    for leg in range(4):
        limits = robot.joint_limits_rad(leg)
        for joint in range(3):
            low, high = limits[joint]
            if joint == 2 and robot.calf_drive.coupled:
                low, high = low + limits[1][0], high + limits[1][1]
            encoder = joint != 1 or gear.thigh_encoder
            setups.append(JointSetup(low, high, has_joint_encoder=encoder, inertia_kg_m2=inertias[joint]))
    return setups
