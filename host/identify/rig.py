"""The robot's servos during a measurement: a few joints have torque, all others are limp; every tick is checked.

Angles are the servos' shafts', in the joints' sense: a joint's angle divided by the ratio of its drive. Goals go out
every tick, so that the servos' bus watchdogs stay quiet; on a real port the guardian lets go if this process dies.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from math import degrees, tau

from ..bus.base import JOINT_LABELS, JOINTS
from ..bus.dynamixel import table as t
from ..bus.dynamixel.bus import WATCHDOG_S, control_settings
from ..bus.dynamixel.calibration.data import Calibration, servo_of
from ..bus.dynamixel.guardian import Guardian
from ..bus.dynamixel.link import Link, ServoError, packet_of
from ..robot.model import Robot

BLOCK = (t.PRESENT_LOAD.address, t.PRESENT_TEMPERATURE.address + 1 - t.PRESENT_LOAD.address)
MOST_SILENT = 20  # ticks without an answer of a joint that moves: 0.1 s (chosen)
BEYOND_RAD = 0.12  # a joint this far past its sweep's ends is stopped: 7 deg (chosen)
OFF_TRIES = 10


@dataclass(frozen=True)
class Reading:
    """One servo's answer, when it was asked, and when it had answered."""

    asked_s: float
    answered_s: float
    position_rad: float
    load: float
    voltage_V: float


