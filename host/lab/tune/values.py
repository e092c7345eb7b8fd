"""The values of a robot file to search, their bounds, and the robot for a choice of them.

The search covers chosen values: lines marked chosen or tuned, and the trot's own numbers that the file leaves out. It
leaves out values that the simulators can't judge, such as the gains of a joint's own loops, and values for safety.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from pathlib import Path
from typing import Any

from sim2d.model import GRAVITY_M_S2

from ...robot.builds import unbuildable
from ...robot.checks import complaints
from ...robot.file import find, load_robot, read_toml
from ...robot.model import Robot
from ...robot.rewrite import NewValue, rewritten, sources, spreads
from ...robot.trot_tuning import GAIT, NUMBERS
from ...util.errors import UserError
from ...util.files import read_text

OURS = ("chosen", "tuned")  # sources of values that may be changed
DIGITS = 4  # of a value in the file, and so in its trials
LIMIT = "speed_limits.vx_m_s"
# Least and most in leg lengths, as a robot stands. The trot's own numbers have theirs in host/robot/trot_tuning.py.
STANCE = {
    "stance.rest_height_m": (0.55, 0.93),
    "stance.foot_forward_m": (-0.12, 0.12),
    "stance.foot_outward_m": (-0.08, 0.25),
}
LIMIT_FROUDE = (0.03, 0.4)  # of sqrt(g x leg): the speed limit, where speed is what is tuned for


@dataclass(frozen=True)
class Searched:
    """A value that is searched: its dotted key, value now, the least and the most, and its meaning for a comment."""

    key: str
    now: float
    low: float
    high: float
    meaning: str = ""

    def at(self, share: float) -> float:
        """Return the value at a share of the way from least to most, with the file's digits."""
        return float(f"{self.low + (self.high - self.low) * min(1.0, max(0.0, share)):.{DIGITS}g}")

    @property
    def share(self) -> float:
        """The share of the present value."""
        return (self.now - self.low) / (self.high - self.low)


class RobotFile:
    """A robot file: its text, how much its joints differ, and robots that differ from it in some values."""

    def __init__(self, name_or_path: str) -> None:
        self.path: Path = find(name_or_path)
        self.robot = load_robot(name_or_path)
        self.text = read_text(self.path)
        self.spreads = spreads(self.text)
        self._data = read_toml(self.path)

    def searched(self, gait: str, speed: bool) -> list[Searched]:
        """Return the values to search: a gait's numbers only for that gait, the speed limit only for the goal speed.

        UserError if there are none.
        """
        marks, leg_m = sources(self.text), self.robot.geometry.leg_m
        froude_m_s = sqrt(GRAVITY_M_S2 * leg_m)
        bounds = {key: (low * leg_m, high * leg_m, "") for key, (low, high) in STANCE.items()}
        if speed:
            bounds[LIMIT] = (LIMIT_FROUDE[0] * froude_m_s, LIMIT_FROUDE[1] * froude_m_s, "")
        if gait == GAIT:
            bounds |= {f"trot.{key}": (number.least, number.most, number.meaning) for key, number in NUMBERS.items()}
        found = []
        for key, (low, high, meaning) in bounds.items():
            now = self._value(key)
            if marks.get(key, OURS[0] if meaning else "") in OURS:
                found.append(Searched(key, now, min(low, now), max(high, now), meaning))
        if not found:
            raise UserError(f"{self.path}: nothing to search: none of {', '.join(bounds)} is marked "
                            f"{' or '.join(OURS)}")
        return found

    def _value(self, key: str) -> float:
        table, _, name = key.partition(".")
        given = self._data.get(table, {}).get(name)
        return float(NUMBERS[name].usual if given is None else given)

    def like(self, values: Mapping[str, float]) -> Robot | None:
        """Return the robot with these values, None if it can't be used."""
        data: dict[str, Any] = dict(self._data)
        for key, value in values.items():
            table, _, name = key.partition(".")
            data[table] = {**data.get(table, {}), name: value}
        robot = Robot.model_validate(data)
        refused = next(complaints(robot), None) or next(unbuildable(robot), None)
        return None if refused else robot

    def rewritten(self, searched: Sequence[Searched], values: Mapping[str, float]) -> str:
        """Return the file's text with these values, marked tuned where they are not what they were."""
        changed = {each.key: NewValue(values[each.key], each.meaning) for each in searched
                   if values[each.key] != each.now}
        return rewritten(self.text, changed, "tuned")
