"""The calibration of one robot: servo id, sign, zero and limits of each joint, in a TOML file.

    counts = zero + sign x round(angle / ratio x counts per turn / 2 pi)

``ratio`` is the robot file's joint angle per motor angle. ``zero`` is where the joint's angle would be 0; for a
calf, which can't be stretched, that is a place that it never reaches, possibly outside the servo's turn.
"""

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import degrees, tau
from pathlib import Path
from typing import Any

from ....robot.actuators import Servo
from ....robot.model import JOINT_NAMES, LEG_NAMES, Robot
from ....robot.poses import rest_pose_rad
from ....robot.values import show
from ....util.errors import UserError
from ....util.files import read_toml, write_text
from ...base import JOINT_LABELS, JOINTS

LARGEST_ID = 252  # protocol 2.0
FIELDS = ("id", "sign", "zero", "min", "max")


class CalibrationError(UserError):
    """A calibration that can't be used."""


@dataclass(frozen=True)
class JointCalibration:
    """How one servo sits on its joint; zero, min and max in counts of the servo's position."""

    id: int
    sign: int
    zero: int
    min: int
    max: int

    def counts(self, angle_rad: float, counts_per_rad: float) -> int:
        """Return the servo's position for a joint angle, not limited."""
        return self.zero + self.sign * round(angle_rad * counts_per_rad)

    def limited_counts(self, angle_rad: float, counts_per_rad: float) -> int:
        """Return the servo's position for a joint angle within the joint's limits."""
        return min(max(self.counts(angle_rad, counts_per_rad), self.min), self.max)

    def angle_rad(self, counts: int, counts_per_rad: float) -> float:
        """Return the joint angle for a position of the servo."""
        return self.sign * (counts - self.zero) / counts_per_rad


@dataclass(frozen=True)
class Calibration:
    """Twelve joints, index leg * 3 + joint."""

    robot: str
    joints: tuple[JointCalibration, ...]

    @property
    def ids(self) -> tuple[int, ...]:
        """The servo ids of the joints."""
        return tuple(joint.id for joint in self.joints)


def servo_of(robot: Robot) -> Servo:
    """Return the robot's servo; UserError if it has none."""
    if not isinstance(robot.actuator, Servo):
        raise UserError(f"{robot.name} has no servos: its joints are brushless; use --robot caramelo")
    return robot.actuator


def counts_per_rad(robot: Robot) -> tuple[float, ...]:
    """Return servo counts per rad of joint angle, per joint: the rod turns the calf further than its motor."""
    turn = servo_of(robot).counts_per_turn / tau
    return (turn, turn, turn / robot.calf_drive.ratio) * 4


def limits_rad(robot: Robot) -> list[tuple[float, float]]:
    """Return the robot file's joint limits, per joint."""
    return [limits for leg in range(4) for limits in robot.joint_limits_rad(leg)]


def joint_from(robot: Robot, joint: int, servo: int, sign: int, zero: int) -> JointCalibration:
    """Return a joint with the robot file's limits, restricted to the servo's turn."""
    per_rad, top = counts_per_rad(robot)[joint], servo_of(robot).counts_per_turn - 1
    ends = sorted(zero + sign * round(limit * per_rad) for limit in limits_rad(robot)[joint])
    return JointCalibration(servo, sign, zero, max(0, ends[0]), min(top, ends[1]))


