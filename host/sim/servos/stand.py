"""A robot on a stand to try the calibration with: emulated servos mounted in an unknown way.

Ids are shuffled, signs are flipped and zeros are off; a hand that turns joints is part of it. No real time passes.
"""

import random

from ...bus.base import JOINT_LABELS, JOINTS
from ...bus.dynamixel.calibration.bench import Bench
from ...bus.dynamixel.calibration.data import Calibration, counts_per_rad, joint_from, limits_rad, servo_of
from ...bus.dynamixel.link import Link, protocol_of
from ...robot.model import Robot
from ...robot.poses import rest_pose_rad
from ...util.console import say
from ..plant import JointPlant
from .bus import EmulatedBus
from .loopback import LoopbackPort

FARTHEST_OFF = 150  # counts: horns go on in steps of 16 deg, so a joint is at most half a step off (assumed)


def hidden_mounting(robot: Robot, seed: int) -> Calibration:
    """Return how the servos of an imaginary robot are mounted: unplanned, but possible."""
    chance = random.Random(f"mounting {seed}")
    ids = chance.sample(range(1, 40), JOINTS)
    middle = servo_of(robot).counts_per_turn // 2
    joints = []
    for joint, ((low, high), per_rad) in enumerate(zip(limits_rad(robot), counts_per_rad(robot), strict=True)):
        sign = chance.choice((-1, 1))
        zero = middle - sign * round((low + high) / 2 * per_rad) + chance.randint(-FARTHEST_OFF, FARTHEST_OFF)
        joints.append(joint_from(robot, joint, ids[joint], sign, zero))
    return Calibration(robot.name, tuple(joints))


class SimulatedBench(Bench):
    """Emulated servos on a stand, and hands."""

    def __init__(self, robot: Robot, truth: Calibration) -> None:
        self.truth = truth
        self.plant = JointPlant(robot, rest_pose_rad(robot))
        self.bus = EmulatedBus(robot, self.plant, truth, protocol_of(robot))
        self._now_s = 0.0
        port = LoopbackPort(self.bus, lambda: self._now_s)
        super().__init__(Link(port, self.bus.protocol), self._pass_time)

    def place(self, servo: int, joint: int, angle_rad: float) -> None:
        """See Bench: turns the joint that the servo really drives."""
        self.plant.push(self.truth.ids.index(servo), angle_rad)

    def nudge(self, servo: int) -> int:
        """See Bench; also says what a person at the robot would see."""
        joint = self.truth.ids.index(servo)
        direction = super().nudge(servo)
        way = "+" if direction * self.truth.joints[joint].sign > 0 else "-"
        say(f"  (simulated: {JOINT_LABELS[joint]} went to {way} and back)")
        return direction

    def _pass_time(self, seconds: float) -> None:
        self._now_s += seconds
        self.bus.advance(self._now_s)
