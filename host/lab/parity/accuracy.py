"""How far the core's integers are from real numbers: worst and median errors, with CMSIS-DSP's beside them."""

import importlib.util
import math
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from shared.body import leg
from shared.body import pose as body
from shared.body.axes import POSE_AXES, Pose
from shared.body.feet import Feet
from shared.body.params import Params
from shared.num import fixed
from shared.record import pack, unpack
from shared.runtime import zeros

from ...robot.file import driven_names, load_robot
from ...robot.kinematics_si import Vector, leg_forward
from ...robot.scale import core_params, rad

SAMPLES = 20_000


@dataclass(frozen=True)
class Accuracy:
    """One figure; ``bar`` is the worst error allowed, ``cmsis`` CMSIS-DSP's q15 function's worst, if it is there."""

    name: str
    unit: str
    worst: float
    median: float
    bar: float
    cmsis: float | None = None

    @property
    def ok(self) -> bool:
        return self.worst <= self.bar


def accuracies(samples: int = SAMPLES) -> Iterator[Accuracy]:
    """Yield the figures; the same in every run."""
    yield _figure("sine", "LSB of Q15", _sine_errors(fixed.sin_q15, 0.0), 1.0, _cmsis("arm_sin_q15", _cmsis_sine))
    yield _figure("cosine", "LSB of Q15", _sine_errors(fixed.cos_q15, 0.25), 1.0)
    yield _figure("arctangent", "deg", _arctangent_errors(samples), 0.0025, _cmsis("arm_atan2_q15", _cmsis_arctangent))
    yield _figure("square root", "away from floor", _root_errors(samples), 0.0, _cmsis("arm_sqrt_q15", _cmsis_root))
    for name in driven_names():
        yield _figure(f"inverse kinematics, {name}", "mm", _leg_errors(name, samples), 0.05)
        yield _figure(f"body pose at the foot, {name}", "mm", _body_errors(name, samples), 0.08)


