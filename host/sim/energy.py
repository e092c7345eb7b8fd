"""The drives' power from the battery: winding losses, mechanical power, and the power at rest.

A servo's motor: current = torque x stall current / stall torque (data sheet), winding resistance = voltage /
stall current, power = current^2 x resistance + torque x speed, never below 0 (no drive feeds the battery).
A brushless joint: q current = torque / (gear x torque constant), three windings lose 3/2 R i^2, the gear its share.
The windings of foreign joints ("pd") are unknown: their losses are missing, only mechanical power counts.
"""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ..robot.actuators import Bldc, Servo
from ..robot.model import Robot

Array = np.ndarray[Any, Any]


@cache
def taken() -> dict[str, Any]:
    """Return the power data that the robot file does not have (energy.toml)."""
    return tomllib.loads((Path(__file__).parent / "energy.toml").read_text(encoding="utf-8"))


def mean_power_W(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> float:
    """Return the mean electrical power of all drives with their electronics, and of the computer.

    Rows of twelve drives' torques and of twelve joints' speeds.
    """
    data, actuator = taken(), robot.actuator
    servo_W = data["servo"]["standby_current_A"] * actuator.supply_V
    standby_W = 12 * float(servo_W if isinstance(actuator, Servo) else data["bldc"]["board_W"])
    return round(drives_power_W(robot, torque_Nm, speed_rad_s) + standby_W + float(data["computer"]["power_W"]), 3)


def drives_power_W(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> float:
    """Return the mean electrical power of the drives' motors alone: no electronics, no computer."""
    torque, speed = _at_motors(robot, torque_Nm, speed_rad_s)
    actuator, data = robot.actuator, taken()["servo"]
    lost_W, efficiency = np.zeros_like(torque), 1.0
    if isinstance(actuator, Servo):
        current_A = torque * data["stall_current_A"] / actuator.nominal.stall_Nm
        lost_W = current_A**2 * (data["stall_voltage_V"] / data["stall_current_A"])
    elif isinstance(actuator, Bldc):
        current_A = torque / (actuator.gear.ratio * actuator.motor.torque_constant_Nm_A)
        lost_W, efficiency = 1.5 * actuator.motor.resistance_ohm * current_A**2, actuator.gear.efficiency
    drawn_W = np.maximum(0.0, lost_W + torque * speed / efficiency)
    return float(drawn_W.sum(axis=1).mean())


def _at_motors(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> tuple[Array, Array]:
    """Return the motors' own torques and speeds: a coupled calf's motor turns with thigh and calf together."""
    ratios = np.array([1.0, 1.0, robot.calf_drive.ratio] * 4)
    speeds = speed_rad_s.copy()
    if robot.calf_drive.coupled:
        speeds[:, 2::3] += speeds[:, 1::3]
    return torque_Nm * ratios, speeds / ratios
