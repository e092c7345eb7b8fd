"""What each function costs and needs: gathered from the runtimes, one row a function."""

import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...boards.runtimes import CortexM, CPython, Runtime, Unix, Wasi
from .check import call
from .sources import add_floats

VECTORS = 8  # random ones whose cost is averaged
CHECKED_VECTORS = 24
ALLOCATION_VECTORS = 24
COUNTED = {  # whose instructions on a Cortex-M4 are counted, by module
    "fixed": ("sin_q15", "isqrt", "atan2_brad"),
    "leg": ("leg_inverse",),
    "pid": ("pid_step",),
    "joint": ("current_step",),
}


@dataclass(frozen=True)
class Allocation:
    """Bytes that one call takes at most; ``total`` counts frames that are given back, ``locked`` no heap at all."""

    total: int
    kept: int
    locked: bool


@dataclass(frozen=True)
class Promise:
    """What the registry says of a function: where it is from, and whether it belongs to a tick.

    ``name`` is the function's, as in "body.leg.leg_inverse" for shared/body/leg.py.
    """

    name: str
    ticks: bool


def modules_of(runtime: Runtime, tree: Path) -> list[str]:
    """Return the modules that have vectors."""
    return list(runtime.ask(tree, call("about"))["modules"])


def promises(sources: Path, work: Path) -> dict[str, Promise]:
    """Return the registry's promises by "module.probe"."""
    runtime = CPython()
    tree = runtime.prepare(sources, work)
    found = {}
    modules = modules_of(runtime, tree)
    for module, answer in zip(modules, runtime.ask_each(tree, [call("register", one) for one in modules]), strict=True):
        for row in answer["probes"]:
            name = f"{row['source'].removeprefix('shared.')}.{row['name'].partition(':')[0]}"
            found[f"{module}.{row['name']}"] = Promise(name, row["ticks"])
    return found


def fuel(sources: Path, work: Path) -> dict[str, int]:
    """Return what one call of each function costs in the WASI VM, exact: the same in every run."""
    runtime = Wasi(counting=True)
    tree = runtime.prepare(sources, work)
    found = {}
    for module in modules_of(runtime, tree):
        rows = runtime.ask(tree, _measure("fuel", module, VECTORS))["rows"]
        marks = iter(runtime.marks)
        for name, vectors, turns in rows:
            burnt = sum(_between(next(marks), next(marks), next(marks)) for _ in range(vectors))
            found[f"{module}.{name}"] = round(burnt / turns / vectors)
    return found


def instructions(runtime: CortexM, sources: Path, work: Path) -> dict[str, int]:
    """Return the most instructions any of some calls of COUNTED takes on a Cortex-M4, from its arguments to its result.

    That is: the caller's bytecode for the call included, the loop round it not.
    """
    tree = runtime.prepare(sources, work)
    found = {}
    for module, names in COUNTED.items():
        rows = runtime.ask(tree, _measure("instructions", module, names, VECTORS))["rows"]
        marks = iter(runtime.marks)
        for name, vectors in rows:
            calls = []
            for _ in range(vectors):
                four, eight = (_between(next(marks), next(marks), next(marks)) for _ in range(2))
                calls.append((eight - four) // 4)
            found[f"{module}.{name}"] = max(calls)
    return found


def _between(start: int, empty: int, full: int) -> int:
    """Return what calls cost by the marks before an empty loop, behind it, and behind the loop of calls."""
    return (full - empty) - (empty - start)


def _rows(runtime: Runtime, tree: Path, function: str, *arguments: object) -> Iterator[list[Any]]:
    """Yield what a function of probe/measure.py says of each function, its name as "module.probe" first."""
    for module in modules_of(runtime, tree):
        for name, *row in runtime.ask(tree, _measure(function, module, *arguments))["rows"]:
            yield [f"{module}.{name}", *row]


def microseconds(runtime: Runtime, sources: Path, work: Path, repeats: int) -> dict[str, float]:
    """Return the median microseconds of one call of each function."""
    return {name: float(us) for name, us in _rows(runtime, runtime.prepare(sources, work), "timing", VECTORS, repeats)}


def loop_microseconds(sources: Path, work: Path, turns: int) -> float:
    """Return the CPython microseconds of ``turns`` turns of ``x = x * 3 + i & 0xFFFF``: how fast the machine is."""
    runtime = CPython()
    return float(runtime.ask(runtime.prepare(sources, work), _measure("loop", turns))["us"])


def float_microseconds(runtime: Unix, sources: Path, work: Path, repeats: int) -> dict[str, float]:
    """Return microseconds of the float reference's counterparts; nothing if the checkout's tests are not here."""
    tree = Unix("source").prepare(sources, work)  # it reads the robots by name
    if not add_floats(tree):
        return {}
    return {name: float(us) for name, us in runtime.ask(tree, _measure("floats", repeats))["rows"]}


def allocations(runtime: Wasi | Unix, sources: Path, work: Path) -> dict[str, Allocation]:
    """Return what one call of each function takes from the heap at most."""
    rows = _rows(runtime, runtime.prepare(sources, work), "allocation", ALLOCATION_VECTORS)
    return {name: Allocation(total, kept, locked) for name, _, total, kept, locked in rows}


def largest_values(sources: Path, work: Path) -> dict[str, tuple[int, str | None]]:
    """Return the largest intermediate of each function on checked integers, and the error that stopped it."""
    runtime = CPython()
    tree = runtime.prepare(sources, work)
    shutil.copy(Path(__file__).with_name("checked.py"), tree)
    found = {}
    for module in modules_of(runtime, tree):
        rows = runtime.ask(tree, f"import checked\nchecked.answer({module!r}, {CHECKED_VECTORS})\n")["rows"]
        for row in rows:
            found[f"{module}.{row['name']}"] = (row["largest"], row["error"])
    return found


def _measure(function: str, *arguments: object) -> str:
    return f"from probe import measure\nmeasure.{function}({', '.join(map(repr, arguments))})\n"
