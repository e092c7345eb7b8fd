"""The body behind simulated joints: the sagittal plane with its drives, hips as twelve-joint extras, a simulated IMU.

``Plant`` holds every joint's commands (goal, on or off, torque limit) and its state (angle, speed, load). It advances
only on demand, by simulated time, so the same calls give the same motion.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import copysign
from typing import TYPE_CHECKING

from sim2d.actuator import Actuator, Given, Told
from sim2d.model import GRAVITY_M_S2, PLANAR_INDEX, PLANAR_JOINTS, PlanarRobot, ServoModel

from ..bus.base import JOINTS
from ..robot.model import Robot
from ..robot.plane import planar_robot
from ..util.errors import UserError
from .imu import Motion
from .servos.plane import honest_servos

if TYPE_CHECKING:
    from sim2d.sensors import Sensed

DT_S = 0.001
LONGEST_STEP_S = 0.25  # a paused program must not make up for an hour of physics


@dataclass
class Drives:
    """The joints' commands, twelve of each, and the share of stall torque that each gives."""

    goal_rad: list[float]
    on: list[bool] = field(default_factory=lambda: [False] * JOINTS)
    limit: list[float] = field(default_factory=lambda: [1.0] * JOINTS)
    load: list[float] = field(default_factory=lambda: [0.0] * JOINTS)


def servo_torque_Nm(
    model: ServoModel, drives: Drives, joint: int, goal_rad: float, position_rad: float, speed_rad_s: float
) -> float:
    """Return a servo's torque: stall x clip(duty) - damping x speed, the duty within its limit; 0 if it is off.

    Keeps its duty in ``drives.load``, as the servo's own load register does.
    """
    if not drives.on[joint]:
        drives.load[joint] = 0.0
        return 0.0
    most = drives.limit[joint]
    duty = model.stiffness_Nm_rad * (goal_rad - position_rad) / model.stall_torque_Nm
    duty = max(-most, min(most, duty))
    drives.load[joint] = duty
    return duty * model.stall_torque_Nm - model.damping_Nms_rad * speed_rad_s


class SwitchedServos:
    """sim2d's eight drives, each of which can be off or limited (see sim2d.actuator.Actuator)."""

    def __init__(self, models: Sequence[ServoModel], drives: Drives) -> None:
        self._rows = list(zip(range(PLANAR_JOINTS), PLANAR_INDEX, models, strict=True))
        self._drives = drives

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See Actuator; in motor angles where calves are coupled."""
        for i, joint, model in self._rows:
            torque_Nm[i] = servo_torque_Nm(model, self._drives, joint, goal_rad[i], position_rad[i], speed_rad_s[i])


@dataclass
class Hinge:
    """A joint alone: a servo, the inertia it turns, dry friction, end stops."""

    model: ServoModel
    inertia_kg_m2: float
    limits_rad: tuple[float, float]
    position_rad: float = 0.0
    speed_rad_s: float = 0.0

    def driven(self, drives: Drives, joint: int, dt_s: float) -> None:
        """Advance by one sub-step with the joint's own servo."""
        goal_rad = drives.goal_rad[joint]
        self.step(servo_torque_Nm(self.model, drives, joint, goal_rad, self.position_rad, self.speed_rad_s), dt_s)

    def step(self, torque_Nm: float, dt_s: float) -> None:
        """Advance by one sub-step: torque, then friction that can only brake, then the stops."""
        speed = self.speed_rad_s + torque_Nm / self.inertia_kg_m2 * dt_s
        braked = abs(speed) - self.model.coulomb_Nm / self.inertia_kg_m2 * dt_s
        speed = copysign(max(0.0, braked), speed)
        low, high = self.limits_rad
        position = self.position_rad + speed * dt_s
        self.position_rad = min(max(position, low), high)
        self.speed_rad_s = speed if self.position_rad == position else 0.0


