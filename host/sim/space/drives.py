"""The honest law of twelve drives on a MuJoCo model, one sub-step at a time: see host/sim/servos/law.py.

MuJoCo steps the rotors (export/play.py) and brings them to rest; told each sub-step are a servo's torque and how much
friction holds, by the torques at rotor and gear of the last sub-step. A brushless joint keeps its spring, which feels
the rotor; only its friction is told. Twelve drives are too few for numpy to pay.
"""

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
import numpy.typing as npt

from ...robot.actuators import Servo
from ...robot.model import Robot
from ..export.mjcf import joint_names
from ..export.play import PLAY
from ..servos.law import FLANK_DAMPING, FLANK_NM_RAD, Battery, Figures, friction_law

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]

_STEPS = 2.5  # sub-steps in a contact's time constant: MuJoCo asks for 2; with 5 robots fell that with 1 ms walked


def compliant(
    stiffness: float, damping_ratio: float, inverse_inertia: float, dt_s: float
) -> tuple[list[float], list[float]]:
    """Return solref and solimp of a contact or stop that gives as a spring: N/m and 1/kg, or N m/rad and 1/(kg m2).

    At rest its force is depth x k x d / (1 - d) / inverse inertia (MuJoCo, "Computation", solver parameters), where k
    is -solref / d and d solimp: k is the highest that the sub-step allows, d then gives the stiffness.
    """
    k = (1 / (_STEPS * dt_s * damping_ratio)) ** 2
    d = 1 / (1 + k / (stiffness * inverse_inertia))
    return [-k * d, -2 * damping_ratio * k**0.5 * d], [d, d, 0.001, 0.5, 2]


class Joints:
    """Where a model keeps the twelve joints' coordinates: of the rotors, and of the play behind them if there is."""

    def __init__(self, model: Any) -> None:
        self.q, self.v = _addresses(model, "")
        self.play_q, self.play_v = _addresses(model, PLAY)

    def links(self, values: Array, rotors: Indices, plays: Indices) -> Array:
        """Return the joints' angles or speeds, after the gears."""
        return np.asarray(values[rotors] + values[plays] if len(plays) else values[rotors])


def _addresses(model: Any, end: str) -> tuple[Indices, Indices]:
    names = {model.joint(i).name for i in range(model.njnt)}
    found = [model.joint(name + end) for name in joint_names() if name + end in names]
    return (np.array([int(joint.qposadr[0]) for joint in found], dtype=np.int64),
            np.array([int(joint.dofadr[0]) for joint in found], dtype=np.int64))  # fmt: skip


