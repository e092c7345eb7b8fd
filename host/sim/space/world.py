"""The robot in MuJoCo: goals in, physics forward, sensors out as the real robot's would read.

The sensors are joint angles in encoder steps, and the body's motion as an IMU's low-pass sees it (host/imu adds bias,
noise and counts). Truth (pose, contacts, torques) is for figures only.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import mujoco
import numpy as np
import numpy.typing as npt

from sim2d.model import GRAVITY_M_S2

from ...robot.actuators import Servo
from ...robot.coupling import to_motor
from ...robot.model import LEG_NAMES, Robot, Vector
from ...robot.poses import rest_pose_rad
from ..export.mjcf import ModelOptions, mjcf
from ..servos.law import honest_figures
from .drives import HonestDrives, Joints, compliant

Array = npt.NDArray[np.float64]

_SOFT_DAMPING = 1.0  # of critical, for a foot on soft ground (assumed)
_GROUND, _TRUNK, _LIMB, _FOOT = 1, 2, 3, 10


class World:
    """One robot on one ground. ``bus_delay_s``: how late goals act.

    A step of the simulation is at most ``options.dt_s``: as much less as makes a control period a whole number of them.
    """

    def __init__(self, robot: Robot, options: ModelOptions, rate_hz: int, *, bus_delay_s: float = 0.02) -> None:
        self._steps_per_tick = math.ceil(1 / (rate_hz * options.dt_s) - 1e-9)
        options = replace(options, dt_s=1 / (rate_hz * self._steps_per_tick))
        self.robot, self.options, self.rate_hz, kind = robot, options, rate_hz, robot.simulation
        made = replace(options, at_rest=False, honest=kind.honest, self_collision=kind.honest and kind.self_collision)
        self.model = mujoco.MjModel.from_xml_string(mjcf(robot, made))
        self.data = mujoco.MjData(self.model)
        self.trunk = self.model.body("trunk").id
        self.joints = Joints(self.model)
        # The trunk's own coordinates: loose stones come before it, and on a stand it has none.
        hip_q, hip_v = int(self.joints.q[0]), int(self.joints.v[0])
        base_q, base_v = (hip_q, hip_v) if options.on_a_stand else (hip_q - 7, hip_v - 6)
        self._at, self._turn = slice(base_q, min(base_q + 3, hip_q)), slice(min(base_q + 3, hip_q), hip_q)
        self._velocity = slice(base_v, min(base_v + 3, hip_v))
        figures = honest_figures(robot.actuator) if kind.honest else None
        self.drives = None if figures is None else HonestDrives(robot, self.model, self.data, self.joints, figures,
                                                                options.voltage_V or figures.voltage_V)
        self._kind = self._kinds()
        if kind.honest and kind.ground_N_m:
            self._soften(kind.ground_N_m)
        self._delay_steps = round(bus_delay_s / options.dt_s)
        self._sent: deque[tuple[int, Array]] = deque()
        self._step = 0
        self._resolution_rad, self._goal_step_rad = _resolutions(robot)
        self._limits_rad = np.array([robot.joint_limits_rad(leg)[joint] for leg in range(4) for joint in range(3)])
        self.rest()

    def _kinds(self) -> npt.NDArray[np.int64]:
        """Classify the shapes: ground, trunk, thighs and calves, feet (by leg)."""
        kinds = np.zeros(self.model.ngeom, dtype=np.int64)
        for i in range(self.model.ngeom):
            name = self.model.geom(i).name
            if name.startswith("ground"):
                kinds[i] = _GROUND
            elif name == "trunk":
                kinds[i] = _TRUNK
            elif name.endswith("_foot"):
                kinds[i] = _FOOT + LEG_NAMES.index(name[:2])
            elif name:
                kinds[i] = _LIMB
        return kinds

    def _soften(self, ground_N_m: float) -> None:
        """Let the ground give under the feet; other parts find it hard."""
        for geom in np.flatnonzero(self._kind >= _FOOT):
            inverse_kg = float(self.model.body_invweight0[self.model.geom_bodyid[geom], 0])
            self.model.geom_solref[geom], self.model.geom_solimp[geom] = compliant(
                ground_N_m, _SOFT_DAMPING, inverse_kg, self.options.dt_s)  # fmt: skip

    def rest(self) -> None:
        """Put the robot into its rest pose on the floor below x = 0."""
        pose = rest_pose_rad(self.robot)
        self.data.qpos[self.joints.q] = pose
        if self.drives is not None:
            self.drives.rest()
        self._act(np.array(pose))
        mujoco.mj_forward(self.model, self.data)
        self._remember()

    def _act(self, goal_rad: Array) -> None:
        """Hand a goal to the drives; a coupled calf's drive holds thigh + calf."""
        goals = to_motor(self.robot, goal_rad.tolist())
        if self.drives is None:
            self.data.ctrl[:] = goals
        else:
            self.drives.act(goals)

    def send(self, goal_rad: Sequence[float]) -> None:
        """Send twelve goals: limited as the drives would, in their register's steps, acting after the bus delay."""
        goal = np.clip(np.asarray(goal_rad, dtype=float), self._limits_rad[:, 0], self._limits_rad[:, 1])
        if self._goal_step_rad is not None:
            goal = np.round(goal / self._goal_step_rad) * self._goal_step_rad
        self._sent.append((self._step + self._delay_steps, goal))

    def push(self, force_N: tuple[float, float]) -> None:
        """Push the middle of the trunk, N ahead and to the left in the ground's axes, until the next call."""
        self.data.xfrc_applied[self.trunk, :2] = force_N

    def advance(self) -> None:
        """Run one control period; goals act from the sub-step they arrive at."""
        end = self._step + self._steps_per_tick
        self._remember()
        while self._sent and self._sent[0][0] < end:
            due, goal = self._sent.popleft()
            self._run_to(due)
            self._act(goal)
        self._run_to(end)

    def _run_to(self, step: int) -> None:
        if self.drives is not None:
            for _ in range(step - self._step):
                self.drives.step()
        elif step > self._step:
            mujoco.mj_step(self.model, self.data, step - self._step)
        self._step = max(step, self._step)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self._step * self.options.dt_s

    # --- the robot's sensors

    def joints_rad(self) -> Array:
        """Return the twelve joint angles in encoder steps."""
        steps = np.round(self.true_joints_rad() / self._resolution_rad)
        return np.asarray(steps * self._resolution_rad)

    def _remember(self) -> None:
        """Keep attitude and velocity at the start of a control period, for the IMU's mean over it."""
        self._was_turned, self._was_moving = self.data.qpos[self._turn].copy(), self.data.qvel[self._velocity].copy()

    def motion(self) -> tuple[Vector, Vector]:
        """Return turning speed in rad/s and specific force in m/s2, body axes, mean over the last control period."""
        turned, rate, back, force = self.data.qpos[self._turn].copy(), np.zeros(3), np.zeros(4), np.zeros(3)
        mujoco.mju_subQuat(rate, turned, self._was_turned)
        velocity_change = (self.data.qvel[self._velocity] - self._was_moving) * self.rate_hz
        mujoco.mju_negQuat(back, turned)
        mujoco.mju_rotVecQuat(force, velocity_change + np.array([0, 0, GRAVITY_M_S2]), back)
        turn_x, turn_y, turn_z = (rate * self.rate_hz).tolist()
        force_x, force_y, force_z = force.tolist()
        return (turn_x, turn_y, turn_z), (force_x, force_y, force_z)

    # --- truth, for figures

    def true_joints_rad(self) -> Array:
        """Return the twelve joint angles as they are."""
        return self.joints.links(self.data.qpos, self.joints.q, self.joints.play_q)

    def joint_speeds_rad_s(self) -> Array:
        """Return the twelve joints' speeds."""
        return self.joints.links(self.data.qvel, self.joints.v, self.joints.play_v)

    def position_m(self) -> Array:
        """Return the middle of the hips."""
        return np.array(self.data.qpos[self._at])

    def turn(self) -> Array:
        """Return the body's attitude as a quaternion w, x, y, z."""
        return np.array(self.data.qpos[self._turn])

    def velocity(self) -> tuple[Array, Array]:
        """Return the body's velocity in the ground's axes, m/s, and its turning speed in its own, rad/s."""
        end = self._velocity.stop
        return np.array(self.data.qvel[self._velocity]), np.array(self.data.qvel[end : end + 3])

    def attitude_rad(self) -> tuple[float, float, float]:
        """Return roll, pitch and yaw, fixed axes (ROS)."""
        w, x, y, z = self.data.qpos[self._turn]
        roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
        return roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))

    def drive_torques_Nm(self) -> Array:
        """Return the torques of the twelve drives, each at its own shaft's joint: force less damping."""
        if self.drives is not None:
            return self.drives.torques_Nm()
        speeds = np.array(to_motor(self.robot, self.joint_speeds_rad_s().tolist()))
        damping = self.model.dof_damping[self.joints.v]
        if self.robot.calf_drive.coupled:
            damping[2::3] = self.model.tendon_damping
        return np.asarray(self.data.actuator_force - damping * speeds)

    def foot_loads_N(self) -> tuple[list[float], bool, float]:
        """Return the ground's push on each foot along its normal, whether the trunk touches, the deepest overlap."""
        loads, trunk, deepest = [0.0] * 4, False, 0.0
        contact = self.data.contact
        for i in range(self.data.ncon):
            kinds = self._kind[contact.geom[i]]
            kind = int(kinds.max())
            if contact.dist[i] > 0 or kinds.min() != _GROUND or kind < _TRUNK:
                continue
            trunk = trunk or kind == _TRUNK
            if kind >= _FOOT:
                deepest = max(deepest, -float(contact.dist[i]))
                row = int(contact.efc_address[i])
                loads[kind - _FOOT] += float(self.data.efc_force[row]) if row >= 0 else 0.0
        return loads, trunk, deepest


def _resolutions(robot: Robot) -> tuple[Array, Array | None]:
    """Return the steps of the measured joint angles and, for servos, of the goals, rad."""
    if isinstance(robot.actuator, Servo):
        step = robot.actuator.step_rad * np.array([1.0, 1.0, robot.calf_drive.ratio] * 4)
        return step, step
    return np.full(12, robot.actuator.step_rad), None
