"""One interface to the joints of any robot: read what they measure, write goals, let go.

Twelve joints, index leg * 3 + joint (legs FR, FL, RR, RL; hip, thigh, calf), SI units, the signs of the robot
file. One call per tick each: ``measured = bus.read()``, then ``bus.write(goals)``. Neither blocks longer than a tick,
nor do ``try_torque``, ``try_clear_faults``, ``torque(False)``, ``limit_torque`` and ``emergency_stop``: a joint that
does not answer keeps its last values, and their age grows. Letting go is repeated until the joints confirm it.
"""

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from math import inf, isfinite
from typing import Self

from ..robot.model import JOINT_NAMES, LEG_NAMES

JOINTS = 12
JOINT_LABELS = tuple(f"{leg} {joint}" for leg in LEG_NAMES for joint in JOINT_NAMES)
NEVER = (inf,) * JOINTS
UNKNOWN = (0.0,) * JOINTS


@dataclass(frozen=True)
class Fault:
    """Something wrong: how the robot reacts (host/control/safety.py), what is wrong, what to do about it."""

    action: str
    cause: str
    sentence: str


@dataclass(frozen=True)
class Measured:
    """The joints' last reports; twelve values each.

    ``load`` is the drive's share of its stall torque, -1 .. 1. ``error`` is "" or the joint's own error, such
    as "overload" or "hot". ``age_s`` is how old position, speed and load are, ``slow_age_s`` how old
    temperature, voltage and error; inf for a joint that never answered. ``faults`` is what the bus found wrong with
    the joints as a whole.
    """

    time_s: float = 0.0
    position_rad: tuple[float, ...] = UNKNOWN
    speed_rad_s: tuple[float, ...] = UNKNOWN
    load: tuple[float, ...] = UNKNOWN
    temperature_C: tuple[float, ...] = UNKNOWN
    voltage_V: tuple[float, ...] = UNKNOWN
    error: tuple[str, ...] = ("",) * JOINTS
    age_s: tuple[float, ...] = NEVER
    slow_age_s: tuple[float, ...] = NEVER
    faults: tuple[Fault, ...] = ()

    @property
    def complete(self) -> bool:
        """True once every joint has reported its position."""
        return inf not in self.age_s

    @property
    def battery_V(self) -> float | None:
        """Highest voltage that any joint reports (cables only lose some), or None before the first report."""
        known = [volts for volts, age in zip(self.voltage_V, self.slow_age_s, strict=True) if age < inf]
        return max(known, default=None)


@dataclass
class Counters:
    """Counts of what went over the bus, and how much of it was bad. Bad answers are counted and never used.

    ``sent`` counts the answers that were asked for. ``late`` are answers that came after they had been given up: each
    of them already counts as ``lost``, so it is not another error.
    """

    sent: int = 0
    answered: int = 0
    lost: int = 0
    corrupted: int = 0
    wrong: int = 0
    late: int = 0
    refused: int = 0
    per_joint_lost: list[int] = field(default_factory=lambda: [0] * JOINTS)

    @property
    def errors(self) -> int:
        """All bad or missing answers."""
        return self.lost + self.corrupted + self.wrong + self.refused

    def as_dict(self) -> dict[str, object]:
        """Return the counters as plain values for JSON."""
        return {**asdict(self), "errors": self.errors}


class Bus(ABC):
    """The joints behind one kind of bus. Use it as a context manager: leaving the block lets go of the joints."""

    kind = "abstract"

    def __init__(self) -> None:
        self.counters = Counters()

    @abstractmethod
    def open(self) -> None:
        """Connect, check that all joints are there and set them up with torque off. UserError says what is wrong."""

    @abstractmethod
    def read(self) -> Measured:
        """Ask all joints and return their values as known now."""

    @abstractmethod
    def write(self, goals_rad: Sequence[float]) -> None:
        """Send twelve goals; they are held only while torque is on. ValueError for anything but finite angles."""

    @abstractmethod
    def torque(self, on: bool) -> None:
        """Switch torque on, so that the joints hold their goals, starting from where they are; or off."""

    def try_torque(self) -> bool:
        """Switch torque on without taking longer than a tick; False: call again in the next tick.

        UserError if it can't be done. A bus that needs only one exchange does it at once.
        """
        self.torque(True)
        return True

    def try_clear_faults(self) -> bool:
        """Clear the joints' latched faults, if they latch any; like ``try_torque``, but arms nothing.

        UserError if a cause is still there.
        """
        return True

    @abstractmethod
    def limit_torque(self, fraction: float) -> None:
        """Limit every drive to a share of its stall torque, 0 .. 1: the robot file's stand.torque_fraction."""

    @abstractmethod
    def emergency_stop(self) -> None:
        """Let go at once, whatever else is going on; may be called twice, and from another thread than the others."""

    @abstractmethod
    def close(self) -> None:
        """Let go and disconnect; may be called twice."""

    @abstractmethod
    def now(self) -> float:
        """Return the bus's time, s: monotonic, or simulated."""

    def name(self, joint: int) -> str:
        """Return a joint's name, leg first; buses with numbered joints add the number."""
        return JOINT_LABELS[joint]

    @property
    def firmware(self) -> str:
        """The firmware that the joints report; "" if they report none."""
        return ""

    @property
    def warnings(self) -> tuple[str, ...]:
        """Things that ``open`` found to work, but badly: one sentence each, with what to do."""
        return ()

    def __enter__(self) -> Self:
        self.open()
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def checked_goals(goals_rad: Sequence[float]) -> Sequence[float]:
    """Return twelve finite angles or raise ValueError: a wrong goal must never reach a joint."""
    if len(goals_rad) != JOINTS:
        raise ValueError(f"{len(goals_rad)} goals, allowed exactly {JOINTS}")
    for joint, angle_rad in enumerate(goals_rad):
        if not isfinite(angle_rad):
            raise ValueError(f"goal of joint {joint}: value {angle_rad}: allowed: a finite angle")
    return goals_rad


def checked_fraction(fraction: float) -> float:
    """Return a share 0 .. 1 or raise ValueError."""
    if not 0.0 <= fraction <= 1.0:
        raise ValueError(f"torque fraction {fraction}: allowed 0 .. 1")
    return fraction
