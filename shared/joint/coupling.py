"""The calf's rod: its motor sets the calf's absolute angle, so moving the thigh alone turns the calf under it.

calf motor = thigh + calf (both pitch angles, brad). Torques are the transpose: the calf motor's
torque also loads the thigh joint.
"""

from ..runtime import hot


@hot
def calf_motor(thigh_brad: int, calf_brad: int) -> int:
    """Return the calf motor's angle for joint angles within +-2^28 brad (or speeds in one unit). Exact."""
    return thigh_brad + calf_brad


@hot
def calf_joint(thigh_brad: int, motor_brad: int) -> int:
    """Return the calf's joint angle from the thigh's and the calf motor's, within +-2^28. Exact."""
    return motor_brad - thigh_brad


@hot
def thigh_motor_torque(thigh_torque: int, calf_torque: int) -> int:
    """Return what the thigh motor must give for two joint torques in one unit, within +-2^28. Exact.

    The calf motor gives ``calf_torque`` itself.
    """
    return thigh_torque - calf_torque


@hot
def thigh_joint_torque(thigh_motor: int, calf_motor_torque: int) -> int:
    """Return the torque at the thigh joint from both motors', in one unit, within +-2^28. Exact."""
    return thigh_motor + calf_motor_torque
