"""Twelve joints with the honest law of a servo, in the air or under the robot's weight: a robot for identification.

On a stand each joint turns its own leg, the rest of which stays as at rest. On the ground each bears what statics says
of the whole pose; the joints do not shake each other. Steps, falls and slipping feet are the walking simulators' part.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians
from random import Random

from ...bus.base import JOINTS
from ...bus.dynamixel.calibration.data import Calibration, JointCalibration, counts_per_rad, limits_rad, servo_of
from ...bus.dynamixel.calibration.procedure import reference_rad
from ...bus.dynamixel.link import Link, protocol_of
from ...identify.carried import in_the_air, joint_per_shaft, on_the_ground_Nm
from ...identify.rig import Rig
from ...robot.model import Robot
from ..plant import DT_S, Plant
from .bus import EmulatedBus
from .law import Battery, Figures, ServoLaw, Stood, figures_of
from .loopback import LoopbackPort

FAULTS = ("loose horn", "double friction", "reversed", "sticking")
BODY_SHARE_KG_M2 = 0.004  # a quarter of the body on a lever of 85 mm, which each joint moves on the ground
STOPS_BEYOND_RAD = radians(2.0)  # behind the limits
REFRESH = 10  # sub-steps for which loads on the ground hold
STICKY_RAD, STICKY_TIMES = 0.06, 4.0


@dataclass(frozen=True)
class Made:
    """One imaginary robot: its servos, its supply, the time of answers, and its faults, joint by joint."""

    figures: tuple[Figures, ...]
    supply_ohm: float
    answer_s: float
    faults: tuple[str, ...] = ("",) * JOINTS


def drawn(robot: Robot, seed: int, fault: str = "", joint: int = 0) -> Made:
    """Return a robot drawn at random around its file: each number its own, brothers within some percent of another."""
    chance, servo = Random(f"made {seed}"), servo_of(robot)
    base = figures_of(servo)
    friction = servo.friction.model_copy(
        update={
            "stribeck_Nm": chance.uniform(0.03, 0.08),
            "stribeck_rad_s": chance.uniform(0.25, 0.9),
            "viscous_Nms_rad": chance.uniform(0.01, 0.03),
            "load_motor": chance.uniform(0.1, 0.3),
            "load_external": chance.uniform(0.05, 0.2),
        }
    )
    base = replace(
        base,
        stall_Nm=base.stall_Nm * chance.uniform(0.85, 1.15),
        no_load_rad_s=base.no_load_rad_s * chance.uniform(0.85, 1.15),
        duty_per_rad=base.duty_per_rad * chance.uniform(0.8, 1.2),
        coulomb_Nm=chance.uniform(0.03, 0.1),
        armature_kg_m2=chance.uniform(0.002, 0.005),
        backlash_rad=radians(chance.uniform(0.3, 1.5)),
        delay_s=chance.randint(2, 20) * DT_S,
        friction=friction,
    )
    faults = [""] * JOINTS
    faults[joint] = fault
    figures = tuple(_brother(base, chance, fault) for fault in faults)
    return Made(figures, chance.uniform(0.1, 0.4), chance.randint(1, 4) * DT_S, tuple(faults))


def _brother(base: Figures, chance: Random, fault: str) -> Figures:
    """Return one servo of the robot: all but the delay is some percent off."""
    f = base.friction
    times = 2.0 if fault == "double friction" else 1.0

    def near(value: float, spread: float = 0.05) -> float:
        return value * chance.uniform(1 - spread, 1 + spread)

    friction = f.model_copy(
        update={
            "stribeck_Nm": times * near(f.stribeck_Nm),
            "stribeck_rad_s": near(f.stribeck_rad_s),
            "viscous_Nms_rad": times * near(f.viscous_Nms_rad),
            "load_motor": near(f.load_motor),
            "load_external": near(f.load_external),
        }
    )
    return replace(
        base,
        stall_Nm=near(base.stall_Nm),
        no_load_rad_s=near(base.no_load_rad_s),
        duty_per_rad=near(base.duty_per_rad, 0.01),
        coulomb_Nm=times * near(base.coulomb_Nm),
        armature_kg_m2=near(base.armature_kg_m2),
        backlash_rad=near(base.backlash_rad),
        friction=friction,
    )


class HonestPlant(Plant):
    """Joints with honest servos; ``on_ground`` puts the robot's weight on them."""

    def __init__(self, robot: Robot, pose_rad: Sequence[float], made: Made) -> None:
        super().__init__(robot, pose_rad)
        self.made, self.on_ground = made, False
        self._pose_rad = tuple(pose_rad)
        self._ratio = [joint_per_shaft(robot, joint) for joint in range(JOINTS)]
        self._loads = [in_the_air(robot, joint) for joint in range(JOINTS)]
        self._loads = [load.gone() if fault == "loose horn" else load
                       for load, fault in zip(self._loads, made.faults, strict=True)]  # fmt: skip
        self._stops = [(low / r - STOPS_BEYOND_RAD, high / r + STOPS_BEYOND_RAD)
                       for (low, high), r in zip(limits_rad(robot), self._ratio, strict=True)]  # fmt: skip
        self.battery = Battery(made.figures[0].voltage_V, made.supply_ohm)
        self.put_back()

    def put_back(self) -> None:
        """See Plant."""
        self._joints = []
        for joint, figures in enumerate(self.made.figures):
            at, inertia = self._pose_rad[joint] / self._ratio[joint], self._loads[joint].inertia_kg_m2
            self._joints.append(Stood(ServoLaw(figures, at, inertia, self.battery), inertia, at))
        self.position_rad[:], self.speed_rad_s[:] = self._pose_rad, [0.0] * JOINTS

    def push(self, joint: int, angle_rad: float) -> None:
        """See Plant."""
        if not self.drives.on[joint]:
            self._joints[joint].position_rad = angle_rad / self._ratio[joint]
            self.position_rad[joint] = angle_rad

    @property
    def supply_V(self) -> float:
        """See Plant."""
        return self.battery.voltage_V

    def _run(self, steps: int) -> None:
        for done in range(0, steps, REFRESH):
            ground = on_the_ground_Nm(self.robot, self.position_rad) if self.on_ground else None
            for _ in range(min(REFRESH, steps - done)):
                for joint in range(JOINTS):
                    self._step(joint, ground)
                self.battery.settle()

    def _step(self, joint: int, ground: list[float] | None) -> None:
        drives, one, ratio = self.drives, self._joints[joint], self._ratio[joint]
        most = drives.limit[joint] if drives.on[joint] else None
        loose = self.made.faults[joint] == "loose horn"
        if ground is None or loose:
            if most is None and abs(one.speed_rad_s) < 1e-6 and one.law.torque_Nm != 0.0 and not one.law.duty:
                return  # a limp joint that hangs still
            load_Nm = float(self._loads[joint].at_scalar(one.position_rad))
            one.inertia_kg_m2 = self._loads[joint].inertia_kg_m2
        else:
            load_Nm, one.inertia_kg_m2 = ground[joint], self._loads[joint].inertia_kg_m2 + BODY_SHARE_KG_M2
        self._stick(joint, one)
        one.step(drives.goal_rad[joint] / ratio, most, load_Nm, DT_S)
        low, high = self._stops[joint]
        if not low <= one.position_rad <= high:
            one.position_rad, one.speed_rad_s = min(max(one.position_rad, low), high), 0.0
            one.law.rotor_rad_s = 0.0
        drives.load[joint] = one.law.duty
        self.position_rad[joint], self.speed_rad_s[joint] = one.position_rad * ratio, one.speed_rad_s * ratio

    def _stick(self, joint: int, one: Stood) -> None:
        """Give a sticking joint more friction at one place, a little beside its rest."""
        if self.made.faults[joint] != "sticking":
            return
        figures = self.made.figures[joint]
        away = one.position_rad - self._pose_rad[joint] / self._ratio[joint] - 0.15
        if abs(away) < STICKY_RAD:
            figures = replace(figures, coulomb_Nm=figures.coulomb_Nm * STICKY_TIMES)
        one.law.become(figures)


