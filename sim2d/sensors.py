"""The controller's sensors: joint encoders, attitude, accelerometer, with their errors."""

import math
import random
import struct
from collections.abc import Sequence
from dataclasses import dataclass

from .body import all_joints
from .model import GRAVITY_M_S2
from .world import World


@dataclass(frozen=True)
class Sensed:
    """The sensed values of one tick. Angles about +y: pitch > 0 is nose down. The plane has no roll.

    ``specific_force_m_s2`` is what an accelerometer at the torso's centre of mass reads, body x and z, mean
    over the last tick: (0, +9.81) at rest. Hip joints report their goal.
    """

    time_s: float
    joint_position_rad: Sequence[float]
    joint_speed_rad_s: Sequence[float]
    roll_rad: float
    pitch_rad: float
    pitch_rate_rad_s: float
    specific_force_m_s2: tuple[float, float]


class Sensors:
    """Reads a world as the robot's sensors would, with its encoder steps and seeded noise."""

    def __init__(self, world: World, seed: int) -> None:
        self._world, self._model = world, world.robot.sensors
        self._random = random.Random(f"sensors {seed}")
        self._last_velocity: tuple[float, float] | None = None
        self._last_steps = 0

    def read(self, state: bytes, hips_rad: Sequence[float], time_s: float) -> Sensed:
        """Return the sensed values for the bodies' ``state`` (see World.state)."""
        _, _, angle, vx, vz, turn = struct.unpack_from("6d", state)
        world = self._world
        return Sensed(
            time_s=time_s,
            joint_position_rad=[self._encoded(q) for q in all_joints(world.position_rad, hips_rad)],
            joint_speed_rad_s=all_joints(world.speed_rad_s, (0.0,) * 4),
            roll_rad=0.0,
            pitch_rad=-angle + self._noise(self._model.pitch_noise_rad),
            pitch_rate_rad_s=-turn,
            specific_force_m_s2=self._specific_force(angle, vx, vz),
        )

    def _specific_force(self, angle: float, vx: float, vz: float) -> tuple[float, float]:
        """Mean acceleration since the last reading minus gravity, in body axes (pymunk's ``angle``)."""
        seconds = (self._world.steps - self._last_steps) * self._world.dt_s
        ax = az = 0.0
        if self._last_velocity is not None and seconds > 0:
            ax = (vx - self._last_velocity[0]) / seconds
            az = (vz - self._last_velocity[1]) / seconds
        self._last_velocity, self._last_steps = (vx, vz), self._world.steps
        az += GRAVITY_M_S2
        cos, sin = math.cos(angle), math.sin(angle)
        return cos * ax + sin * az, -sin * ax + cos * az

    def _encoded(self, angle_rad: float) -> float:
        counts = self._model.encoder_counts_per_turn
        return round(angle_rad * counts / math.tau) * math.tau / counts if counts else angle_rad

    def _noise(self, sigma: float) -> float:
        return self._random.gauss(0.0, sigma) if sigma > 0 else 0.0
