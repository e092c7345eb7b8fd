"""What a controller has to tell of a run besides its goals. Needs nothing, so a robot without numpy can use it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Note:
    """Something the controller had to tell during a run: when, what, and why in a sentence."""

    time_s: float
    what: str
    why: str