class StandPort(LoopbackPort):
    """A port whose answers take their time, as through a USB adapter."""

    def __init__(self, bus: EmulatedBus, stand: "HonestStand") -> None:
        super().__init__(bus, lambda: stand.now_s)
        self._stand, self._fresh = stand, False

    def readPort(self, length: int) -> bytes:
        """See LoopbackPort: the first bytes of an answer come late."""
        if self._waiting and self._fresh:
            self._stand.pass_time(self._stand.plant.made.answer_s)
            self._fresh = False
        return super().readPort(length)

    def writePort(self, packet: list[int]) -> int:
        """See LoopbackPort."""
        self._fresh = True
        return super().writePort(packet)


class HonestStand:
    """An imaginary robot's servos on an emulated bus, in simulated time."""

    def __init__(self, robot: Robot, calibration: Calibration, made: Made, pose_rad: Sequence[float]) -> None:
        self.robot, self.now_s = robot, 0.0
        self.plant = HonestPlant(robot, pose_rad, made)
        self.bus = EmulatedBus(robot, self.plant, calibration, protocol_of(robot))
        told = Calibration(calibration.robot, tuple(
            _turned_round(robot, joint, mount) if fault == "reversed" else mount
            for joint, (mount, fault) in enumerate(zip(calibration.joints, made.faults, strict=True))
        ))  # fmt: skip
        link = Link(StandPort(self.bus, self), self.bus.protocol)
        self.rig = Rig(robot, told, link, lambda: self.now_s, self._until)

    def pass_time(self, seconds: float) -> None:
        """Let simulated time pass."""
        self.now_s += seconds
        self.bus.advance(self.now_s)

    def _until(self, time_s: float) -> None:
        if time_s > self.now_s:
            self.pass_time(time_s - self.now_s)

    def put_on_ground(self) -> None:
        """Take the robot from its stand."""
        self.plant.on_ground = True


def reference_shaft_rad(robot: Robot, joint: int) -> float:
    """Return the angle of the shaft about which a joint is mirrored if its sign is wrong."""
    return reference_rad(robot, joint) / joint_per_shaft(robot, joint)


def _turned_round(robot: Robot, joint: int, mount: JointCalibration) -> JointCalibration:
    """Return the calibration by a person who got the joint's sign wrong."""
    per_rad = counts_per_rad(robot)[joint] * joint_per_shaft(robot, joint)
    counts = mount.counts(reference_shaft_rad(robot, joint), per_rad)
    zero = counts + mount.sign * round(reference_shaft_rad(robot, joint) * per_rad)
    low, high = limits_rad(robot)[joint]
    ends = sorted(zero - mount.sign * round(limit / joint_per_shaft(robot, joint) * per_rad) for limit in (low, high))
    return JointCalibration(mount.id, -mount.sign, zero, max(0, ends[0]), min(4095, ends[1]))

