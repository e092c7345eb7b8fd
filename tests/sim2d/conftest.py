"""Caramelo as numbers for the plane's own tests: from the robot's public configuration and the servo's datasheet."""

import math

import pytest

from sim2d.model import Link, PlanarRobot, ServoModel

# MX-28(2.0) datasheet: 11.1 V 2.3 N m 50 rpm, 12 V 2.5 N m 55 rpm, 14.8 V 3.1 N m 67 rpm, relative to 12 V.
MX28_VOLTAGES = ((11.1, 2.3 / 2.5, 50 / 55), (12.0, 1.0, 1.0), (14.8, 3.1 / 2.5, 67 / 55))
# Armature and Coulomb friction are assumed; the calf's servo drives it through a rod, 1.12283 to 1.
THIGH_SERVO = ServoModel(2.50, 12.23, 0.434, 0.0032, 0.06, 12.0, MX28_VOLTAGES)
CALF_SERVO = ServoModel(2.23, 9.70, 0.344, 0.0032, 0.06, 12.0, MX28_VOLTAGES)
STAND_THIGH_RAD = math.acos(0.170 / 2 / 0.120)


def caramelo(**changes: object) -> PlanarRobot:
    """Return Caramelo, full elbow, standing at 0.170 m; keyword arguments replace fields."""
    numbers: dict[str, object] = {
        "name": "caramelo",
        "torso": Link(1.284, 4.60e-3, 0.0015, 0.003),
        "hip_mass_kg": 0.077,
        "thigh": Link(0.118, 1.65e-4, 0.0, -0.019),
        "calf": Link(0.035, 8.4e-5, 0.005, -0.060),
        "hip_x_m": (0.11455, 0.11455, -0.11455, -0.11455),
        "thigh_length_m": 0.120,
        "calf_length_m": 0.120,
        "thigh_limits_rad": (math.radians(-15), math.radians(105)),
        "calf_limits_rad": (math.radians(-126), math.radians(-54)),
        "thigh_servo": THIGH_SERVO,
        "calf_servo": CALF_SERVO,
        "stand_pose_rad": (0.0, STAND_THIGH_RAD, -2 * STAND_THIGH_RAD) * 4,
    }
    return PlanarRobot(**(numbers | changes))  # type: ignore[arg-type]


@pytest.fixture
def robot() -> PlanarRobot:
    return caramelo()
