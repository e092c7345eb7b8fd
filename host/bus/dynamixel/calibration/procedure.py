"""The guided calibration, one servo at a time: which joint is it, which way does it turn, where is its zero.

    move a little -> which joint? -> which way? -> turn it to the reference by hand -> limits -> keep

After every servo a file beside the calibration keeps what is done, so that one can stop and go on later.
"""

import difflib
from math import copysign, degrees, pi
from pathlib import Path

from ....robot.model import LEG_NAMES, Robot
from ....robot.poses import rest_pose_rad
from ....util.errors import NOT_ACHIEVED, UserError
from ...base import JOINT_LABELS, JOINTS
from ..kept import read_kept, write_kept
from ..link import ServoError
from ..table import MODEL_MX28_V2
from ..tools import find
from .bench import Bench
from .data import Calibration, JointCalibration, check, counts_per_rad, joint_from, limits_rad, to_text
from .person import Person
from .picture import picture, reference_words, words

SHOW_S = 2.0


def reference_rad(robot: Robot, joint: int) -> float:
    """Return the angle that is easy to set by hand and within the limits: hip and thigh 0, calf a right angle."""
    low, high = limits_rad(robot)[joint]
    wanted = copysign(pi / 2, robot.knee_sign(joint // 3)) if joint % 3 == 2 else 0.0
    return wanted if low <= wanted <= high else (low + high) / 2


class Procedure:
    """One calibration of one robot on a bench, with a person; the file ``keep`` has what is done so far."""

    def __init__(self, robot: Robot, bench: Bench, person: Person, keep: Path) -> None:
        self.robot, self.bench, self.person, self.keep = robot, bench, person, keep
        self.done: dict[int, JointCalibration] = {}
        self._per_rad = counts_per_rad(robot)

    def run(self) -> Calibration:
        """Return a checked calibration; this writes nothing."""
        servos = self.find()
        self.resume(servos)
        for servo in servos:
            if servo not in [joint.id for joint in self.done.values()]:
                self.bench.prepare(servo)
                self.one(servo)
                self.save()
        joints = tuple(self.done[joint] for joint in range(JOINTS))
        return check(Calibration(self.robot.name, joints), self.robot, "calibration")

    def find(self) -> list[int]:
        """Return the ids of the robot's servos; ServoError if the bus has others."""
        found = find(self.bench.link)
        if len(found) != JOINTS:
            ids = ", ".join(str(servo.id) for servo in found) or "none"
            raise ServoError(
                f"{len(found)} servos answer (ids {ids}) instead of {JOINTS}: check cables and power; servos with one "
                f"id count as one: set them up with caramelo servos setup"
            )
        for servo in found:
            if servo.model != MODEL_MX28_V2:
                raise ServoError(f"servo id {servo.id} is not an MX-28(2.0) but {servo.text}")
        return [servo.id for servo in found]

    def one(self, servo: int) -> None:
        """Calibrate one servo."""
        person = self.person
        person.say(f"\nServo {servo}. It now moves a little, with little force: watch the robot.")
        joint = self.which_joint(servo)
        label = JOINT_LABELS[joint]
        person.say(f"\n{picture(self.robot, joint)}")
        sign = self.which_way(servo, label, words(joint))
        zero = self.where_is_zero(servo, joint, sign)
        self.done[joint] = self.limits(servo, joint, sign, zero)
        person.say(f"{label}: id {servo}, sign {sign:+d}, zero {zero}")

    def which_joint(self, servo: int) -> int:
        """Return the joint that the servo moves."""
        key = f"servo {servo} joint"
        self.bench.nudge(servo)
        while True:
            answer = self.person.ask(key, "Which joint moved? (again: move once more)", [*JOINT_LABELS, "again"])
            if answer == "again":
                self.bench.nudge(servo)
                continue
            joint = JOINT_LABELS.index(answer)
            if joint not in self.done:
                return joint
            self.person.refuse(key, f"{answer} already has servo {self.done[joint].id}")

    def which_way(self, servo: int, label: str, larger: str) -> int:
        """Return the sign: +1 if more counts are a larger angle."""
        while True:
            self.person.say(f"{label} moves once more. In the picture + moves the foot {larger}.")
            direction = self.bench.nudge(servo)
            answer = self.person.ask(f"servo {servo} direction", "Which way did it go first?", ["+", "-", "again"])
            if answer != "again":
                return direction if answer == "+" else -direction

    def where_is_zero(self, servo: int, joint: int, sign: int) -> int:
        """Return the position at angle 0, from a reference to which a person turns the joint by hand."""
        angle = reference_rad(self.robot, joint)
        where = f"{reference_words(self.robot, joint)} ({degrees(angle):.0f} deg)"
        counts = self.placed(servo, joint, angle, "reference", f"The servo is loose. Turn the joint by hand: {where}")
        return counts - sign * round(angle * self._per_rad[joint])

    def placed(self, servo: int, joint: int, angle_rad: float, what: str, question: str) -> int:
        """Ask for a joint to be turned by hand, and return the servo's position then."""
        self.bench.place(servo, joint, angle_rad)
        self.person.ask(f"servo {servo} {what}", question, [])
        return self.bench.position(servo)

    def limits(self, servo: int, joint: int, sign: int, zero: int) -> JointCalibration:
        """Return the joint with the robot file's limits, or with those found by hand within them."""
        planned = joint_from(self.robot, joint, servo, sign, zero)
        low, high = limits_rad(self.robot)[joint]
        span = f"{degrees(low):.0f} .. {degrees(high):.0f} deg"
        question = f"Limits: from the robot file ({span}), or by hand because cables or parts are in the way?"
        while self.person.ask(f"servo {servo} limits", question, ["file", "hand"]) == "hand":
            lowest = self.placed(servo, joint, low, "lowest", "Turn it to its smallest angle")
            highest = self.placed(servo, joint, high, "highest", "Turn it to its largest angle")
            ends = sorted((lowest, highest))
            rest = planned.counts(rest_pose_rad(self.robot)[joint], self._per_rad[joint])
            if (highest - lowest) * sign > 0 and ends[0] <= rest <= ends[1]:
                return JointCalibration(servo, sign, zero, max(planned.min, ends[0]), min(planned.max, ends[1]))
            self.person.refuse(
                f"servo {servo} limits", "these limits do not contain the rest stance in the right order"
            )
        return planned

    def check_legs(self, calibration: Calibration) -> list[str]:
        """Move each leg to the rest stance with little torque, ask how it stands, and return the wrong ones."""
        wrong = []
        for leg, name in enumerate(LEG_NAMES):
            while True:
                self.show_leg(calibration, leg)
                question = (
                    f"Did {name} stand as drawn, thigh {self._degrees(leg, 1)}, calf {self._degrees(leg, 2)} deg?"
                )
                answer = self.person.ask(f"check {name}", question, ["yes", "no", "again"])
                if answer != "again":
                    break
            if answer == "no":
                wrong.append(name)
        return wrong

    def show_leg(self, calibration: Calibration, leg: int) -> None:
        """Move a leg to the rest stance, hold it for a while, let go."""
        self.person.say(f"\n{picture(self.robot, leg * 3 + 1)}\n{LEG_NAMES[leg]} moves to #, the rest stance.")
        goals = {}
        for joint, angle in enumerate(rest_pose_rad(self.robot)[3 * leg : 3 * leg + 3], leg * 3):
            mount = calibration.joints[joint]
            goals[mount.id] = mount.limited_counts(angle, self._per_rad[joint])
        try:
            self.bench.move(goals)
            self.bench.hold(SHOW_S)
        finally:
            self.bench.release(list(goals))

    def _degrees(self, leg: int, kind: int) -> str:
        return f"{degrees(rest_pose_rad(self.robot)[3 * leg + kind]):.0f}"

    def save(self) -> None:
        """Keep what is done so far."""
        write_kept(self.keep, self.robot.name, self.done)

    def resume(self, servos: list[int]) -> None:
        """Go on with an earlier, unfinished calibration if there is one and the person wants it."""
        if not self.keep.exists():
            return
        done = read_kept(self.keep, self.robot.name, JointCalibration)
        if len({joint.id for joint in done.values()}) != len(done):
            raise UserError(f"{self.keep}: two joints have the same servo; delete the file to start again")
        if any(joint.id not in servos for joint in done.values()):
            raise UserError(
                f"{self.keep}: begun with servo ids that are not on the bus now; delete the file to start again"
            )
        question = f"{len(done)} of {JOINTS} servos are already calibrated. Go on with the others?"
        if self.person.ask("resume", question, ["yes", "no"]) == "yes":
            self.done = done


def difference(path: Path, calibration: Calibration) -> str:
    """Return as a unified diff what writing would change in the file; "" for nothing."""
    former = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    present = to_text(calibration).splitlines()
    lines = difflib.unified_diff(former, present, f"{path} (now)", f"{path} (new)", lineterm="")
    return "\n".join(lines)


def complain_about(legs: list[str], calibration: Calibration) -> UserError:
    """Return what to do about legs that did not stand as drawn."""
    ids = [str(calibration.joints[LEG_NAMES.index(leg) * 3 + k].id) for leg in legs for k in range(3)]
    return UserError(
        f"{', '.join(legs)} did not stand as drawn: run caramelo calibrate again, and watch servos {', '.join(ids)}",
        NOT_ACHIEVED,
    )