class Rig:
    """A robot's servos on an open link. ``wait`` lets time pass until the clock shows a time."""

    def __init__(
        self,
        robot: Robot,
        calibration: Calibration,
        link: Link,
        clock: Callable[[], float],
        wait_until: Callable[[float], None],
    ) -> None:
        self.robot, self.calibration, self.link = robot, calibration, link
        self.clock, self.wait_until = clock, wait_until
        self._per_rad = servo_of(robot).counts_per_turn / tau
        self._goals: dict[int, int] = {}
        self._silent = [0] * JOINTS
        self._allowed = [(-9.0, 9.0)] * JOINTS
        self._guardian: Guardian | None = None
        if link.port.is_real:
            packet = packet_of(link.protocol, t.TORQUE_ENABLE, dict.fromkeys(calibration.ids, 0))
            self._guardian = Guardian(link.port.ser.fileno(), packet)

    def prepare(self) -> None:
        """Look for all servos, let go of them, and write the settings for measuring. ServoError says what is wrong."""
        link, model = self.link, servo_of(self.robot)
        for joint, servo in enumerate(self.calibration.ids):
            if link.ping(servo) is None:
                raise ServoError(f"{self.name(joint)} does not answer: check its cable and power")
            link.set_up(servo, self.name(joint), control_settings(model))

    def name(self, joint: int) -> str:
        """Return a joint's name."""
        return f"{JOINT_LABELS[joint]} (id {self.calibration.ids[joint]})"

    def counts(self, joint: int, shaft_rad: float) -> int:
        """Return the servo's position for an angle of its shaft, within the joint's calibrated limits."""
        return self.calibration.joints[joint].limited_counts(shaft_rad, self._per_rad)

    def rounded_rad(self, joint: int, shaft_rad: float) -> float:
        """Return the angle that such a goal really means, after rounding and limits."""
        return self.calibration.joints[joint].angle_rad(self.counts(joint, shaft_rad), self._per_rad)

    @staticmethod
    def rounded_share(most: float) -> float:
        """Return the share of the stall torque that such a limit really means, after rounding."""
        return round(most * t.FULL_PWM) / t.FULL_PWM

    def allow(self, joint: int, low_rad: float, high_rad: float) -> None:
        """Set a joint's allowed range while it has torque; beyond it the rig lets go of it."""
        self._allowed[joint] = low_rad - BEYOND_RAD, high_rad + BEYOND_RAD

    def hold(self, joint: int, most: float) -> None:
        """Switch a joint's torque on at its present angle, with a share of its stall torque."""
        servo = self.calibration.ids[joint]
        if self._guardian is not None:
            self._guardian.beat(True)
        at = self.link.read(servo, t.PRESENT_POSITION)
        self._goals[joint] = min(max(at, 0), t.COUNTS_PER_TURN - 1)
        self._silent[joint] = 0
        self.link.write(servo, t.GOAL_PWM, round(most * t.FULL_PWM))
        self.link.write(servo, t.GOAL_POSITION, self._goals[joint])
        self.link.write(servo, t.TORQUE_ENABLE, 1)
        self.link.write(servo, t.WATCHDOG, round(WATCHDOG_S / t.WATCHDOG_TICK_S))

    def limit(self, joint: int, most: float | None) -> None:
        """Change a joint's share of its stall torque; None switches the torque off."""
        servo = self.calibration.ids[joint]
        if most is None:
            self.link.write_all(t.TORQUE_ENABLE, {servo: 0})
            self._goals.pop(joint, None)
            return
        self.link.write_all(t.GOAL_PWM, {servo: round(most * t.FULL_PWM)})
        if joint not in self._goals:
            self._goals[joint] = self.link.read(servo, t.PRESENT_POSITION)
            self.link.write_all(t.TORQUE_ENABLE, {servo: 1})

    def tell(self, goals_rad: Mapping[int, float]) -> None:
        """Send goals to joints that have torque; joints without a new goal get the last one again."""
        for joint, goal_rad in goals_rad.items():
            if joint in self._goals:
                self._goals[joint] = self.counts(joint, goal_rad)
        if self._goals:
            ids = self.calibration.ids
            self.link.write_all(t.GOAL_POSITION, {ids[joint]: counts for joint, counts in self._goals.items()})

    def ask(self, joints: Sequence[int]) -> dict[int, Reading]:
        """Ask joints; those that do not answer are missing. ServoError if that lasts, or if something is wrong."""
        if self._guardian is not None:
            self._guardian.beat(bool(self._goals))
            if not self._guardian.alive:
                raise ServoError("the process that lets go of the servos if this one dies has ended: start again")
        asked_s = self.clock()
        answers = self.link.read_all([self.calibration.ids[joint] for joint in joints], BLOCK)
        answered_s = self.clock()
        readings = {}
        for joint in joints:
            mount = self.calibration.joints[joint]
            answer = answers.get(mount.id)
            if answer is None:
                self._miss(joint)
                continue
            self._silent[joint] = 0
            if answer.alert:
                raise ServoError(f"{self.name(joint)} reports an error: look at it with caramelo servos status")
            at = mount.angle_rad(t.unpack(t.PRESENT_POSITION, answer.data, BLOCK[0]), self._per_rad)
            load = mount.sign * t.unpack(t.PRESENT_LOAD, answer.data, BLOCK[0]) * t.LOAD_SHARE
            volts = t.unpack(t.PRESENT_VOLTAGE, answer.data, BLOCK[0]) * t.VOLTS
            readings[joint] = Reading(asked_s, answered_s, at, load, volts)
            self._look(joint, at, t.unpack(t.PRESENT_TEMPERATURE, answer.data, BLOCK[0]), volts)
        return readings

    def _miss(self, joint: int) -> None:
        self._silent[joint] += 1
        if self._silent[joint] > MOST_SILENT and joint in self._goals:
            raise ServoError(f"{self.name(joint)} no longer answers: check its cable; all joints are limp")

    def _look(self, joint: int, at_rad: float, warm_C: int, volts: float) -> None:
        model, (low, high) = servo_of(self.robot), self._allowed[joint]
        if warm_C > model.hot_C:
            raise ServoError(f"{self.name(joint)} is at {warm_C} C, allowed {model.hot_C:g}: let it cool, then go on")
        if volts < model.low_voltage_V:
            raise ServoError(f"{self.name(joint)} has {volts:.1f} V, allowed {model.low_voltage_V:g}: charge it")
        if joint in self._goals and not low <= at_rad <= high:
            raise ServoError(
                f"{self.name(joint)} is at {degrees(at_rad):.0f} deg of its servo, allowed {degrees(low):.0f} .. "
                f"{degrees(high):.0f}: it was let go; check its calibration"
            )

    def release(self) -> None:
        """Let go of all joints until they confirm it; ServoError names those that never do."""
        self._goals.clear()
        for _ in range(3):  # no servo confirms a broadcast
            self.link.broadcast(t.TORQUE_ENABLE, 0)
        block = (t.TORQUE_ENABLE.address, 1)
        for _ in range(OFF_TRIES):
            answers = self.link.read_all(self.calibration.ids, block)
            holding = {servo: joint for joint, servo in enumerate(self.calibration.ids)
                       if servo not in answers or answers[servo].data[0]}  # fmt: skip
            if not holding:
                break
            self.link.write_all(t.TORQUE_ENABLE, dict.fromkeys(holding, 0))
        else:
            names = ", ".join(self.name(joint) for joint in holding.values())
            raise ServoError(f"{names}: did not confirm that torque is off: cut the power, then check the cable")
        self.link.write_all(t.WATCHDOG, dict.fromkeys(self.calibration.ids, 0))

    def close(self) -> None:
        """Let go, and end the guardian."""
        try:
            self.release()
        finally:
            if self._guardian is not None:
                self._guardian.close()
                self._guardian = None
