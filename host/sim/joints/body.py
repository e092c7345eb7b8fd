"""The robot that simulated joints move: sim2d's plane driven by torques, hips as hinges of their own.

Angles are the motors' at the joint's side of the gear: a calf whose motor sits on the body turns thigh + calf.
"""

from collections.abc import Sequence

from sim2d.actuator import Given, Told
from sim2d.model import PLANAR_INDEX

from ...robot.coupling import to_motor
from ...robot.model import Robot
from ...robot.plane import planar_robot
from ...robot.poses import seated_pose_rad
from ..plant import DT_S, PlaneBody

SLOW_RAD_S = 0.5  # below it dry friction fades, so that an explicit step stays stable (assumed)


class _Torques:
    """sim2d's drives, each of which gives the commanded torque less its gear's dry friction."""

    def __init__(self, dry_Nm: float) -> None:
        self._dry_Nm, self.torque_Nm = dry_Nm, [0.0] * len(PLANAR_INDEX)

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See sim2d.actuator.Actuator; friction is proportional to the speed where that is slow."""
        for i, speed in enumerate(speed_rad_s):
            torque_Nm[i] = self.torque_Nm[i] - self._dry_Nm * max(-1.0, min(1.0, speed / SLOW_RAD_S))


class TorqueBody(PlaneBody):
    """A robot seated on flat ground. ``step`` is one millisecond with twelve motor torques."""

    def __init__(self, robot: Robot, seed: int) -> None:
        pose = seated_pose_rad(robot)
        self._drives = _Torques(planar_robot(robot).thigh_servo.coulomb_Nm)
        super().__init__(robot, pose, self._drives, seed)
        self.angle_rad = to_motor(robot, pose)

    @property
    def x_m(self) -> float:
        """Where the body is."""
        return float(self.world.parts.bodies[0].position.x)

    @property
    def height_m(self) -> float:
        """How high the body's middle is."""
        return float(self.world.parts.bodies[0].position.y)

    def pitch(self, time_s: float) -> tuple[float, float]:
        """Return pitch, rad, and its rate, rad/s, as an inertial sensor on the body measures them."""
        sensed = self.sensed(time_s)
        return sensed.pitch_rad, sensed.pitch_rate_rad_s

    def step(self, torque_Nm: Sequence[float]) -> None:
        """Go on a millisecond."""
        self._drives.torque_Nm[:] = [torque_Nm[joint] for joint in PLANAR_INDEX]
        self.run(torque_Nm, 1, lambda joint, hinge: hinge.step(torque_Nm[joint], DT_S))
        self.angle_rad[:] = to_motor(self.robot, self.position_rad)
