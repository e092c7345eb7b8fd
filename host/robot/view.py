"""The figure that the page draws: joints, feet, support polygon and centre of mass, in m, level with the ground.

Origin in the middle of the hips; x forward, y left, z up, turned by roll and pitch as in shared/sense/attitude.py.
Masses count as lying on the lines between the joints; the few mm beside them are ignored.
"""

from collections.abc import Sequence
from math import cos, sin
from typing import Any

from .kinematics_si import Vector, leg_forward
from .model import Robot

OUTLINE = (0, 1, 3, 2)  # legs around the body: FR, FL, RL, RR


class View:
    """One robot's figure."""

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._links = robot.geometry.links_m
        thigh, calf = robot.links.thigh, robot.links.calf
        l1, l2, l3 = self._links
        # Link lengths with which leg_forward ends at the thigh joint, the knee, the foot, and at the two masses.
        self._ends = ((l1, 0.0, 0.0), (l1, l2, 0.0), (l1, l2, l3))
        self._masses = (
            (robot.links.hip.mass_kg, (l1, 0.0, 0.0)),
            (thigh.mass_kg, (l1, -thigh.com_m[2], 0.0)),
            (calf.mass_kg, (l1, l2, -calf.com_m[2])),
        )

    def points(self, joints_rad: Sequence[float], roll_rad: float, pitch_rad: float, swinging: int) -> dict[str, Any]:
        """Return legs (hip, thigh joint, knee, foot), the stance feet in order, the centre of mass and the ground.

        The ground is under the lowest point, which is a knee or the body if the robot lies.
        """
        legs = [self._leg(leg, joints_rad) for leg in range(4)]
        trunk = self._robot.links.trunk
        mass_kg, moment = trunk.mass_kg, [trunk.mass_kg * at for at in trunk.com_m]
        for leg in range(4):
            for part_kg, lengths in self._masses:
                at = self._at(leg, joints_rad, lengths)
                moment = [m + part_kg * a for m, a in zip(moment, at, strict=True)]
                mass_kg += part_kg
        level = [[_level(point, roll_rad, pitch_rad) for point in leg] for leg in legs]
        return {
            "legs": level,
            "ground_m": min(point[2] for leg in level for point in leg),
            "standing": [leg for leg in OUTLINE if not swinging >> leg & 1],
            "com": _level((moment[0] / mass_kg, moment[1] / mass_kg, moment[2] / mass_kg), roll_rad, pitch_rad),
        }

    def _leg(self, leg: int, joints_rad: Sequence[float]) -> list[Vector]:
        return [(*self._robot.hip_m(leg), 0.0), *(self._at(leg, joints_rad, end) for end in self._ends)]

    def _at(self, leg: int, joints_rad: Sequence[float], lengths: Vector) -> Vector:
        """Return the end of a leg with these link lengths, in the body."""
        hip, thigh, calf = joints_rad[3 * leg : 3 * leg + 3]
        x, y, z = leg_forward(lengths, self._robot.side(leg), (hip, thigh, calf))
        hip_x, hip_y = self._robot.hip_m(leg)
        return hip_x + x, hip_y + y, z


def _level(point: Vector, roll_rad: float, pitch_rad: float) -> list[float]:
    """Return Rx(roll) Ry(pitch) times a point, to 0.1 mm."""
    x, y, z = point
    x, z = cos(pitch_rad) * x + sin(pitch_rad) * z, -sin(pitch_rad) * x + cos(pitch_rad) * z
    y, z = cos(roll_rad) * y - sin(roll_rad) * z, sin(roll_rad) * y + cos(roll_rad) * z
    return [round(x, 4), round(y, 4), round(z, 4)]