class Plant(ABC):
    """Twelve joints and a body. ``position_rad`` and ``speed_rad_s`` hold the present; ``drives`` the commands."""

    @property
    def supply_V(self) -> float | None:
        """The supply voltage that the joints measure; None if the plant has none."""
        return None

    def __init__(self, robot: Robot, pose_rad: Sequence[float]) -> None:
        self.robot = robot
        self.time_s = 0.0
        self.drives = Drives(list(pose_rad))
        self.position_rad = list(pose_rad)
        self.speed_rad_s = [0.0] * JOINTS

    def advance_to(self, time_s: float) -> None:
        """Run up to a time in s since the start, in whole sub-steps; an older time does nothing."""
        steps = int((time_s - self.time_s) / DT_S + 1e-6)
        if steps > LONGEST_STEP_S / DT_S:
            self.time_s = time_s - LONGEST_STEP_S
            steps = round(LONGEST_STEP_S / DT_S)
        if steps > 0:
            self._run(steps)
            self.time_s += steps * DT_S

    def push(self, joint: int, angle_rad: float) -> None:
        """Turn one joint by hand, which only works while it is off, and on a bench."""
        raise UserError(f"joint {joint}: can't be turned by hand while the robot stands; lift it, or use a bench")

    @abstractmethod
    def put_back(self) -> None:
        """Lift the robot and put it down as it was at the start."""

    def inertial(self) -> Motion:
        """Return turning speed (rad/s) and specific force (m/s2) in body axes, mean since the last call."""
        return (0.0, 0.0, 0.0), (0.0, 0.0, GRAVITY_M_S2)

    def pose(self) -> tuple[float, float, float]:
        """Return where the body is, x and y in m, and its yaw, rad."""
        return 0.0, 0.0, 0.0

    @abstractmethod
    def _run(self, steps: int) -> None:
        """Advance by so many sub-steps."""


def joint_models(robot: Robot) -> list[ServoModel]:
    """Return the drives' models of all twelve joints; hip and thigh are alike."""
    flat = planar_robot(robot)
    return [flat.thigh_servo, flat.thigh_servo, flat.calf_servo] * 4


def hinges(robot: Robot, pose_rad: Sequence[float]) -> list[Hinge]:
    """Return the joints as if each were alone, with its load: its own link and those below, hanging straight."""
    links, geometry = robot.links, robot.geometry
    calf = links.calf.inertia_kg_m2[1] + links.calf.mass_kg * (geometry.calf_m / 2) ** 2
    thigh = links.thigh.inertia_kg_m2[1] + links.calf.mass_kg * geometry.thigh_m**2 + calf
    turned = (thigh + links.hip.inertia_kg_m2[0], thigh, calf)
    models = joint_models(robot)
    limits = [robot.joint_limits_rad(leg)[joint] for leg in range(4) for joint in range(3)]
    return [
        Hinge(model, turned[joint % 3] + model.armature_kgm2, limits[joint], pose_rad[joint])
        for joint, model in enumerate(models)
    ]


class JointPlant(Plant):
    """Twelve joints in the air, each alone: for the bench, where there is no ground."""

    def __init__(self, robot: Robot, pose_rad: Sequence[float]) -> None:
        super().__init__(robot, pose_rad)
        self._pose_rad = tuple(pose_rad)
        self._hinges = hinges(robot, pose_rad)

    def put_back(self) -> None:
        """See Plant."""
        self._hinges = hinges(self.robot, self._pose_rad)
        self.position_rad[:], self.speed_rad_s[:] = self._pose_rad, [0.0] * JOINTS

    def push(self, joint: int, angle_rad: float) -> None:
        """See Plant; the hand stops where the joint does."""
        if not self.drives.on[joint]:
            low, high = self._hinges[joint].limits_rad
            self._hinges[joint].position_rad = self.position_rad[joint] = min(max(angle_rad, low), high)

    def _run(self, steps: int) -> None:
        for joint, hinge in enumerate(self._hinges):
            for _ in range(steps):
                hinge.driven(self.drives, joint, DT_S)
            self.position_rad[joint], self.speed_rad_s[joint] = hinge.position_rad, hinge.speed_rad_s


