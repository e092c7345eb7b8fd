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

from ..robot.actuators import Bldc, PdJoint, Servo
from ..robot.model import Robot

Array = np.ndarray[Any, Any]


@cache
def taken() -> dict[str, Any]:
    """Return the power data that the robot file does not have (energy.toml)."""
    return tomllib.loads((Path(__file__).parent / "energy.toml").read_text(encoding="utf-8"))


def mean_power_W(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> float:
    """Return the mean electrical power of all drives and the computer.

    Rows of twelve drives' torques and of twelve joints' speeds.
    """
    torque, speed = _at_motors(robot, torque_Nm, speed_rad_s)
    drives_W = _drives_W(robot.actuator, torque, speed)
    return round(drives_W + float(taken()["computer"]["power_W"]), 3)


def drives_power_W(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> float:
    """Return the mean electrical power of the drives' motors alone: no electronics, no computer."""
    torque, speed = _at_motors(robot, torque_Nm, speed_rad_s)
    if isinstance(robot.actuator, Servo):
        standby_W = 12 * taken()["servo"]["standby_current_A"] * robot.actuator.nominal.voltage_V
        return _drives_W(robot.actuator, torque, speed) - float(standby_W)
    return _drives_W(robot.actuator, torque, speed) - 12 * float(taken()["bldc"]["board_W"])


def _drives_W(actuator: Servo | Bldc | PdJoint, torque: Array, speed: Array) -> float:
    if isinstance(actuator, Servo):
        return _servos_W(actuator, torque, speed)
    if isinstance(actuator, Bldc):
        return _joints_W(actuator, torque, speed)
    drawn_W = np.maximum(0.0, torque * speed)
    return float(drawn_W.sum(axis=1).mean()) + 12 * float(taken()["bldc"]["board_W"])


def _at_motors(robot: Robot, torque_Nm: Array, speed_rad_s: Array) -> tuple[Array, Array]:
    """Return the motors' own torques and speeds: a coupled calf's motor turns with thigh and calf together."""
    ratios = np.array([1.0, 1.0, robot.calf_drive.ratio] * 4)
    speeds = speed_rad_s.copy()
    if robot.calf_drive.coupled:
        speeds[:, 2::3] += speeds[:, 1::3]
    return torque_Nm * ratios, speeds / ratios


def _servos_W(servo: Servo, torque: Array, speed: Array) -> float:
    data = taken()["servo"]
    resistance_ohm = data["stall_voltage_V"] / data["stall_current_A"]
    current_A = torque * data["stall_current_A"] / servo.nominal.stall_Nm
    drawn_W = np.maximum(0.0, current_A**2 * resistance_ohm + torque * speed)
    standby_W = 12 * data["standby_current_A"] * servo.nominal.voltage_V
    return float(drawn_W.sum(axis=1).mean()) + standby_W


def _joints_W(drive: Bldc, torque: Array, speed: Array) -> float:
    current_A = torque / (drive.gear.ratio * drive.motor.torque_constant_Nm_A)
    copper_W = 1.5 * drive.motor.resistance_ohm * current_A**2
    drawn_W = np.maximum(0.0, copper_W + torque * speed / drive.gear.efficiency)
    return float(drawn_W.sum(axis=1).mean()) + 12 * float(taken()["bldc"]["board_W"])
