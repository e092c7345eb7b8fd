"""A step of one joint's goal, there and back, and the figures of its response."""

from dataclasses import dataclass, field

RISEN_FROM, RISEN_TO = 0.1, 0.9  # of the step: between them is the rise time
LAST_SHARE = 0.2  # of the step's time, at its end: the remaining error is taken from it


@dataclass
class Step:
    """From ``from_deg`` by ``by_deg`` at ``began_s``, back after ``seconds``, over after as long again."""

    node: int
    from_deg: float
    by_deg: float
    began_s: float
    seconds: float
    over: bool = False
    _answer: list[tuple[float, float]] = field(default_factory=list)  # s since the step, and deg, while it lasts
    _back: bool = False

    def take(self, now_s: float, position_deg: float | None) -> bool:
        """Take the joint's angle; return True when the goal has to go back, and again when the step is over."""
        passed_s = now_s - self.began_s
        if passed_s < self.seconds:
            if position_deg is not None:
                self._answer.append((passed_s, position_deg))
            return False
        self.over = passed_s >= 2 * self.seconds
        turned, self._back = self.over or not self._back, True
        return turned

    def told(self) -> str:
        """Return in words rise time, overshoot and remaining error; a load bends the joint before and after."""
        first_deg = self._answer[0][1] if self._answer else 0.0
        shares = [(at_s, (deg - first_deg) / self.by_deg) for at_s, deg in self._answer] if self.by_deg else []
        begun = next((at_s for at_s, share in shares if share >= RISEN_FROM), None)
        risen = next((at_s for at_s, share in shares if share >= RISEN_TO), None)
        if begun is None or risen is None:
            return f"a step of {self.by_deg:g} deg: the joint did not get there within {self.seconds:g} s"
        over = max(0.0, max(share for _, share in shares) - 1)
        last = [share for at_s, share in shares if at_s >= (1 - LAST_SHARE) * self.seconds]
        left_deg = self.by_deg * (1 - sum(last) / len(last)) if last else 0.0
        rise = f"10 to 90 % in {1000 * (risen - begun):.0f} ms"
        return f"a step of {self.by_deg:g} deg: {rise}, {100 * over:.0f} % over, {left_deg:.2f} deg left"
