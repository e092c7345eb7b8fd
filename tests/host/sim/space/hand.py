"""A hand that holds the robot's trunk: a spring and a damper to where the hand is, strong enough to carry it."""

import mujoco
import numpy as np

from host.sim.space.world import World
from sim2d.model import GRAVITY_M_S2

_HOLD_RAD_S = 12.0  # how stiff the hand is, as the frequency of a robot that hangs in it (assumed)
_LIFTS_M_S = 0.3  # (assumed)
_WITH_LEGS = 2.0  # times the trunk's moments of inertia: the inertia that the hand turns (assumed)


class Hand:
    """Holds the trunk at a place and attitude from where it is now; ``hold`` is to be called every control period."""

    def __init__(self, world: World) -> None:
        self._world, self._mass_kg = world, float(world.model.body_subtreemass[world.trunk])
        self._inertia_kg_m2 = _WITH_LEGS * world.model.body_inertia[world.trunk]
        self._place_m, self._turn = world.position_m(), world.turn()

    def hold(self, up_m: float, roll_rad: float = 0.0) -> None:
        """Pull towards so far above where it took the trunk, turned about x by so much more."""
        data, trunk, world, damping = self._world.data, self._world.trunk, self._world, 2 * _HOLD_RAD_S
        speed_m_s, rate_rad_s = world.velocity()
        off_m = self._place_m + np.array([0.0, 0.0, up_m]) - world.position_m()
        force = self._mass_kg * (_HOLD_RAD_S**2 * off_m - damping * speed_m_s)
        force[2] += self._mass_kg * GRAVITY_M_S2
        wanted, off_rad = np.zeros(4), np.zeros(3)
        mujoco.mju_mulQuat(wanted, self._turn, np.array([np.cos(roll_rad / 2), np.sin(roll_rad / 2), 0.0, 0.0]))
        mujoco.mju_subQuat(off_rad, wanted, world.turn())
        torque = self._inertia_kg_m2 * (_HOLD_RAD_S**2 * off_rad - damping * rate_rad_s)  # in the body's axes
        mujoco.mju_rotVecQuat(torque, torque, world.turn())
        data.xfrc_applied[trunk] = np.concatenate((force, torque))

    def let_go(self) -> None:
        """Hold it no longer."""
        self._world.data.xfrc_applied[self._world.trunk] = 0.0


def lifted_m(time_s: float, height_m: float, seconds: float) -> float:
    """Return how high a hand is that lifts by a height, and puts down so that it is back after ``seconds``."""
    return max(0.0, min(height_m, _LIFTS_M_S * time_s, _LIFTS_M_S * (seconds - time_s)))
