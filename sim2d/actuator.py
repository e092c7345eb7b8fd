"""The joint drives of the plane: goals and joint state in, torques out, once per sub-step.

They work in motor angles: where calves' motors sit on the torso, the world wraps them (``CalfOnTorso``).
Every sequence has PLANAR_JOINTS entries (thigh and calf of FR, FL, RR, RL). A drive may keep state of its
own (a joint controller, a rotor): ``dt_s`` is the time since its last call.
"""

from collections.abc import MutableSequence, Sequence
from typing import Protocol

from .model import PLANAR_JOINTS, ServoModel

Told = Sequence[float]
Given = MutableSequence[float]


class Actuator(Protocol):
    """All eight drives of the plane."""

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """Write each joint's torque for the coming ``dt_s`` into ``torque_Nm``; positive about +y."""


class Drives(Actuator, Protocol):
    """Drives that also report the torque at their own shafts, to which their limits apply."""

    @property
    def given_Nm(self) -> Sequence[float]:
        """The drives' own torques of the last call."""

    @property
    def limit_Nm(self) -> Sequence[float]:
        """Each drive's largest torque: its stall torque, or that at its current limit."""


class PositionServos:
    """Eight position servos: duty = clip(error x stiffness / stall), torque = stall x duty - b x speed.

    A drive with a speed loop damps within its stall torque.

    It has no integral term and no speed loop, so it sags under load, as the real one does.
    """

    def __init__(self, servos: Sequence[ServoModel]) -> None:
        if len(servos) != PLANAR_JOINTS:
            raise ValueError(f"actuator: {len(servos)} servos, must be {PLANAR_JOINTS}")
        self._rows = []
        for i, s in enumerate(servos):
            inner, outer = (s.damping_Nms_rad, 0.0) if s.speed_loop else (0.0, s.damping_Nms_rad)
            self._rows.append((i, s.stiffness_Nm_rad, s.stall_torque_Nm, inner, outer))
        self.given_Nm = [0.0] * PLANAR_JOINTS
        self.limit_Nm = [s.stall_torque_Nm for s in servos]

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See ``Actuator``. Written without calls: this runs eight thousand times per simulated second."""
        given_Nm = self.given_Nm
        for i, stiffness, stall, inner, outer in self._rows:
            drive = stiffness * (goal_rad[i] - position_rad[i]) - inner * speed_rad_s[i]
            if drive > stall:
                drive = stall
            elif drive < -stall:
                drive = -stall
            torque_Nm[i] = given_Nm[i] = drive - outer * speed_rad_s[i]


class CalfOnTorso:
    """Drives of a leg whose calf motor sits at the hip (paper B): motor calf = thigh + calf.

    The wrapped drives work in motor angles. By virtual work the thigh joint carries both motors' torques and
    the calf joint the calf motor's alone.
    """

    def __init__(self, motors: Actuator) -> None:
        self._motors = motors
        self._goal = [0.0] * PLANAR_JOINTS
        self._position = [0.0] * PLANAR_JOINTS
        self._speed = [0.0] * PLANAR_JOINTS

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See ``Actuator``; joint angles and joint torques outside, motor ones inside."""
        _to_motor(goal_rad, self._goal)
        _to_motor(position_rad, self._position)
        _to_motor(speed_rad_s, self._speed)
        self._motors.torques(self._goal, self._position, self._speed, dt_s, torque_Nm)
        for thigh in range(0, PLANAR_JOINTS, 2):
            torque_Nm[thigh] += torque_Nm[thigh + 1]


def _to_motor(joint: Sequence[float], motor: MutableSequence[float]) -> None:
    """Write motor values (thigh, thigh + calf) from joint values (thigh, calf), leg by leg."""
    for thigh in range(0, PLANAR_JOINTS, 2):
        motor[thigh] = joint[thigh]
        motor[thigh + 1] = joint[thigh] + joint[thigh + 1]
