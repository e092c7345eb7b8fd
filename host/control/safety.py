"""Decides when the robot must sit down or let go, and remembers why: the first cause stays until it is reset.

Four actions, of which the worst counts: ``none``; ``sit``: stop walking, sit down, then let go; ``damp``: the bus has
already told the joints to brake and then let go, and nothing more is sent; ``limp``: let go at once, because sitting
down is no longer possible.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from math import cos, inf

from ..bus.base import JOINT_LABELS, JOINTS, Fault, Measured
from ..robot.model import Robot

ACTIONS = ("none", "sit", "damp", "limp")
SILENT_S = 0.2  # a joint that has not answered for this long is missing: ten ticks of 50 Hz (chosen)
SLOW_SILENT_S = 2.0  # the same for temperature and voltage, which come in turns (chosen)
LOW_FOR_S = 1.0  # shorter dips do not count: the voltage dips when all legs push (chosen)
FALLEN_RAD = 1.0  # roll or pitch beyond which no leg can help (chosen)
SLOW = ("limp", "rising", "sitting", "seated", "folding")  # states of the planner with the torque of standing up
MANY_MISSING = 3  # with more silent joints than a leg has, the bus is dead, not a servo (chosen)


@dataclass
class Safety:
    """Watches one robot. ``name`` is the bus's function for joint names, with servo ids if there are any."""

    robot: Robot
    name: Callable[[int], str] = JOINT_LABELS.__getitem__
    first: Fault | None = None
    action: str = "none"
    _low_since_s: float = field(default=inf, repr=False)

    @property
    def sentence(self) -> str:
        """Why the robot does not move, "" if it may."""
        return self.first.sentence if self.first else ""

    def update(self, measured: Measured, attitude_rad: tuple[float, float] | None = None) -> str:
        """Check one reading, and roll and pitch if they are known; return the present action."""
        for fault in self.faults(measured, attitude_rad):
            self.raise_fault(fault)
        return self.action

    def raise_fault(self, fault: Fault) -> None:
        """Latch a fault: take over a worse action, but keep the first cause."""
        if self.first is None:
            self.first = fault
        self.action = max(self.action, fault.action, key=ACTIONS.index)

    def tell_how_it_lies(self, attitude_rad: tuple[float, float] | None) -> None:
        """Update how a fallen robot lies now; it may have rolled on, or somebody may have turned it over."""
        if self.first is not None and self.first.cause == "fallen" and attitude_rad is not None:
            self.first = replace(self.first, sentence=how_it_lies(attitude_rad))

    def reset(self, measured: Measured, attitude_rad: tuple[float, float] | None = None) -> str:
        """Forget the faults, unless something is still wrong: then return its sentence, else ""."""
        self.first, self.action = None, "none"
        self.update(measured, attitude_rad)
        return self.sentence

    def faults(self, measured: Measured, attitude_rad: tuple[float, float] | None = None) -> Iterator[Fault]:
        """Yield what is wrong now, the worst first; the bus's own faults come first, because they explain the rest."""
        yield from measured.faults
        yield from self._silent(measured)
        if attitude_rad is not None and max(map(abs, attitude_rad)) > FALLEN_RAD:
            yield Fault("limp", "fallen", how_it_lies(attitude_rad))
        yield from self._tripped(measured)
        yield from self._hot(measured)
        yield from self._battery(measured)

    def _silent(self, measured: Measured) -> Iterator[Fault]:
        silent = [joint for joint in range(JOINTS) if measured.age_s[joint] > SILENT_S]
        if len(silent) > MANY_MISSING:
            yield Fault("limp", "bus", f"{len(silent)} joints do not answer: check the bus cable and the power")
        elif silent:
            names = ", ".join(self.name(joint) for joint in silent)
            yield Fault("sit", "missing", f"{names} does not answer: check its cable")
        stale = [joint for joint in range(JOINTS) if SLOW_SILENT_S < measured.slow_age_s[joint] < inf]
        if stale and not silent:
            yield Fault("sit", "stale", f"{self.name(stale[0])} no longer reports voltage and temperature")

    def _tripped(self, measured: Measured) -> Iterator[Fault]:
        for joint, error in enumerate(measured.error):
            if error:
                yield Fault("sit", "tripped", f"{self.name(joint)}: {error}")

    def _hot(self, measured: Measured) -> Iterator[Fault]:
        hot_C = self.robot.actuator.sit_C
        for joint, heat_C in enumerate(measured.temperature_C):
            if heat_C > hot_C:
                yield Fault(
                    "sit", "hot", f"{self.name(joint)} is hot: {heat_C:.0f} C, allowed {hot_C:.0f}; let it cool"
                )

    def _battery(self, measured: Measured) -> Iterator[Fault]:
        low_V = self.robot.actuator.low_V
        volts = measured.battery_V
        if volts is None or volts >= low_V:
            self._low_since_s = inf
            return
        self._low_since_s = min(self._low_since_s, measured.time_s)
        if measured.time_s - self._low_since_s >= LOW_FOR_S:
            yield Fault("sit", "battery", f"battery low: {volts:.1f} V, allowed {low_V:.1f}; charge it")


def lies_over(attitude_rad: tuple[float, float] | None) -> bool:
    """Return whether the robot lies on a side, on its back or on its nose, from where no leg can help it up."""
    return attitude_rad is not None and max(map(abs, attitude_rad)) > FALLEN_RAD


def how_it_lies(attitude_rad: tuple[float, float]) -> str:
    """Return how a fallen robot lies, by its roll and pitch, and what to do."""
    roll_rad, pitch_rad = attitude_rad
    if not lies_over(attitude_rad):
        return "the robot has fallen and lies on its belly: it can get up by itself; keep clear of its legs"
    if abs(roll_rad) > FALLEN_RAD:
        where = "right side" if roll_rad > 0 else "left side"
    elif cos(pitch_rad) < -cos(FALLEN_RAD):
        where = "back"
    else:
        where = "nose" if pitch_rad > 0 else "tail"
    return f"the robot has fallen over onto its {where}: put it on its feet, because it can't turn over by itself"


def torque_limit(robot: Robot, state: str) -> float:
    """Return the share of stall torque for a planner state: little while it stands up or sits down, else all."""
    return robot.stand.torque_fraction if state in SLOW else 1.0
