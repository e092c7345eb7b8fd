"""Joint goals from a program in place of the planner's, checked in every tick: limits, steps, a dead-man.

A program that sends goals moves the joints itself while the planner stands. Each joint moves no faster than the program
asked and never beyond its limits. If the program falls silent or is done, the joints return to the planner's stance, at
the speed at which the robot stands up.
"""

from collections.abc import Sequence
from math import inf

from ..bus.base import JOINTS, checked_goals
from ..robot.model import Robot
from .arbiter import DEAD_MAN_S

BACK_RAD = 1e-3  # this close to the planner's goals the joints are back: less than a servo's step of 1.5 mrad


class JointStream:
    """One robot's stream; ``rate_hz`` ticks a second."""

    def __init__(self, robot: Robot, rate_hz: int) -> None:
        self.limits_rad = tuple(limit for leg in range(4) for limit in robot.joint_limits_rad(leg))
        self.fastest_rad_s = robot.actuator.fastest_rad_s
        self.usual_rad_s = robot.stand.joint_rad_s
        self._period_s = 1 / rate_hz
        self._speed_rad_s = self.usual_rad_s
        self._goals: list[float] | None = None  # of the last tick; None: the planner moves the joints
        self._wish: list[float] | None = None  # None: on the way back to the planner
        self._heard_s = -inf

    @property
    def active(self) -> bool:
        """True while the joints are not back at the planner's goals."""
        return self._goals is not None

    @property
    def open(self) -> bool:
        """True from ``begin`` to ``end``."""
        return self._wish is not None

    @property
    def wished(self) -> list[float]:
        """The program's last goals; None once it is done."""
        return self._wish or []

    def begin(self, goals_rad: Sequence[float], speed_rad_s: float, now_s: float) -> None:
        """Take over the joints at their present goals; ``speed_rad_s``: the top speed of each."""
        self._goals = self._wish = list(checked_goals(goals_rad))
        self._speed_rad_s, self._heard_s = min(speed_rad_s, self.fastest_rad_s), now_s

    def wish(self, goals_rad: Sequence[float], now_s: float) -> list[int]:
        """Take twelve goals, rad, and return the joints whose goal lies beyond a limit and was limited.

        ValueError, and nothing changes, for anything but twelve finite angles. Nothing is taken after ``end``.
        """
        goals = list(checked_goals(goals_rad))
        if self._wish is None:
            return []
        self._wish, self._heard_s = [self._within(joint, goals[joint]) for joint in range(JOINTS)], now_s
        return [joint for joint in range(JOINTS) if self._wish[joint] != goals[joint]]

    def end(self) -> None:
        """Give the joints back to the planner, slowly."""
        self._wish = None

    def drop(self) -> None:
        """Forget everything: nothing holds the joints any more."""
        self._goals = self._wish = None

    def fresh(self, now_s: float) -> bool:
        """True while the last goals are younger than the dead-man's time."""
        return now_s - self._heard_s <= DEAD_MAN_S

    def goals(self, planned_rad: list[float], now_s: float) -> list[float]:
        """Return this tick's goals: one step towards the program's goals, or back to the planner's."""
        if self._goals is None:
            return planned_rad
        target, speed_rad_s = planned_rad, self.usual_rad_s
        if self._wish is not None and self.fresh(now_s):
            target, speed_rad_s = self._wish, self._speed_rad_s
        most = speed_rad_s * self._period_s
        self._goals = [
            self._within(joint, now + max(-most, min(most, target[joint] - now)))
            for joint, now in enumerate(self._goals)
        ]
        if self._wish is None and all(abs(a - b) <= BACK_RAD for a, b in zip(self._goals, planned_rad, strict=True)):
            self._goals = None
            return planned_rad
        return list(self._goals)

    def _within(self, joint: int, angle_rad: float) -> float:
        low, high = self.limits_rad[joint]
        return max(low, min(high, angle_rad))
