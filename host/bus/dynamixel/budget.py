"""How long one control cycle keeps the bus busy: bytes on the wire and waits for the USB adapter.

Counted from the packet formats of the e-manual. Not counted: the servos' own gaps between answers at return
delay 0, which the e-manual does not give.
"""

from dataclasses import dataclass

from ..base import JOINTS
from . import table as t

BITS_PER_BYTE = 10  # start, eight, stop
SLICE = 3  # servos that report the slow values each cycle
ROUNDS = 2  # requests per cycle: fast values of all servos, slow values of three
WELL_SET_LATENCY_MS = 1
USABLE = 0.8  # the planner and the scheduler need the rest of the cycle (chosen)


@dataclass(frozen=True)
class Budget:
    """One cycle: the bytes of each packet, and how much of the cycle's time they take."""

    baud: int
    rate_hz: int
    latency_ms: float
    goals: int
    questions: int
    answers: int

    @property
    def bytes(self) -> int:
        """All bytes of a cycle."""
        return self.goals + self.questions + self.answers

    @property
    def wire_ms(self) -> float:
        """Time on the wire."""
        return 1000 * BITS_PER_BYTE * self.bytes / self.baud

    @property
    def total_ms(self) -> float:
        """Time on the wire and waiting for the adapter."""
        return self.wire_ms + ROUNDS * self.latency_ms

    @property
    def cycle_ms(self) -> float:
        """Time available."""
        return 1000 / self.rate_hz

    @property
    def fits(self) -> bool:
        """True if it leaves time for the rest."""
        return self.total_ms <= USABLE * self.cycle_ms

    def as_dict(self) -> dict[str, object]:
        """Return the figures as plain values for JSON."""
        return {
            "baud": self.baud,
            "rate_hz": self.rate_hz,
            "latency_ms": self.latency_ms,
            "bytes": {"goals": self.goals, "questions": self.questions, "answers": self.answers},
            "wire_ms": round(self.wire_ms, 4),
            "total_ms": round(self.total_ms, 4),
            "cycle_ms": round(self.cycle_ms, 4),
            "fits": self.fits,
        }

    def sentence(self) -> str:
        """Return the figures in words."""
        verdict = "fits" if self.fits else "does not fit: raise the baud rate, or lower control.rate_hz"
        return (
            f"bus budget: {self.bytes} bytes a cycle at {self.baud} baud = {self.wire_ms:.2f} ms; with {ROUNDS} waits "
            f"of {self.latency_ms:g} ms {self.total_ms:.2f} of {self.cycle_ms:.1f} ms ({self.rate_hz} Hz): {verdict}"
        )


def budget(baud: int, rate_hz: int, protocol: float = 2.0, latency_ms: float = WELL_SET_LATENCY_MS) -> Budget:
    """Return the budget of twelve servos; the slow slice at its largest."""
    slow = max(t.SLOW_BLOCK[1], t.STATE_BLOCK[1])
    goal = 1 + t.GOAL_POSITION.size
    if protocol == 1.0:
        frame, question, asked, answer = 8, 7, 3, 6
    else:
        frame, question, asked, answer = 14, 14, 1, 11
    questions = ROUNDS * question + (JOINTS + SLICE) * asked
    answers = JOINTS * (answer + t.FAST_BLOCK[1]) + SLICE * (answer + slow)
    return Budget(baud, rate_hz, latency_ms, frame + JOINTS * goal, questions, answers)