def nominal(robot: Robot) -> Calibration:
    """Return the calibration of a robot built to plan: ids 1 .. 12, each turn's middle at its joint's middle."""
    middle = servo_of(robot).counts_per_turn // 2
    joints = []
    for joint, ((low, high), per_rad) in enumerate(zip(limits_rad(robot), counts_per_rad(robot), strict=True)):
        sign = robot.side(joint // 3)
        zero = middle - sign * round((low + high) / 2 * per_rad)
        joints.append(joint_from(robot, joint, joint + 1, sign, zero))
    return Calibration(robot.name, tuple(joints))


def complaints(calibration: Calibration, robot: Robot) -> Iterator[str]:
    """Yield what is wrong with a calibration for this robot, one sentence each."""
    if calibration.robot != robot.name:
        yield f"robot: value {show(calibration.robot)}: allowed: {show(robot.name)}, the robot in use"
    if len(calibration.joints) != JOINTS:
        yield f"{len(calibration.joints)} joints: allowed: {JOINTS}, {', '.join(JOINT_LABELS)}"
        return
    used = Counter(calibration.ids)
    for label, joint in zip(JOINT_LABELS, calibration.joints, strict=True):
        if used[joint.id] > 1:
            others = [name for name, j in zip(JOINT_LABELS, calibration.joints, strict=True) if j.id == joint.id]
            yield f"{label}.id: value {joint.id}: allowed: an id for one joint only; {' and '.join(others)} share it"
            return
    top = servo_of(robot).counts_per_turn
    rows = zip(JOINT_LABELS, calibration.joints, rest_pose_rad(robot), counts_per_rad(robot), strict=True)
    for label, joint, rest, per_rad in rows:
        yield from _joint_complaints(label, joint, rest, per_rad, top)


def _joint_complaints(label: str, joint: JointCalibration, rest_rad: float, per_rad: float, top: int) -> Iterator[str]:
    if not 0 <= joint.id <= LARGEST_ID:
        yield f"{label}.id: value {joint.id}: allowed: 0 .. {LARGEST_ID}"
    if joint.sign not in (-1, 1):
        yield f"{label}.sign: value {joint.sign}: allowed: 1 (more counts, larger angle) or -1"
        return
    if not -top <= joint.zero <= 2 * top:
        yield f"{label}.zero: value {joint.zero}: allowed: {-top} .. {2 * top} counts"
    if not 0 <= joint.min < joint.max < top:
        yield f"{label}.min, max: values {joint.min}, {joint.max}: allowed: 0 <= min < max <= {top - 1} counts"
        return
    rest = joint.counts(rest_rad, per_rad)
    if not joint.min <= rest <= joint.max:
        yield (
            f"{label}.min, max: values {joint.min}, {joint.max}: allowed: limits that contain the rest stance, "
            f"{degrees(rest_rad):.1f} deg = {rest} counts; the zero or the sign is wrong"
        )


def check(calibration: Calibration, robot: Robot, where: str) -> Calibration:
    """Return the calibration; CalibrationError with the first thing that is wrong."""
    for sentence in complaints(calibration, robot):
        raise CalibrationError(f"{where}: {sentence}")
    return calibration


def load_calibration(path: Path, robot: Robot) -> Calibration:
    """Return the checked calibration of a file; CalibrationError says what is wrong and what to do."""
    return check(from_tables(read_tables(path), str(path)), robot, str(path))


def read_tables(path: Path) -> dict[str, Any]:
    """Return a file's TOML tables."""
    try:
        return read_toml(path)
    except FileNotFoundError:
        raise CalibrationError(f"{path}: no calibration yet; run: caramelo calibrate") from None
    except OSError as error:
        raise CalibrationError(f"{path}: can't be read: {error.strerror}") from None
    except ValueError as error:
        raise CalibrationError(f"{path}: not TOML: {' '.join(str(error).split())}; run: caramelo calibrate") from None


def from_tables(tables: Mapping[str, Any], where: str) -> Calibration:
    """Return a calibration from TOML tables; ``check`` checks ids, ranges and the like."""
    unknown = sorted(set(tables) - {"robot", *LEG_NAMES})
    if unknown:
        raise CalibrationError(f"{where}: {unknown[0]}: unknown key: allowed: robot, {', '.join(LEG_NAMES)}")
    joints = [_joint_from(tables, leg, joint, where) for leg in LEG_NAMES for joint in JOINT_NAMES]
    return Calibration(str(tables.get("robot", "")), tuple(joints))


def _joint_from(tables: Mapping[str, Any], leg: str, joint: str, where: str) -> JointCalibration:
    place = f"{where}: {leg}.{joint}"
    table = tables.get(leg, {})
    values = table.get(joint) if isinstance(table, dict) else None
    if not isinstance(values, dict):
        raise CalibrationError(f"{place}: missing: allowed: a table with {', '.join(FIELDS)}")
    for key in sorted(set(values) ^ set(FIELDS)):
        raise CalibrationError(f"{place}.{key}: {'unknown' if key in values else 'missing'}: allowed: {FIELDS}")
    for key in FIELDS:
        if type(values[key]) is not int:
            raise CalibrationError(f"{place}.{key}: value {show(values[key])}: allowed: a whole number")
    return JointCalibration(**values)


def to_text(calibration: Calibration) -> str:
    """Return the calibration as commented TOML."""
    lines = [
        "# Calibration of one robot, written by `caramelo calibrate`; docs/calibration.md explains it.",
        "# id: servo; sign: 1 if more counts are a larger joint angle; zero, min, max: counts of the servo's position.",
        f'robot = "{calibration.robot}"',
    ]
    for leg, name in enumerate(LEG_NAMES):
        lines += ["", f"[{name}]"]
        for joint, kind in enumerate(JOINT_NAMES):
            j = calibration.joints[leg * 3 + joint]
            lines.append(f"{kind} = {{ id = {j.id}, sign = {j.sign}, zero = {j.zero}, min = {j.min}, max = {j.max} }}")
    return "\n".join(lines) + "\n"


def save_calibration(path: Path, calibration: Calibration) -> Path | None:
    """Write the whole file; return the backup of the former one, or None if there was none or it is the same."""
    content, kept = to_text(calibration), None
    if path.exists():
        former = path.read_text(encoding="utf-8")
        if former == content:
            return None
        kept = path.with_name(path.name + ".backup")
        write_text(kept, former)
    write_text(path, content)
    return kept


def default_path(robot: Robot) -> Path:
    """Return where a robot's calibration is kept: $XDG_CONFIG_HOME/caramelo, or ~/.config/caramelo."""
    import os

    base = os.environ.get("XDG_CONFIG_HOME") or str(Path.home() / ".config")
    return Path(base) / "caramelo" / f"{robot.name}.calibration.toml"
