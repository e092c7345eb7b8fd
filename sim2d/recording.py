"""The recording of a run: one row per control tick, as numpy arrays in SI units.

A row is the instant the controller was asked: states before its answer, and the answer itself as the goal.
Legs FR, FL, RR, RL; joints hip, thigh, calf; the plane has no hips, so they repeat their goal and carry no
torque. A torque is what a drive gives at its own shaft: that of a calf's motor on the torso turns thigh + calf.
Angles about +y, pitch > 0 is nose down.
"""

import hashlib
import math
import struct
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from .actuator import Drives
from .model import CALF, HIP, JOINTS, THIGH
from .notes import Note
from .referee import Outcome
from .terrain import Terrain
from .world import BODY_FIELDS, ROBOT_BODIES, Contacts, World

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Aside:
    """The additional data of a walk in space: y to the left, and the torso's orientation."""

    torso_y_m: Array  # n
    attitude_rad: Array  # n x 3: roll, pitch, yaw about fixed axes
    leg_y_m: Array  # n x 4 x 3: thigh joint, knee, foot


def rotations(attitude_rad: Array) -> Array:
    """Return the rotations, (n, 3, 3), from a body's axes to the world's."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude_rad).T, np.sin(attitude_rad).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(rows).transpose(2, 0, 1)


@dataclass(frozen=True)
class Recording:
    """A finished run, in the plane or in space (``aside``). Shapes: n rows, 4 legs, 12 joints, 2 = (x, z).

    Stones are as in ``terrain.loose``; a walk in space has none, for those lie nowhere in the plane.

    ``stone_turn_rad`` is how far a loose stone has turned counter-clockwise from its corners' first position.
    """

    time_s: Array
    torso_x_m: Array
    torso_z_m: Array
    torso_pitch_rad: Array
    joint_rad: Array
    joint_speed_rad_s: Array
    goal_rad: Array
    torque_Nm: Array
    hip_xz_m: Array
    knee_xz_m: Array
    foot_xz_m: Array
    foot_force_N: Array
    contact: Flags
    joint_opening_m: Array
    penetration_m: Array
    stone_xz_m: Array
    stone_turn_rad: Array
    stall_Nm: Array
    foot_radius_m: float
    terrain: Terrain
    outcome: Outcome
    real_time_factor: float
    notes: tuple[Note, ...] = ()
    aside: Aside | None = None

    def digest(self) -> str:
        """SHA-256 of every array's name and bytes: equal for equal runs on the same machine."""
        sha = hashlib.sha256()
        for part in (self,) if self.aside is None else (self, self.aside):
            for item in fields(part):
                value = getattr(part, item.name)
                if isinstance(value, np.ndarray):
                    sha.update(item.name.encode() + np.ascontiguousarray(value).tobytes())
        return sha.hexdigest()


class Log:
    """Gathers raw rows during a run, as cheaply as it can, and turns them into a Recording at its end."""

    def __init__(self, world: World, drives: Drives) -> None:
        self._world, self._drives = world, drives
        self._origin_x_m, self._origin_z_m = world.parts.torso_origin_m
        self._times: list[float] = []
        self._states: list[bytes] = []
        self._contacts: list[Contacts] = []
        self._goals: list[list[float]] = []
        self._torques: list[list[float]] = []

    def torso_of(self, state: bytes) -> tuple[float, float]:
        """Return x of the middle of the hips and the pitch from a raw state."""
        x, _, angle = struct.unpack_from("3d", state)
        return x + math.cos(angle) * self._origin_x_m - math.sin(angle) * self._origin_z_m, -angle

    def add(self, time_s: float, state: bytes, contacts: Contacts, goals_rad: list[float]) -> None:
        """Keep one tick."""
        self._times.append(time_s)
        self._states.append(state)
        self._contacts.append(contacts)
        self._goals.append(goals_rad)
        self._torques.append(list(self._drives.given_Nm))

    def close(self, outcome: Outcome, wall_s: float) -> Recording:
        """Return the recording; ``wall_s`` is the wall-clock time of the ticks."""
        world, parts = self._world, self._world.parts
        everything = np.frombuffer(b"".join(self._states)).reshape(len(self._states), -1, BODY_FIELDS)
        state, loose = everything[:, :ROBOT_BODIES], everything[:, ROBOT_BODIES:]
        goals = np.array(self._goals)
        torso, thighs, calves = state[:, 0:1], state[:, 1::2], state[:, 2::2]
        origin = _points(torso, (parts.torso_origin_m,))[:, 0]
        hips = _points(torso, parts.hip_anchor_m)
        knees = _points(thighs, (parts.thigh_knee_m,))
        simulated_s = self._times[-1] - self._times[0]
        return Recording(
            time_s=np.array(self._times),
            torso_x_m=origin[:, 0],
            torso_z_m=origin[:, 1],
            torso_pitch_rad=-state[:, 0, 2],
            joint_rad=_twelve(state[:, :, 2], goals[:, HIP::3]),
            joint_speed_rad_s=_twelve(state[:, :, 5], np.zeros((len(goals), 4))),
            goal_rad=goals,
            torque_Nm=_spread(np.array(self._torques)),
            hip_xz_m=hips,
            knee_xz_m=knees,
            foot_xz_m=_points(calves, (parts.calf_foot_m,)),
            foot_force_N=np.array([c.foot_force_N for c in self._contacts]),
            contact=np.array([c.foot_touches for c in self._contacts]),
            joint_opening_m=np.maximum(
                _largest(hips - _points(thighs, (parts.thigh_top_m,))),
                _largest(knees - _points(calves, (parts.calf_knee_m,))),
            ),
            penetration_m=np.array([c.penetration_m for c in self._contacts]),
            stone_xz_m=loose[:, :, 0:2].copy(),
            stone_turn_rad=loose[:, :, 2].copy(),
            stall_Nm=_spread(np.array([self._drives.limit_Nm]))[0],
            foot_radius_m=world.robot.foot_radius_m,
            terrain=world.terrain,
            outcome=outcome,
            real_time_factor=simulated_s / wall_s if wall_s > 0 else 0.0,
        )


def _points(bodies: Array, anchors_m: tuple[tuple[float, float], ...]) -> Array:
    """World points (n, legs, 2) of local anchors on bodies (n, bodies, fields); one of either may be shared."""
    anchors = np.array(anchors_m)
    x, z, angle = bodies[:, :, 0], bodies[:, :, 1], bodies[:, :, 2]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack(
        [x + cos * anchors[:, 0] - sin * anchors[:, 1], z + sin * anchors[:, 0] + cos * anchors[:, 1]], axis=2
    )


def _largest(offsets_m: Array) -> Array:
    """Longest of each row's offsets (n, legs, 2)."""
    return np.hypot(offsets_m[:, :, 0], offsets_m[:, :, 1]).max(axis=1)


def _twelve(turned: Array, hips: Array) -> Array:
    """Joint values (n, 12) from bodies' pymunk angles or turn rates (n, 9), and hips (n, 4)."""
    result = np.empty((len(turned), JOINTS))
    result[:, HIP::3] = hips
    result[:, THIGH::3] = turned[:, 0:1] - turned[:, 1::2]
    result[:, CALF::3] = turned[:, 1::2] - turned[:, 2::2]
    return result


def _spread(planar: Array) -> Array:
    """Planar values (n, 8) at their places among twelve, hips 0."""
    result = np.zeros((len(planar), JOINTS))
    result[:, THIGH::3] = planar[:, 0::2]
    result[:, CALF::3] = planar[:, 1::2]
    return result
