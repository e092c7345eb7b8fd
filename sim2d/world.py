"""One robot on one ground in a pymunk space, advanced in sub-steps: the only file that steps the physics.

Two thirds of a naive run are attribute accesses, so the joint states of a sub-step are read, and the torques
written, with one pymunk.batch call each. Settings, with what each is for:

* SI units, y up, ``collision_slop`` 0.1 mm (the default of 0.1 m would never correct a penetration here);
* ``damping`` 1.0: no air drag; 30 iterations; pins close 20 % of their error per sub-step at any dt;
* servo torques are explicit, end stops are springs on the position one sub-step ahead: pymunk moves with the
  old speed before it applies a torque, and a spring on the old position would gain energy. They brake too, and
  never more than stops the links: a robot that lies limp on its stops comes to rest.
"""

import itertools
import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pymunk
from pymunk import batch

from . import body
from .actuator import Actuator, CalfOnTorso, PositionServos
from .model import GRAVITY_M_S2, PLANAR_JOINTS, PlanarRobot, least_inertia_kgm2
from .rotors import Rotors
from .terrain import Terrain

ITERATIONS = 30
COLLISION_SLOP_M = 1e-4
# Share of an error that one sub-step leaves: joints (pins), contacts.
_JOINT_ERROR_LEFT = 0.8
_CONTACT_ERROR_LEFT = 0.9
# A contact belongs to the foot when it is this close to the foot's circle.
_FOOT_MARGIN_M = 1.5e-3
MAX_DT_S = 0.002

# Per body: x, z, angle, vx, vz, angular speed; both angles counter-clockwise, as pymunk has them.
BODY_FIELDS = 6
ROBOT_BODIES = 1 + PLANAR_JOINTS

_ANGLES = batch.BodyFields.ANGLE | batch.BodyFields.ANGULAR_VELOCITY
_STATE = batch.BodyFields.POSITION | batch.BodyFields.VELOCITY | _ANGLES
_TORQUE = batch.BodyFields.TORQUE
_CONTACT = (
    batch.ArbiterFields.BODY_A_ID
    | batch.ArbiterFields.BODY_B_ID
    | batch.ArbiterFields.CONTACT_COUNT
    | batch.ArbiterFields.TOTAL_IMPULSE
    | batch.ArbiterFields.POINT_A_1
    | batch.ArbiterFields.DISTANCE_1
)


@dataclass(frozen=True)
class Contacts:
    """What touches at one instant: force of the ground on each foot (x, z), the torso, the deepest overlap."""

    foot_force_N: tuple[tuple[float, float], ...]
    foot_touches: tuple[bool, ...]
    torso_touches: bool
    penetration_m: float