class PlaneBody:
    """A robot on flat ground in the sagittal plane, moved by ``motors``; its hips are hinges the plane knows not."""

    def __init__(
        self, robot: Robot, pose_rad: Sequence[float], motors: Actuator, seed: int, plane: PlanarRobot | None = None
    ) -> None:
        from sim2d.run import clamped
        from sim2d.sensors import Sensors
        from sim2d.terrain import flat
        from sim2d.world import World

        plane = plane or planar_robot(robot)
        self.world = World(plane, flat(), actuator=motors, dt_s=DT_S)
        self.robot, self._pose_rad, self._start = robot, tuple(pose_rad), clamped(plane, pose_rad)
        self.position_rad, self.speed_rad_s = list(pose_rad), [0.0] * JOINTS
        self.put_back()
        self._sensors = Sensors(self.world, seed)

    def put_back(self) -> None:
        """Put the robot down as it was at the start."""
        self.world.place(self._start)
        self._hinges = hinges(self.robot, self._pose_rad)[0::3]
        self.position_rad[:], self.speed_rad_s[:] = self._pose_rad, [0.0] * JOINTS

    def sensed(self, time_s: float) -> "Sensed":
        """Return the readings of sensors on the body."""
        return self._sensors.read(self.world.state(), [0.0] * 4, time_s)

    def run(self, goal_rad: Sequence[float], steps: int, turn: Callable[[int, Hinge], None]) -> None:
        """Advance by so many sub-steps towards twelve goals; ``turn`` moves a hip, by its joint, one sub-step."""
        self.world.advance([goal_rad[joint] for joint in PLANAR_INDEX], steps)
        for i, joint in enumerate(PLANAR_INDEX):
            self.position_rad[joint], self.speed_rad_s[joint] = self.world.position_rad[i], self.world.speed_rad_s[i]
        for joint, hinge in zip(range(0, JOINTS, 3), self._hinges, strict=True):
            for _ in range(steps):
                turn(joint, hinge)
            self.position_rad[joint], self.speed_rad_s[joint] = hinge.position_rad, hinge.speed_rad_s


class PlanePlant(Plant):
    """A robot on flat ground in the sagittal plane."""

    def __init__(self, robot: Robot, pose_rad: Sequence[float], seed: int = 0) -> None:
        super().__init__(robot, pose_rad)
        models, (plane, self._servos) = joint_models(robot), honest_servos(robot, planar_robot(robot), None)
        simple = SwitchedServos([models[i] for i in PLANAR_INDEX], self.drives)
        self._body = PlaneBody(robot, pose_rad, self._servos or simple, seed, plane)
        self.world, self.position_rad, self.speed_rad_s = (
            self._body.world, self._body.position_rad, self._body.speed_rad_s)

    def pose(self) -> tuple[float, float, float]:
        """See Plant."""
        return float(self.world.parts.bodies[0].position.x), 0.0, 0.0

    def put_back(self) -> None:
        """See Plant."""
        if self._servos:
            self._servos.put_back()
        self._body.put_back()

    def inertial(self) -> Motion:
        """See Plant; the plane turns about y only."""
        sensed = self._body.sensed(self.time_s)
        force_x, force_z = sensed.specific_force_m_s2
        return (0.0, sensed.pitch_rate_rad_s, 0.0), (force_x, 0.0, force_z)

    def _run(self, steps: int) -> None:
        drives, servos = self.drives, self._servos
        if servos:
            servos.most[:] = [drives.limit[joint] if drives.on[joint] else None for joint in PLANAR_INDEX]
        self._body.run(drives.goal_rad, steps, lambda joint, hinge: hinge.driven(drives, joint, DT_S))
        if servos:
            for joint, law in zip(PLANAR_INDEX, servos.laws, strict=True):
                drives.load[joint] = law.duty
