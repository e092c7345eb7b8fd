"""A controller's notes on a run. Imports nothing, so a robot without numpy can use it."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Note:
    """A note of the controller during a run: when, what, and why in a sentence."""

    time_s: float
    what: str
    why: str
