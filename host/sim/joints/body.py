"""The robot that simulated joints move: sim2d's plane driven by torques, hips as hinges of their own.

Angles are the motors' at the joint's side of the gear: a calf whose motor sits on the body turns thigh + calf.
"""

from collections.abc import MutableSequence, Sequence
from math import copysign

from ...robot.coupling import to_motor
from ...robot.model import Robot
from ...robot.plane import planar_robot
from ...robot.poses import seated_pose_rad
from ..plant import DT_S, hinges

SLOW_RAD_S = 0.5  # below it dry friction fades, so that an explicit step stays stable (assumed)


class _Torques:
    """sim2d's drives, each of which gives the torque it was told."""

    def __init__(self) -> None:
        self.torque_Nm = [0.0] * 8

    def torques(
        self,
        goal_rad: Sequence[float],
        position_rad: Sequence[float],
        speed_rad_s: Sequence[float],
        dt_s: float,
        torque_Nm: MutableSequence[float],
    ) -> None:
        """See sim2d.actuator.Actuator."""
        torque_Nm[:] = self.torque_Nm


class TorqueBody:
    """A robot seated on flat ground. ``step`` is one millisecond with twelve motor torques."""

    def __init__(self, robot: Robot, pose_rad: Sequence[float] | None = None, seed: int = 0) -> None:
        from sim2d.model import PLANAR_INDEX
        from sim2d.run import clamped
        from sim2d.sensors import Sensors
        from sim2d.terrain import flat
        from sim2d.world import World

        pose = seated_pose_rad(robot) if pose_rad is None else list(pose_rad)
        self.robot = robot
        self._index = PLANAR_INDEX
        self._drives = _Torques()
        plane = planar_robot(robot)
        self.world = World(plane, flat(), actuator=self._drives, dt_s=DT_S)
        self.world.place(clamped(plane, pose))
        self._hinges = hinges(robot, pose)[0::3]
        self._sensors = Sensors(self.world, seed)
        self._dry_Nm = plane.thigh_servo.coulomb_Nm
        self._no_goal = [0.0] * 8
        self.angle_rad = to_motor(robot, pose)
        self.joint_rad = list(pose)

    @property
    def x_m(self) -> float:
        """Where the body is."""
        return float(self.world.parts.bodies[0].position.x)

    @property
    def height_m(self) -> float:
        """How high the body's middle is."""
        return float(self.world.parts.bodies[0].position.y)

    def pitch(self, time_s: float) -> tuple[float, float]:
        """Return pitch, rad, and its rate, rad/s, as an inertial sensor on the body tells them."""
        sensed = self._sensors.read(self.world.state(), [0.0] * 4, time_s)
        return sensed.pitch_rad, sensed.pitch_rate_rad_s

    def _friction(self, speed_rad_s: float) -> float:
        """Return the gear's dry friction, proportional to the speed where it is slow."""
        return self._dry_Nm * max(-1.0, min(1.0, speed_rad_s / SLOW_RAD_S))

    def step(self, torque_Nm: Sequence[float]) -> None:
        """Go on a millisecond; by virtual work the thigh carries both motors' torques where the calf's is coupled."""
        coupled, speeds, given = self.robot.calf_drive.coupled, self.world.speed_rad_s, self._drives.torque_Nm
        for thigh in range(0, 8, 2):
            calf_speed = speeds[thigh + 1] + (speeds[thigh] if coupled else 0.0)
            joint = self._index[thigh]
            at_thigh = torque_Nm[joint] - self._friction(speeds[thigh])
            at_calf = torque_Nm[joint + 1] - self._friction(calf_speed)
            given[thigh] = at_thigh + at_calf if coupled else at_thigh
            given[thigh + 1] = at_calf
        self.world.advance(self._no_goal, 1)
        for i, joint in enumerate(self._index):
            self.joint_rad[joint] = self.world.position_rad[i]
        for leg, hinge in enumerate(self._hinges):
            speed = hinge.speed_rad_s + torque_Nm[3 * leg] / hinge.inertia_kg_m2 * DT_S
            braked = max(0.0, abs(speed) - hinge.model.coulomb_Nm / hinge.inertia_kg_m2 * DT_S)
            hinge.speed_rad_s = copysign(braked, speed)
            low, high = hinge.limits_rad
            hinge.position_rad = min(max(hinge.position_rad + hinge.speed_rad_s * DT_S, low), high)
            self.joint_rad[3 * leg] = hinge.position_rad
        self.angle_rad[:] = to_motor(self.robot, self.joint_rad)
