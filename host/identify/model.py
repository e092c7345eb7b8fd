"""The fit's servo model: many copies with different numbers through many sweeps at once, in numpy.

The law is that of host/sim/servos/law.py, and a test compares the two: rotor and link with play between them, M6
friction (arXiv 2410.08650). It leaves out the steps of position and duty, which are noise to the fit, and the delay,
which only shifts the time of the answer.
"""

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass
from math import cos, radians, sin
from typing import Any

import numpy as np

from ..robot.actuators import Friction, Servo

Array = np.ndarray[Any, Any]

STEP_S = 0.001
FLANK_NM_RAD, FLANK_DAMPING = 300.0, 0.5  # as in host/sim/servos/law.py (assumed)
NEW_RAD = radians(0.33)  # play at which a fit begins: a new MX-28's by the data sheet, whatever wear the file assumes
# The fitted numbers, in the servo's own units, and errors of each that weigh the same in the fit.
NAMES = (
    "stall_Nm", "no_load_rad_s", "duty_per_rad", "coulomb_Nm", "stribeck_Nm", "stribeck_rad_s", "viscous_Nms_rad",
    "load_motor", "load_external", "armature_kg_m2", "backlash_rad", "act_s",
)  # fmt: skip
# Fitted too, because it bends the runs, but told by shaking all joints, which draws twelve times the current.
SAG = "sag"  # the share of the supply's voltage that a stalled joint takes


@dataclass(frozen=True)
class Load:
    """A joint's load: inertia at the servo's shaft, and its weight, which at the joint is -(a sin q + b cos q)."""

    inertia_kg_m2: float
    sine_Nm: float
    cosine_Nm: float
    ratio: float = 1.0

    def at(self, shaft_rad: Array) -> Array:
        """Return the weight's torque on the shaft, N m."""
        ahead_rad, most_Nm = np.arctan2(self.cosine_Nm, self.sine_Nm), np.hypot(self.sine_Nm, self.cosine_Nm)
        weight: Array = -self.ratio * most_Nm * np.sin(self.ratio * shaft_rad + ahead_rad)
        return weight

    def at_scalar(self, shaft_rad: float) -> float:
        """Return the same for one angle, faster."""
        joint_rad = self.ratio * shaft_rad
        return -self.ratio * (self.sine_Nm * sin(joint_rad) + self.cosine_Nm * cos(joint_rad))

    def mirrored(self, about_rad: float) -> "Load":
        """Return the load of a joint that turns the wrong way: at q its weight is that of 2 x about - q, turned."""
        s, c = np.sin(2 * about_rad), np.cos(2 * about_rad)
        # sin(2a - q) = s cos q - c sin q, cos(2a - q) = c cos q + s sin q; the torque changes its sign, too.
        sine, cosine = -(self.cosine_Nm * s - self.sine_Nm * c), -(self.sine_Nm * s + self.cosine_Nm * c)
        return Load(self.inertia_kg_m2, float(sine), float(cosine), self.ratio)

    def gone(self) -> "Load":
        """Return the load of a horn that turns without its leg."""
        return Load(0.1 * self.inertia_kg_m2, 0.0, 0.0, self.ratio)


def side_by_side(loads: Sequence[Load]) -> Load:
    """Return the load of sweeps that are of different joints: each number is an array, with one entry per sweep."""
    return Load(*np.array([astuple(load) for load in loads]).T)


@dataclass(frozen=True)
class Told:
    """Sweeps side by side on a grid of ``STEP_S``: rows are sub-steps, columns sweeps.

    ``most`` is the duty's limit, negative without torque; ``volts`` the supply without the joint's current, as a share
    of the nominal one; ``side`` where the rotor begins within its play, -1 .. 1.
    """

    goal_rad: Array
    most: Array
    volts: Array
    start_rad: Array
    side: Array

    def only(self, columns: Sequence[int]) -> "Told":
        """Return some of the sweeps."""
        at = list(columns)
        return Told(self.goal_rad[:, at], self.most[:, at], self.volts[at], self.start_rad[at], self.side[..., at])


def from_file(servo: Servo) -> dict[str, float]:
    """Return the robot file's numbers, by ``NAMES`` and ``SAG``, at which a fit begins; play is a new servo's."""
    f = servo.friction
    return {
        "stall_Nm": servo.nominal.stall_Nm,
        "no_load_rad_s": servo.nominal.no_load_rad_s,
        "duty_per_rad": servo.duty_per_rad,
        "coulomb_Nm": servo.coulomb_Nm,
        "stribeck_Nm": f.stribeck_Nm,
        "stribeck_rad_s": f.stribeck_rad_s,
        "viscous_Nms_rad": f.viscous_Nms_rad,
        "load_motor": f.load_motor,
        "load_external": f.load_external,
        "armature_kg_m2": servo.armature_kg_m2,
        "backlash_rad": NEW_RAD,
        "act_s": 0.005,
        SAG: servo.supply_ohm * servo.stall_A / servo.nominal_voltage_V,
    }


