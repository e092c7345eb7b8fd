"""A user's own gait: how long a cycle takes, when each foot lifts and how long it stands; as the core's table."""

from itertools import pairwise
from typing import Annotated, Any

from pydantic import model_validator

from shared.gait.gaits import GAIT_NAMES
from shared.gait.table import MOVER_TABLE

from .values import Table, number, text

GaitName = Annotated[str, text("[a-z][a-z0-9-]{0,30}", "a gait's name: lower-case letters, digits, hyphens")]
Entry = tuple[str, int, tuple[Any, ...]]  # as in shared/gait/gaits.py
EVEN = (100, 100, 0)  # a swing's samples are evenly spaced, and the body moves evenly
PHASE = number(0.0, 0.999, "of the cycle")


class Lifts(Table):
    """When in the cycle each foot lifts."""

    FR: Annotated[float, PHASE]
    FL: Annotated[float, PHASE]
    RR: Annotated[float, PHASE]
    RL: Annotated[float, PHASE]

    @property
    def by_leg(self) -> tuple[float, float, float, float]:
        """In the core's order of legs."""
        return self.FR, self.FL, self.RR, self.RL


class OwnGait(Table):
    """A gait that consists only of its table. ``duty``: share of the cycle in which each foot stands."""

    name: GaitName
    cycle_s: Annotated[float, number(0.2, 20.0, "s")]
    duty: Annotated[float, number(0.5, 0.95, "of the cycle")]
    swing_height_m: Annotated[float, number(0.005, 0.3, "m")]
    lifts_at: Lifts

    @model_validator(mode="after")
    def _check(self) -> "OwnGait":
        if self.name in GAIT_NAMES:
            raise ValueError(f"name: value {self.name!r}: allowed: any name except {', '.join(GAIT_NAMES)}")
        feet = f"lifts_at: value {self.lifts_at.by_leg}: allowed: feet"
        if not self._rests():
            raise ValueError(f"{feet} that are all on the ground at some moment, where the robot can stop")
        if any(self._swinging(start) == 15 for start in self._events()):
            raise ValueError(f"{feet} of which at least one stands at any moment")
        return self

    @property
    def entry(self) -> Entry:
        """The gait as an entry of the registry; it begins where all feet stand."""
        begin, cycle_ms = self._rests()[0], round(1000 * self.cycle_s)
        starts = [*sorted(round(cycle_ms * ((event - begin) % 1)) for event in self._events()), cycle_ms]
        rows = [(b - a, self._swinging(begin + (a + b) / 2 / cycle_ms), b - a) for a, b in pairwise(starts) if b > a]
        return self.name, MOVER_TABLE, ((round(1000 * self.swing_height_m), *EVEN), tuple(rows))

    def _events(self) -> list[float]:
        """When a foot lifts or lands, share of the cycle; events closer than a thousandth count as one."""
        swing = 1 - self.duty
        return sorted({round(at + more, 3) % 1 for at in self.lifts_at.by_leg for more in (0.0, swing)})

    def _swinging(self, now: float) -> int:
        """Return the legs in the air, as bits; at an event, those that lift but not those that land."""
        in_air = [(now - at + 1e-6) % 1 < 1 - self.duty - 1e-3 for at in self.lifts_at.by_leg]
        return sum(air << leg for leg, air in enumerate(in_air))

    def _rests(self) -> list[float]:
        """Return the events at which no foot is in the air."""
        return [event for event in self._events() if not self._swinging(event) & self._swinging(event - 2e-3)]