class World:
    """The plane. ``position_rad``, ``speed_rad_s`` and ``torque_Nm`` hold the last sub-step's eight joints.

    ``servos`` are the robot's own drives, which move it unless ``actuator`` does.
    """

    def __init__(
        self,
        robot: PlanarRobot,
        terrain: Terrain,
        *,
        payload_kg: float = 0.0,
        supply_voltage_V: float | None = None,
        actuator: Actuator | None = None,
        dt_s: float = 0.001,
    ) -> None:
        if not 0 < dt_s <= MAX_DT_S:
            raise ValueError(f"dt_s = {dt_s}: allowed above 0 and up to {MAX_DT_S}, where the servos stay accurate")
        voltage_V = robot.thigh_servo.nominal_voltage_V if supply_voltage_V is None else supply_voltage_V
        if actuator is None:
            _check_stable(robot, voltage_V, dt_s)
        self.robot, self.terrain, self.dt_s = robot, terrain, dt_s
        self.steps = 0
        self.space = _space(dt_s)
        self.parts = body.build(self.space, robot, payload_kg, _JOINT_ERROR_LEFT ** (1 / dt_s))
        self.rotors = Rotors(robot, self.parts.bodies, dt_s)
        _add_ground(self.space, terrain)
        thigh, calf = robot.thigh_servo.at_voltage(voltage_V), robot.calf_servo.at_voltage(voltage_V)
        self.servos = PositionServos([thigh, calf] * 4)
        motors: Actuator = self.servos if actuator is None else actuator
        self._actuator: Actuator = CalfOnTorso(motors) if robot.calf_on_torso else motors
        self._stops = _end_stops(robot, self.parts.bodies, dt_s)
        self._moving = ROBOT_BODIES + len(terrain.loose)
        self.position_rad = [0.0] * PLANAR_JOINTS
        self.speed_rad_s = [0.0] * PLANAR_JOINTS
        self.torque_Nm = [0.0] * PLANAR_JOINTS
        self._turning_rad_s = [0.0] * ROBOT_BODIES
        self._read, self._write, self._touch = batch.Buffer(), batch.Buffer(), batch.Buffer()
        self._torque_mem = bytearray(8 * _count_bodies(self.space, self.parts.bodies))
        self._write.set_float_buf(self._torque_mem)
        self._body_index = {part.id: i for i, part in enumerate(self.parts.bodies)}
        self._angles = struct.Struct(f"{2 * ROBOT_BODIES}d")
        self._torques = struct.Struct(f"{ROBOT_BODIES}d")

    @property
    def time_s(self) -> float:
        """Simulated time since the robot was placed."""
        return self.steps * self.dt_s

    def place(self, pose_rad: Sequence[float], x_m: float = 0.0, pitch_rad: float = 0.0, lift_m: float = 0.0) -> None:
        """Put the robot at rest in a pose of twelve angles, its lowest part on the ground (``lift_m`` above)."""
        body.place(self.parts, self.robot, pose_rad, x_m, 0.0, pitch_rad)
        boxes = [shape.cache_bb() for part in self.parts.bodies for shape in part.shapes]
        z_m = max(self.terrain.highest_m(box.left, box.right) - box.bottom for box in boxes)
        body.place(self.parts, self.robot, pose_rad, x_m, z_m + lift_m, pitch_rad)
        for part in self.parts.bodies:
            self.space.reindex_shapes_for_body(part)
        self.steps = 0
        self.rotors.rest()
        self._read_joints()

    def pin_torso(self) -> None:
        """Hold the torso where it is, as on a stand: position and pitch."""
        torso, ground = self.parts.bodies[0], self.space.static_body
        pin = pymunk.PivotJoint(ground, torso, (torso.position.x, torso.position.y))
        turn = pymunk.GearJoint(ground, torso, torso.angle, 1.0)
        pin.error_bias = turn.error_bias = _JOINT_ERROR_LEFT ** (1 / self.dt_s)
        self.space.add(pin, turn)

    def advance(self, goal_rad: Sequence[float], steps: int) -> None:
        """Run ``steps`` sub-steps towards eight planar goals (thigh and calf of FR, FL, RR, RL)."""
        dt_s, step, drive = self.dt_s, self.space.step, self._actuator.torques
        position, speed, torque = self.position_rad, self.speed_rad_s, self.torque_Nm
        with np.errstate(over="ignore", invalid="ignore"):  # run.py refuses what is no number
            for _ in range(steps):
                self._read_joints()
                drive(goal_rad, position, speed, dt_s, torque)
                self._apply_torques()
                step(dt_s)
        self.steps += steps

    def _read_joints(self) -> None:
        """Joint angles and speeds from the bodies': parent's minus child's, as pymunk turns the other way."""
        buffer = self._read
        buffer.clear()
        batch.get_space_bodies(self.space, _ANGLES, buffer)
        (a0, w0, a1, w1, a2, w2, a3, w3, a4, w4, a5, w5, a6, w6, a7, w7, a8, w8) = self._angles.unpack_from(
            buffer.float_buf()
        )
        self.position_rad[:] = (a0 - a1, a1 - a2, a0 - a3, a3 - a4, a0 - a5, a5 - a6, a0 - a7, a7 - a8)
        self._turning_rad_s[:] = (w0, w1, w2, w3, w4, w5, w6, w7, w8)
        self.speed_rad_s[:] = (w0 - w1, w1 - w2, w0 - w3, w3 - w4, w0 - w5, w5 - w6, w0 - w7, w7 - w8)

    def _apply_torques(self) -> None:
        """Joint torques and end stops on both bodies of every joint (a joint torque is about +y), and the rotors."""
        t = self.torque_Nm.copy()
        dt_s = self.dt_s
        for i, low, high, stiffness, braking in self._stops:
            ahead = self.position_rad[i] + self.speed_rad_s[i] * dt_s
            if ahead < low:
                t[i] += max(0.0, stiffness * (low - ahead) - braking * self.speed_rad_s[i])
            elif ahead > high:
                t[i] += min(0.0, stiffness * (high - ahead) - braking * self.speed_rad_s[i])
        t0, t1, t2, t3, t4, t5, t6, t7 = t
        on_bodies = [t0 + t2 + t4 + t6, t1 - t0, -t1, t3 - t2, -t3, t5 - t4, -t5, t7 - t6, -t7]
        self._torques.pack_into(self._torque_mem, 0, *self.rotors.with_rotors(on_bodies, self._turning_rad_s))
        batch.set_space_bodies(self.space, _TORQUE, self._write)

    def state(self) -> bytes:
        """All moving bodies now, the robot's nine, then loose stones: BODY_FIELDS doubles each, pymunk's sense."""
        self._read.clear()
        batch.get_space_bodies(self.space, _STATE, self._read)
        return bytes(self._read.float_buf()[: 8 * BODY_FIELDS * self._moving])

    def contacts(self) -> Contacts:
        """Forces and overlaps of the last sub-step. Sums are exact: the order of contacts is that of the memory."""
        buffer = self._touch
        buffer.clear()
        batch.get_space_arbiters(self.space, _CONTACT, buffer)
        ints = memoryview(buffer.int_buf()).cast("B").cast("P")
        floats = memoryview(buffer.float_buf()).cast("B").cast("d")
        pushes: list[list[tuple[float, float]]] = [[] for _ in range(4)]
        torso, deepest = False, 0.0
        for k in range(len(ints) // 3):
            body_a, body_b, count = ints[3 * k : 3 * k + 3]
            index = self._body_index.get(body_a, self._body_index.get(body_b))
            if index is None or count == 0:
                continue
            push_x, push_z, x, z, distance = floats[5 * k : 5 * k + 5]
            deepest = max(deepest, -distance)
            torso = torso or index == 0
            leg = (index - 1) // 2
            if index > 0 and index % 2 == 0 and self._near_foot(leg, x, z):
                sign = 1.0 if body_a in self._body_index else -1.0
                pushes[leg].append((sign * push_x / self.dt_s, sign * push_z / self.dt_s))
        force = tuple((math.fsum(x for x, _ in foot), math.fsum(z for _, z in foot)) for foot in pushes)
        return Contacts(force, tuple(bool(foot) for foot in pushes), torso, deepest)

    def _near_foot(self, leg: int, x_m: float, z_m: float) -> bool:
        foot = self.parts.bodies[2 + 2 * leg].local_to_world(self.parts.calf_foot_m)
        return math.hypot(foot[0] - x_m, foot[1] - z_m) < self.robot.foot_radius_m + _FOOT_MARGIN_M


def _space(dt_s: float) -> pymunk.Space:
    space = pymunk.Space()
    space.gravity = (0.0, -GRAVITY_M_S2)
    space.iterations = ITERATIONS
    space.damping = 1.0
    space.collision_slop = COLLISION_SLOP_M
    space.collision_bias = _CONTACT_ERROR_LEFT ** (1 / dt_s)
    return space


def _count_bodies(space: pymunk.Space, first: Sequence[pymunk.Body]) -> int:
    """How many bodies a batch call visits: the robot's, loose stones, and at last pymunk's own static one.

    Torques are written by position in that order, so the order is checked.
    """
    buffer = batch.Buffer()
    batch.get_space_bodies(space, batch.BodyFields.BODY_ID, buffer)
    visited = list(memoryview(buffer.int_buf()).cast("B").cast("P"))
    if visited[: len(first)] != [part.id for part in first]:
        raise RuntimeError("pymunk visits the bodies in another order than they were added: torques would be mixed up")
    return len(visited)


def _check_stable(robot: PlanarRobot, supply_voltage_V: float, dt_s: float) -> None:
    """Refuse servos whose damping is too strong for the sub-step and the inertia they turn."""
    for name, link, servo in (("thigh", robot.thigh, robot.thigh_servo), ("calf", robot.calf, robot.calf_servo)):
        inertia = link.inertia_kgm2 + servo.armature_kgm2
        longest_s = inertia / least_inertia_kgm2(servo.at_voltage(supply_voltage_V).damping_Nms_rad, 1.0)
        if dt_s > longest_s:
            raise ValueError(
                f"{robot.name}: dt_s = {dt_s:g} is too long for the {name} servo's damping and armature:"
                f" at most {longest_s:.2g} s"
            )


def _end_stops(
    robot: PlanarRobot, bodies: Sequence[pymunk.Body], dt_s: float
) -> list[tuple[int, float, float, float, float]]:
    """Rows (planar joint, low, high, stiffness, braking), the braking such that a sub-step stops at most both links."""
    limits = (robot.thigh_limits_rad, robot.calf_limits_rad)
    stiffness, braking = robot.end_stop_Nm_rad, robot.end_stop_Nms_rad
    rows = []
    for i in range(PLANAR_JOINTS):
        parent, child = bodies[i if i % 2 else 0], bodies[i + 1]
        gives_1_kgm2 = 1 / parent.moment + 1 / child.moment
        rows.append((i, *limits[i % 2], stiffness, braking / (1 + braking * dt_s * gives_1_kgm2)))
    return rows


def _add_ground(space: pymunk.Space, terrain: Terrain) -> None:
    """The polyline as static segments that know their neighbours, and the loose stones as bodies."""
    points = terrain.points_m
    for i, (start, end) in enumerate(itertools.pairwise(points)):
        if start == end:
            continue
        segment = pymunk.Segment(space.static_body, start, end, 0.0)
        segment.set_neighbors(points[max(i - 1, 0)], points[min(i + 2, len(points) - 1)])
        segment.friction = 1.0  # so the foot's own decides: Chipmunk multiplies
        space.add(segment)
    for stone in terrain.loose:
        shape = pymunk.Poly(None, list(stone.corners_m))
        area_m2 = shape.area
        mass_kg = stone.density_kg_m2 * area_m2
        pebble = pymunk.Body(mass_kg, pymunk.moment_for_poly(mass_kg, list(stone.corners_m)))
        pebble.position = (stone.x_m, stone.z_m)
        shape.body = pebble
        shape.friction = 1.0
        space.add(pebble, shape)
