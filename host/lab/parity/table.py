"""What each function of the core takes from the heap, and its largest intermediate: `caramelo parity --memory`.

Everything is measured in the VMs and on checked integers, and is the same in every run.
"""

from dataclasses import dataclass
from pathlib import Path

from ...boards.runtimes import Unix, Wasi
from .budget import is_added, read_budget
from .figures import Allocation, Promise, allocations, largest_values, promises


@dataclass(frozen=True)
class Row:
    """A function: bits of its largest intermediate; bytes of its frame in bytecode, kept, and as viper."""

    name: str
    bits: int
    frame: int
    kept: int
    viper: int


def measure_rows(sources: Path, work: Path) -> list[Row]:
    """Measure all functions; needs the WASI and the unix VM."""
    return rows_of(
        largest_values(sources, work / "checked"),
        promises(sources, work / "promises"),
        allocations(Wasi(), sources, work / "wasi"),
        allocations(Unix("viper"), sources, work / "unix"),
    )


def rows_of(
    largest: dict[str, tuple[int, str | None]],
    bound: dict[str, Promise],
    bytecode: dict[str, Allocation],
    viper: dict[str, Allocation],
) -> list[Row]:
    """Return the rows of what was measured: one for each function of a tick, but for walks in added gaits."""
    budget = read_budget()
    return [
        Row(name, max(1, value.bit_length()), bytecode[name].total, bytecode[name].kept + viper[name].kept,
            viper[name].total)
        for name, (value, _) in largest.items() if bound[name].ticks and not is_added(name, budget)
    ]  # fmt: skip
