"""Moves single servos gently while nothing is known about them: little torque, small slow steps, then lets go."""

from collections.abc import Callable

from .. import table as t
from ..bus import WATCHDOG_S
from ..link import Link, ServoError

TORQUE = 0.2  # of the stall torque: lifts a hanging leg, and a hand can hold it (chosen)
NUDGE_COUNTS = 80  # 7 deg at the servo: easy to see, harmless (chosen)
STEP_COUNTS = 4
STEP_S = 0.02  # with the steps above 18 deg/s
SETTLE_S = 0.2
MOVED_COUNTS = NUDGE_COUNTS // 2


class Bench:
    """The servos of a robot on a stand. ``wait`` lets time pass."""

    def __init__(self, link: Link, wait: Callable[[float], None]) -> None:
        self.link, self._wait = link, wait
        self._goals: dict[int, int] = {}

    def place(self, servo: int, joint: int, angle_rad: float) -> None:
        """In a simulation turn the servo's link, which the person says is ``joint``, in place of the person's hand."""

    def position(self, servo: int) -> int:
        """Return a servo's position in counts."""
        return self.link.read(servo, t.PRESENT_POSITION)

    def prepare(self, servo: int) -> None:
        """Let go, and write the settings that moving needs."""
        self.link.set_up(servo, f"servo id {servo}", [(t.OPERATING_MODE, t.POSITION_CONTROL)])

    def release(self, servos: list[int]) -> None:
        """Let go of servos, confirmed."""
        for servo in servos:
            self.link.write(servo, t.TORQUE_ENABLE, 0)
            self.link.write(servo, t.WATCHDOG, 0)

    def nudge(self, servo: int) -> int:
        """Move a servo a little and back; return +1 if it went to more counts, -1 if to fewer.

        A joint at one end of its range goes the other way. ServoError if it goes neither way.
        """
        start = self.position(servo)
        for direction in (1, -1):
            goal = start + direction * NUDGE_COUNTS
            if 0 <= goal < t.COUNTS_PER_TURN and self._try(servo, start, goal):
                return direction
        raise ServoError(f"servo id {servo} does not move: check that nothing holds or blocks its joint")

    def _try(self, servo: int, start: int, goal: int) -> bool:
        try:
            self.move({servo: goal})
            moved = abs(self.position(servo) - start) >= MOVED_COUNTS
            self.move({servo: start})
        finally:
            self.release([servo])
        return moved

    def move(self, goals: dict[int, int]) -> None:
        """Move servos to goals together, slowly, with little torque; they hold until they are released."""
        link = self.link
        now = {servo: self.position(servo) for servo in goals}
        for servo, counts in now.items():
            link.write(servo, t.GOAL_PWM, round(TORQUE * t.FULL_PWM))
            link.write(servo, t.GOAL_POSITION, min(max(counts, 0), t.COUNTS_PER_TURN - 1))
            link.write(servo, t.TORQUE_ENABLE, 1)
            link.write(servo, t.WATCHDOG, round(WATCHDOG_S / t.WATCHDOG_TICK_S))
        while now != goals:
            for servo, goal in goals.items():
                step = max(-STEP_COUNTS, min(STEP_COUNTS, goal - now[servo]))
                now[servo] += step
            self._goals = {s: min(max(c, 0), t.COUNTS_PER_TURN - 1) for s, c in now.items()}
            self.hold(STEP_S)
        self.hold(SETTLE_S)

    def hold(self, seconds: float) -> None:
        """Wait while the servos hold; sending the goals again and again keeps their watchdogs quiet."""
        for _ in range(round(seconds / STEP_S)):
            self.link.write_all(t.GOAL_POSITION, self._goals)
            self._wait(STEP_S)
