"""The rotors behind the gears: inertia between two links, which a body's one moment can't hold.

A rotor of inertia J behind a gear of ratio N turns with the joint: its energy is A / 2 (link - carrier)^2, with the
links' turning speeds and the armature A = N^2 J, as MuJoCo has it. The carrier is the link that the motor is mounted
on. An armature that was the link's alone would have N times the rotor's momentum, and each swing of a leg would pitch
the torso with it.

So the matrix of inertia has -A between carrier and link. pymunk has its diagonal, and the mixed terms act as torques:
A times the acceleration of the other body. That is taken from the last sub-step, and from how the torques have changed
since. It settles within some sub-steps, held joints and feet or not, for the diagonal outweighs the mixed terms.
"""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
import pymunk

from .model import PLANAR_JOINTS, PlanarRobot

Array = npt.NDArray[np.float64]


class Rotors:
    """The rotors of a robot's eight drives; they add their armatures to the moments of its nine bodies (body.py).

    ``rows``: the bodies of carrier and link, and the armature in kg m2.
    """

    def __init__(self, robot: PlanarRobot, bodies: Sequence[pymunk.Body], dt_s: float) -> None:
        armatures = (robot.thigh_servo.armature_kgm2, robot.calf_servo.armature_kgm2)
        carriers = [joint if joint % 2 and not robot.calf_on_torso else 0 for joint in range(PLANAR_JOINTS)]
        rows = [(carrier, joint + 1, armatures[joint % 2]) for joint, carrier in enumerate(carriers)]
        self.rows = [row for row in rows if row[2] > 0]
        mixed = np.zeros((len(bodies), len(bodies)))
        for carrier, link, armature in self.rows:
            bodies[carrier].moment += armature
            bodies[link].moment += armature
            mixed[carrier, link] = mixed[link, carrier] = armature
        accelerations = np.linalg.inv(np.diag([body.moment for body in bodies]) - mixed)
        self._mixed = mixed @ np.hstack((accelerations, np.eye(len(bodies)) / dt_s))
        self.rest()

    def rest(self) -> None:
        """Forget how fast the bodies turned: they have been placed, or thrown."""
        self._before: Array | None = None

    def with_rotors(self, torque_Nm: list[float], turning_rad_s: list[float]) -> list[float]:
        """Return the torques on the bodies for the coming sub-step, with those of the rotors."""
        if not self.rows:
            return torque_Nm
        now = np.array(torque_Nm + turning_rad_s)
        if self._before is None:
            self._before = np.array([0.0] * len(torque_Nm) + turning_rad_s)
        torque: Array = now[: len(torque_Nm)] + self._mixed @ (now - self._before)
        self._before = now
        return torque.tolist()