def _figure(name: str, unit: str, errors: list[float], bar: float, cmsis: float | None = None) -> Accuracy:
    errors.sort()
    return Accuracy(name, unit, errors[-1], errors[len(errors) // 2], bar, cmsis)


def _sine_errors(function: Callable[[int], int], turn: float) -> list[float]:
    exact = [32768 * math.sin(2 * math.pi * (angle / 65536 + turn)) for angle in range(65536)]
    return [abs(function(angle) - wanted) for angle, wanted in enumerate(exact)]


def _arctangent_errors(samples: int) -> list[float]:
    dice = random.Random(1)
    errors = []
    for _ in range(samples):
        top = 1 << dice.randint(2, 30)
        y, x = dice.randint(1 - top, top - 1), dice.randint(1 - top, top - 1)
        if x or y:
            away = fixed.atan2_brad18(y, x) / (1 << 18) * 360 - math.degrees(math.atan2(y, x))
            errors.append(abs((away + 180) % 360 - 180))
    return errors


def _root_errors(samples: int) -> list[float]:
    dice = random.Random(2)
    numbers = [dice.randrange(1 << dice.randint(1, 30)) for _ in range(samples)]
    numbers += [k * k + away for k in range(1, 32768, 7) for away in (-1, 0, 1)]
    return [float(abs(fixed.isqrt(n) - math.isqrt(n))) for n in numbers]


def _leg_errors(name: str, samples: int) -> list[float]:
    """Distance of a foot from where the integer solution puts it through float kinematics, over the workspace."""
    robot = load_robot(name)
    params = core_params(robot)
    unit_mm = 1000 * 2.0 ** -params.length_shift
    dice = random.Random(3)
    feet, joints = Feet(), zeros(12)
    errors = []
    for at in range(samples):
        number = at % 4
        links, low, high = _leg_data(params, number)
        angles = [dice.randint(a, b) for a, b in zip(low, high, strict=True)]
        reached = leg_forward(links, robot.side(number), _rads(angles))
        foot = [round(v) for v in reached]
        unpack(feet.legs[number], foot)
        leg.leg_inverse(params, number, feet, joints)
        solved = leg_forward(links, robot.side(number), _rads(list(joints[number * 3 : number * 3 + 3])))
        errors.append(math.dist(foot, solved) * unit_mm)
    return errors


def _leg_data(params: Params, number: int) -> tuple[Vector, list[int], list[int]]:
    """Return link lengths in lu and the joint limits in brad of one leg's block."""
    base = params.legs[number]
    links = (float(abs(base.hip_length)), float(base.thigh_length), float(base.calf_length))
    return links, pack(base.lowest), pack(base.highest)


def _rads(angles: list[int]) -> Vector:
    return rad(angles[0]), rad(angles[1]), rad(angles[2])


def _body_errors(name: str, samples: int) -> list[float]:
    """Distance of a foot from where exact rotation matrices put it, over the poses the robot allows."""
    params = core_params(load_robot(name))
    unit_mm = 1000 * 2.0 ** -params.length_shift
    dice = random.Random(4)
    pose, rotation = Pose(), zeros(9)
    feet, hip_feet = Feet(), Feet()
    errors = []
    for at in range(samples // 4):
        number = at % 4
        limb = params.legs[number]
        for axis in range(POSE_AXES):
            pose[axis] = dice.randint(-params.pose_max[axis], params.pose_max[axis])
        for axis in range(3):
            feet.legs[number][axis] = limb.rest[axis] + dice.randint(-3000, 3000)
        body.body_rotation(pose, rotation)
        body.body_to_hip(params, number, pose, rotation, feet, hip_feet)
        exact = _to_hip(pack(pose), pack(feet.legs[number]), pack(limb.hip))
        errors.append(math.dist(exact, pack(hip_feet.legs[number])) * unit_mm)
    return errors


def _to_hip(pose: list[int], foot: list[int], hip: list[int]) -> list[float]:
    """R^T (p - c) - h of paper A eq 9 with R = Rx Ry Rz: undone in that order, axis by axis."""
    x, y, z = [float(foot[axis] - pose[axis]) for axis in range(3)]
    roll, pitch, yaw = [rad(angle) for angle in pose[3:]]
    y, z = y * math.cos(roll) + z * math.sin(roll), z * math.cos(roll) - y * math.sin(roll)
    x, z = x * math.cos(pitch) - z * math.sin(pitch), z * math.cos(pitch) + x * math.sin(pitch)
    x, y = x * math.cos(yaw) + y * math.sin(yaw), y * math.cos(yaw) - x * math.sin(yaw)
    return [x - hip[0], y - hip[1], z - hip[2]]


def _cmsis(name: str, errors: Callable[[Callable[..., Any]], Iterator[float]]) -> float | None:
    """Return the worst error of a function of CMSIS-DSP, None if that is not installed."""
    if importlib.util.find_spec("cmsisdsp") is None:
        return None
    import cmsisdsp

    return max(errors(getattr(cmsisdsp, name)))


def _cmsis_sine(function: Callable[..., int]) -> Iterator[float]:
    return (abs(function(angle) - 32768 * math.sin(2 * math.pi * angle / 32768)) for angle in range(32768))


def _cmsis_arctangent(function: Callable[..., tuple[int, int]]) -> Iterator[float]:
    """Its result is in rad, Q2.13."""
    dice = random.Random(5)
    for _ in range(SAMPLES):
        y, x = dice.randint(-32767, 32767), dice.randint(-32767, 32767)
        if x and y:
            away = math.degrees(function(y, x)[1] / 8192 - math.atan2(y, x))
            yield abs((away + 180) % 360 - 180)


def _cmsis_root(function: Callable[..., tuple[int, int]]) -> Iterator[float]:
    return (abs(function(n)[1] - 32768 * math.sqrt(n / 32768)) for n in range(1, 32768))
