"""Runs the vectors in every runtime and finds the first one that differs."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...boards.build.source import BuildError
from ...boards.runtimes import Runtime
from ...boards.runtimes.base import RuntimeFailure

Digests = dict[str, tuple[int, int]]  # "module.function" -> (vectors, digest)


@dataclass
class Difference:
    """The first vector of a function on which a runtime disagrees with the reference."""

    function: str
    index: int
    inputs: list[Any]
    expected: list[Any]
    found: list[Any]

    def sentence(self) -> str:
        return (
            f"{self.function}: vector {self.index}: inputs {self.inputs}: "
            f"expected {self.expected}, found {self.found}"
        )


@dataclass
class Report:
    """What one runtime answered; ``skipped`` says why it was not asked, ``failure`` what broke."""

    runtime: Runtime
    version: str = ""
    word_bits: int = 0
    digests: Digests = field(default_factory=dict)
    seconds: float = 0.0
    skipped: str | None = None
    failure: str | None = None
    difference: Difference | None = None
    tree: Path | None = None
    parts: list[list[str]] = field(default_factory=list)  # what was asked for at once: module, walk or ""

    @property
    def vectors(self) -> int:
        return sum(count for count, _ in self.digests.values())

    @property
    def digest(self) -> str:
        """All functions' digests in one, 60 bits."""
        total = 1
        for _, number in self.digests.values():
            total = (total * 1000003 + number) % ((1 << 60) - 93)
        return f"{total:015x}"


def call(function: str, *arguments: object) -> str:
    """Return the script that asks ``probe.answer`` for something."""
    return f"from probe import answer\nanswer.{function}({', '.join(map(repr, arguments))})\n"


def examine(
    runtimes: list[Runtime], sources: Path, work: Path, vectors: int, progress: Callable[[str], None],
    known: Sequence[Report] = (),
) -> list[Report]:
    """Ask every runtime; the first is the reference the others are compared with, unless it is ``known`` already."""
    reports = list(known)
    try:
        for runtime in runtimes:
            progress(runtime.name)
            report = Report(runtime, skipped=runtime.missing())
            if report.skipped is None:
                collect(report, sources, work / runtime.name, vectors, reports[0].parts if reports else [])
                if reports and report.failure is None and report.digests != reports[0].digests:
                    report.difference = first_difference(reports[0], report)
            reports.append(report)
    finally:
        for runtime in runtimes:
            runtime.close()
    return reports


def collect(report: Report, sources: Path, work: Path, vectors: int, parts: list[list[str]] | None = None) -> None:
    """Fill in a runtime's version and digests; a failure is kept as its sentence. ``parts``: known beforehand."""
    runtime = report.runtime
    started = time.perf_counter()
    try:
        work.mkdir(parents=True, exist_ok=True)
        report.tree = runtime.prepare(sources, work)
        about = runtime.ask(report.tree, call("about"))
        report.version = f"{about['implementation']} {about['version']}"
        report.word_bits = about["word_bits"]
        report.parts = parts or runtime.ask(report.tree, call("parts"))["parts"]
        asked = [call("parity", module, vectors, walk) for module, walk in report.parts]
        for (module, _), answer in zip(report.parts, runtime.ask_each(report.tree, asked), strict=True):
            for name, count, digest in answer["digests"]:
                report.digests[f"{module}.{name}"] = (count, digest)
    except (RuntimeFailure, BuildError) as error:
        report.failure = str(error)
    report.seconds = time.perf_counter() - started


def first_difference(reference: Report, other: Report) -> Difference | None:
    """Return the first differing vector of the first differing function, found by halving."""
    for function, (count, digest) in reference.digests.items():
        if other.digests.get(function) == (count, digest):
            continue
        module, _, name = function.rpartition(".")
        index = _halve(reference, other, module, name, count)
        expected = _show(reference, module, name, index, count)
        found = _show(other, module, name, index, count)
        return Difference(
            function,
            index,
            expected["inputs"],
            [expected["result"], *expected["watched"]],
            [found["result"], *found["watched"]],
        )
    return None


def _halve(reference: Report, other: Report, module: str, name: str, total: int) -> int:
    """Return the first index whose prefix digests differ."""
    same, different = 0, total
    while different - same > 1:
        middle = (same + different) // 2
        script = call("prefix", module, name, middle, total)
        if _answer(reference, script) == _answer(other, script):
            same = middle
        else:
            different = middle
    return same


def _show(report: Report, module: str, name: str, index: int, total: int) -> dict[str, Any]:
    return _answer(report, call("show", module, name, index, total))


def _answer(report: Report, script: str) -> dict[str, Any]:
    assert report.tree is not None
    return report.runtime.ask(report.tree, script)


def failures(reports: list[Report]) -> Iterator[str]:
    """Yield one sentence for every runtime that failed or differs."""
    for report in reports:
        if report.failure:
            yield f"{report.runtime.name}: {report.failure}"
        elif report.difference:
            yield f"{report.runtime.name}: {report.difference.sentence()}"