class HonestDrives:
    """The drives of a model made with ``honest``. Lists of twelve, in the joints' order, at the gears' shafts."""

    def __init__(self, robot: Robot, model: Any, data: Any, joints: Joints, figures: Figures, voltage_V: float) -> None:
        self._model, self._data, self._joints, self._figures = model, data, joints, figures
        servo = robot.actuator if isinstance(robot.actuator, Servo) else None
        self._servo, self.battery = servo is not None, Battery(voltage_V, servo.supply_ohm if servo else 0.0)
        self._coupled, self._ratio = robot.calf_drive.coupled, [1.0, 1.0, robot.calf_drive.ratio] * 4
        self._ratios = np.array(self._ratio)
        for dof in joints.play_v:
            joint, inverse = model.dof_jntid[dof], float(model.dof_invweight0[dof])
            model.jnt_solref[joint], model.jnt_solimp[joint] = compliant(
                FLANK_NM_RAD, FLANK_DAMPING, inverse, model.opt.timestep)  # fmt: skip
        # MuJoCo's rows of friction are the joints', then the rods'.
        rods = [drive for drive in range(12) if self._coupled and drive % 3 == 2]
        self._by_row = [drive for drive in range(12) if drive not in rods] + rods
        self._on_joints = joints.v[self._by_row[: 12 - len(rods)]]
        self._friction_Nm = friction_law(figures)
        self._armature_Nms_rad = figures.armature_kg_m2 / model.opt.timestep
        self._most, self._braking_Nms_rad = [1.0] * 12, [figures.braking_Nms_rad] * 12
        self._goal_rad = [0.0] * 12
        self.rest()

    def rest(self) -> None:
        """Forget the last sub-step: the robot was put somewhere."""
        self.duty, self._speed_rad_s, self._told_Nm, self.given_Nm = ([0.0] * 12 for _ in range(4))

    def act(self, goal_rad: Sequence[float]) -> None:
        """Take motor goals; from now on they act."""
        if self._servo:
            self._goal_rad = [goal / ratio for goal, ratio in zip(goal_rad, self._ratio, strict=True)]
        else:
            self._data.ctrl[:] = goal_rad

    def switch(self, on: Sequence[bool], limit: Sequence[float]) -> None:
        """Open the bridges of drives that are off: only friction brakes them; limit the duty of the rest."""
        if not self._servo:
            return
        self._most = [most if gives else 0.0 for most, gives in zip(limit, on, strict=True)]
        self._braking_Nms_rad = [self._figures.braking_Nms_rad if gives else 0.0 for gives in on]
        brakes = [most / ratio**2 for most, ratio in zip(self._braking_Nms_rad, self._ratio, strict=True)]
        self._put(self._model.dof_damping, self._model.tendon_damping, brakes)

    def torques_Nm(self) -> Array:
        """Return the drives' torques at the joints, on the data sheet's scale: at most its stall torque."""
        share = self._figures.stall_Nm / self._figures.motor_stall_Nm
        return np.array(self.given_Nm) * share / self._ratios

    def step(self) -> None:
        """Advance the model by a sub-step."""
        data, ratio = self._data, self._ratio
        rotor_rad_s = self._at_shafts(data.qvel, self._joints.v, self._joints.play_v)
        told_Nm = self._tell(rotor_rad_s) if self._servo else (data.actuator_force * self._ratios).tolist()
        most_Nm = self._hold(rotor_rad_s, told_Nm)
        self._put(self._model.dof_frictionloss, self._model.tendon_frictionloss,
                  [most / turns for most, turns in zip(most_Nm, ratio, strict=True)])  # fmt: skip
        self._speed_rad_s, self._told_Nm = rotor_rad_s, told_Nm
        mujoco.mj_step(self._model, data)

    def _at_shafts(self, values: Array, rotors: Indices, plays: Indices) -> list[float]:
        """Return the rotors' angles or speeds: a coupled calf's turns with the thigh."""
        turned = values[rotors]
        if self._coupled:
            turned[2::3] += turned[1::3] + values[plays[1::3]]
        return (turned / self._ratios).tolist()  # type: ignore[no-any-return]

    def _tell(self, rotor_rad_s: list[float]) -> list[float]:
        """Give the servos' torque by their P law, in its steps of position and of duty; return it at the shafts."""
        f, battery, data, ratio = self._figures, self.battery, self._data, self._ratio
        rotors = self._at_shafts(data.qpos, self._joints.q, self._joints.play_q)
        plays = data.qpos[self._joints.play_q].tolist()
        counts, steps, per_rad = f.counts_per_rad, f.pwm_steps, f.duty_per_rad
        full_Nm, draws = f.motor_stall_Nm * battery.voltage_V / f.voltage_V, 0.0
        duties, told_Nm = [], []
        for i, goal_rad in enumerate(self._goal_rad):
            seen_rad, most = rotors[i] + plays[i] / ratio[i], self._most[i]
            if counts:
                seen_rad = round(seen_rad * counts) / counts
            duty = per_rad * (goal_rad - seen_rad)
            duty = most if duty > most else -most if duty < -most else duty
            if steps:
                duty = round(duty * steps) / steps
            draws += duty * (full_Nm * duty - self._braking_Nms_rad[i] * rotor_rad_s[i])
            duties.append(duty)
            told_Nm.append(full_Nm * duty)
        battery.draw(draws * f.stall_A / f.motor_stall_Nm)
        battery.settle()
        self.duty, data.ctrl[:] = duties, [torque / turns for torque, turns in zip(told_Nm, ratio, strict=True)]
        return told_Nm

    def _hold(self, rotor_rad_s: list[float], told_Nm: list[float]) -> list[float]:
        """Return the most that friction holds at each shaft.

        What comes through a gear is what torque and friction of the last sub-step do not explain of the rotor's speed.
        """
        friction_Nm, gained, ratio = self._friction_Nm, self._armature_Nms_rad, self._ratio
        most_Nm, given_Nm = [0.0] * 12, [0.0] * 12
        held_Nm = self._data.efc_force[:12].tolist() or most_Nm
        for row, i in enumerate(self._by_row):
            speed = rotor_rad_s[i]
            braking = self._braking_Nms_rad[i] * speed
            load = gained * (speed - self._speed_rad_s[i]) - self._told_Nm[i] + braking - held_Nm[row] * ratio[i]
            given_Nm[i] = told_Nm[i] - braking
            most_Nm[i] = friction_Nm(given_Nm[i], load, speed)
        self.given_Nm = given_Nm
        return most_Nm

    def _put(self, of_joints: Array, of_rods: Array, values: list[float]) -> None:
        """Write twelve values where the model has them: at the joints, and at the rods of coupled calves."""
        ordered = [values[drive] for drive in self._by_row] if self._coupled else values
        of_joints[self._on_joints] = ordered[: len(self._on_joints)]
        if self._coupled:
            of_rods[:] = ordered[len(self._on_joints) :]
