"""The robot in three dimensions behind simulated joints: a Plant in MuJoCo, whose drives can be off or limited."""

from collections.abc import Sequence

import mujoco
import numpy as np

from ...bus.base import JOINTS
from ...robot.model import Robot
from ...robot.poses import seated_pose_rad
from ..export.ground import Ground
from ..export.mjcf import ModelOptions
from ..imu import Motion
from ..plant import DT_S, Plant
from .walk import FAST
from .world import World


class SwitchedWorld(World):
    """A world in which the robot waits seated, each of its drives off, and goals act at once."""

    def __init__(self, robot: Robot, ground: Ground) -> None:
        dt_s, impratio = FAST
        super().__init__(robot, ModelOptions(ground, dt_s=dt_s, impratio=impratio), robot.control.rate_hz)
        self._gain, self._bias = self.model.actuator_gainprm.copy(), self.model.actuator_biasprm.copy()
        self.stall_Nm = self.model.actuator_forcerange[:, 1].copy()

    def rest(self) -> None:
        """Put the robot seated on the floor below x = 0; the time goes on."""
        mujoco.mj_resetData(self.model, self.data)
        super().rest()
        pose = np.array(seated_pose_rad(self.robot))
        self.data.qpos[self.joints.q] = pose
        self.data.qpos[self.joints.q[0] - 5] -= self.robot.stance.rest_height_m - self.robot.stance.sit_height_m
        mujoco.mj_forward(self.model, self.data)

    def drive(self, goal_rad: Sequence[float], on: Sequence[bool], limit: Sequence[float]) -> None:
        """Command the drives: their goals, which of them give torque, and up to what share of their stall torque."""
        self._act(np.asarray(goal_rad, dtype=float))
        if self.drives is not None:
            self.drives.switch(on, limit)
        gives = np.asarray(on, dtype=float)[:, None]
        self.model.actuator_gainprm[:], self.model.actuator_biasprm[:] = self._gain * gives, self._bias * gives
        most = self.stall_Nm * np.asarray(limit, dtype=float)
        self.model.actuator_forcerange[:] = np.stack([-most, most], axis=1)

    def run_until(self, time_s: float) -> None:
        """Go on to a time, in whole steps."""
        self._run_to(int(time_s / self.options.dt_s + 1e-6))

    def motion_since(self) -> Motion:
        """Return the motion as ``motion`` does, and begin the mean of the next control period."""
        motion = self.motion()
        self._remember()
        return motion


class SpacePlant(Plant):
    """A robot that waits seated. A drive that is off turns freely against its friction and damping."""

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot, seated_pose_rad(robot))
        self.set_ground(Ground("flat"))

    def set_ground(self, ground: Ground) -> None:
        """Put the robot down, seated and with its drives off, on another ground."""
        self.world, self._began_s = SwitchedWorld(self.robot, ground), self.time_s
        self.drives.on[:] = [False] * JOINTS
        self._look()

    def place(self) -> tuple[float, float, float, float]:
        """Return where the middle of the hips is, x, y and z in m, and the body's yaw, rad."""
        x_m, y_m, z_m = self.world.position_m().tolist()
        return x_m, y_m, z_m, self.world.attitude_rad()[2]

    def pose(self) -> tuple[float, float, float]:
        """See Plant."""
        x_m, y_m, _, yaw_rad = self.place()
        return x_m, y_m, yaw_rad

    def put_back(self) -> None:
        """See Plant."""
        self.world.rest()
        self._look()

    def inertial(self) -> Motion:
        """See Plant."""
        return self.world.motion_since()

    def _run(self, steps: int) -> None:
        drives = self.drives
        self.world.drive(drives.goal_rad, drives.on, drives.limit)
        self.world.run_until(self.time_s + steps * DT_S - self._began_s)
        self._look()

    def _look(self) -> None:
        self.position_rad[:] = self.world.joints_rad().tolist()
        self.speed_rad_s[:] = self.world.joint_speeds_rad_s().tolist()
        self.drives.load[:] = (self.world.data.actuator_force / self.world.stall_Nm).tolist()
