"""What whole paths of a role's firmware cost on a Cortex-M4, in instructions, and the heap it leaves.

The firmware is as an image has it: hot functions in C and the rest frozen.
"""

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...util.errors import UserError
from ...util.extras import not_installed

BUDGET = Path(__file__).with_name("path_budget.json")
NOTHING = "nothing"  # the name of a reading round a call that does nothing
HEAP_BYTES = 103168  # what the PYBV11 port leaves of an STM32F405's memory
TIMEOUT_S = 300.0


@dataclass(frozen=True)
class Cost:
    """What one path took: instructions of the dearest call and of the middle one, and what the dearest may be."""

    name: str
    most: int
    median: int
    budget: int

    @property
    def ok(self) -> bool:
        return self.most <= self.budget


@dataclass(frozen=True)
class RoleFigures:
    """Heap left after set-up and after the run, in bytes of HEAP_BYTES; the paths; complaints of the chip's model."""

    free: int
    left: int
    paths: list[Cost]
    complaints: list[str]
    least_free: int = HEAP_BYTES // 4  # a quarter is to be free whatever was done

    @property
    def ok(self) -> bool:
        """True if every path is within its budget, memory is left, and nothing was complained of."""
        return all(path.ok for path in self.paths) and self.left >= self.least_free and not self.complaints

    def told(self) -> dict[str, Any]:
        """Return the figures as they are printed for machines."""
        paths = {path.name: {"median": path.median, "most": path.most, "budget": path.budget} for path in self.paths}
        return {"free": self.free, "left": self.left, "paths": paths, "complaints": self.complaints, "ok": self.ok}


def figures_of(role: str, micropython: Path, jobs: int, minutes: int) -> RoleFigures:
    """Build a role's VM and return its figures; let it operate for ``minutes`` as well (operate.py).

    UserError for what is missing, RuntimeFailure if it ends early.
    """
    from ...boards.build.frozen import frozen_sources
    from ...boards.build.vm import build_vm
    from .operate import operated
    from .paths_gait import gait_figures
    from .paths_joint import joint_figures

    if missing := not_installed("unicorn"):
        raise UserError(missing)
    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder:
        work = Path(folder)
        tree = frozen_sources(role, "caramelo", work / "frozen")
        image = build_vm(micropython.absolute(), tree, HEAP_BYTES, work, jobs)
    figures = {"joint": joint_figures, "gait": gait_figures}[role](image)
    if minutes:
        figures.complaints.extend(operated(role, image, minutes))
    return figures


def filled(script: str, values: Mapping[str, object]) -> str:
    """Return a script with values in the place of their {names}."""
    for name, value in values.items():
        script = script.replace(f"{{{name}}}", repr(value))
    return script


def measured(names: list[str], marks: list[int]) -> dict[str, list[int]]:
    """Return what each path cost, call by call; ``marks`` are the readings before and after, by ``names``."""
    spent: dict[str, list[int]] = {}
    for name, begin, end in zip(names, marks[::2], marks[1::2], strict=True):
        spent.setdefault(name, []).append(end - begin)
    empty = min(spent.pop(NOTHING))
    return {name: [cost - empty for cost in costs] for name, costs in spent.items()}
