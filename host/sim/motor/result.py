"""The results of a scenario of the simulated joint: its figures, and the bench with its record."""

from dataclasses import dataclass
from typing import Any

from shared.wire import names as w

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


def enabled(bench: Bench) -> bool:
    """Return whether the joint still follows its commands."""
    return int(bench.state.drive_state) == w.STATE_OPERATION_ENABLED
