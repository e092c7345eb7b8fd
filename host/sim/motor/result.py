"""The results of a scenario of the simulated joint: its figures, and the bench with its record."""

from dataclasses import dataclass
from typing import Any

from .bench import Bench


@dataclass
class Result:
    """The figures, as they go into JSON, and the bench with its record."""

    name: str
    figures: dict[str, Any]
    bench: Bench

    @property
    def ok(self) -> bool:
        """Whether the scenario's bar was reached."""
        return bool(self.figures["ok"])