def motor_stall_Nm(p: Mapping[str, Any], fixed: Friction) -> Any:
    """Return the motor's own stall torque, before the friction of its load takes its share."""
    return p["stall_Nm"] / (1.0 - p["load_motor"] - fixed.load_motor_stribeck)


def friction_Nm(p: Mapping[str, Any], fixed: Friction, motor_Nm: Array, load_Nm: Array, fast_rad_s: Array) -> Array:
    """Return the largest torque that friction holds, M6; ``fast_rad_s`` is the absolute speed."""
    slower = fast_rad_s / p["stribeck_rad_s"]
    fades = np.exp(-(slower if fixed.stribeck_exponent == 1.0 else slower**fixed.stribeck_exponent))
    square = np.where(
        np.abs(load_Nm) < np.abs(motor_Nm),
        fixed.load_external_square_1_Nm * load_Nm**2,
        fixed.load_motor_square_1_Nm * motor_Nm**2,
    ) * (load_Nm * motor_Nm < 0)
    at_rest = np.abs(fixed.load_external_stribeck * load_Nm - fixed.load_motor_stribeck * motor_Nm) + p["stribeck_Nm"]
    passed = np.abs(p["load_external"] * load_Nm - p["load_motor"] * motor_Nm)
    most: Array = p["coulomb_Nm"] + passed + fades * (at_rest + square) + p["viscous_Nms_rad"] * fast_rad_s
    return most


def sagging(sag: Array, duty: Array, back: Array, open_share: Array) -> Array:
    """Return the supply under the joint's own current, which is duty x (duty x supply - back) of the stalled one's."""
    left: Array = (open_share + sag * duty * back) / (1 + sag * duty**2)
    return np.minimum(left, open_share)  # a braking joint does not raise it


def simulate(p: Mapping[str, Array], fixed: Friction, load: Load, told: Told) -> tuple[Array, Array, Array]:
    """Return link angles, duties, and currents as shares of the stalled joint's: sub-steps x copies x sweeps.

    ``p`` holds columns, one row per copy.
    """
    steps, sweeps = told.goal_rad.shape
    copies = len(p["stall_Nm"])
    places, duties, drawn = (np.empty((steps, copies, sweeps)) for _ in range(3))
    stall, rotor_kg_m2, half = motor_stall_Nm(p, fixed), p["armature_kg_m2"], p["backlash_rad"] / 2
    link_kg_m2, dt = load.inertia_kg_m2, STEP_S
    damping = 2 * FLANK_DAMPING * np.sqrt(FLANK_NM_RAD * rotor_kg_m2 * link_kg_m2 / (rotor_kg_m2 + link_kg_m2))
    softer = 1.0 + (dt * damping + dt**2 * FLANK_NM_RAD) * (1 / rotor_kg_m2 + 1 / link_kg_m2)
    spring, damper = FLANK_NM_RAD / softer, (FLANK_NM_RAD * dt + damping) / softer
    link = np.broadcast_to(told.start_rad, (copies, sweeps)).copy()
    weight = load.at(told.start_rad)
    pressed = told.side * np.sign(weight) == -1  # the weight lies on a flank, which gives way a little
    rotor = link + half * told.side - pressed * weight / spring
    link_rad_s, rotor_rad_s = np.zeros_like(link), np.zeros_like(link)
    for at in range(steps):
        most = told.most[at]
        on, most = most >= 0, np.maximum(most, 0.0)
        duty = np.minimum(np.maximum(p["duty_per_rad"] * (told.goal_rad[at] - link), -most), most)
        back = rotor_rad_s / p["no_load_rad_s"]
        motor = on * stall * (duty * sagging(p[SAG], duty, back, told.volts) - back)
        drawn[at] = duty * motor / stall
        apart, way = rotor - link, rotor_rad_s - link_rad_s
        side = np.sign(apart)
        deep = apart * side - half
        flank = (deep > 0) * side * np.maximum(spring * deep + damper * side * way, 0.0)
        most_Nm = friction_Nm(p, fixed, motor, -flank, np.abs(rotor_rad_s))
        driving = motor - flank
        wanted = -(rotor_kg_m2 / dt * rotor_rad_s + driving)
        driving += np.minimum(np.maximum(wanted, -most_Nm), most_Nm)
        rotor_rad_s = rotor_rad_s + driving * (dt / rotor_kg_m2)
        rotor = rotor + rotor_rad_s * dt
        link_rad_s = link_rad_s + (flank + load.at(link)) * (dt / link_kg_m2)
        link = link + link_rad_s * dt
        places[at], duties[at] = link, duty
    return places, duties, drawn


def lag_s(p: Mapping[str, float]) -> float:
    """Return how far a servo that runs freely lags behind its goal: its speed is duty x no-load speed."""
    return 1.0 / (p["duty_per_rad"] * p["no_load_rad_s"])
