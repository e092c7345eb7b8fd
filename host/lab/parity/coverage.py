"""Which statements of shared/ a MicroPython VM really ran: line events against the syntax tree."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...boards.runtimes import Node
from ...boards.runtimes.base import RuntimeFailure

VECTORS = 32  # of a function; tracing every line takes a hundred times as long as running it
WANTED = 0.95  # share of the statements inside functions that has to run


@dataclass(frozen=True)
class Coverage:
    """``missed`` holds file:line of every statement that did not run; ``skipped`` says why there is no figure."""

    statements: int = 0
    missed: tuple[str, ...] = ()
    skipped: str | None = None

    @property
    def share(self) -> float:
        return 1 - len(self.missed) / self.statements if self.statements else 0.0

    @property
    def enough(self) -> bool:
        return self.skipped is not None or self.share >= WANTED

    def summary(self) -> dict[str, Any]:
        """Return the figure as JSON."""
        if self.skipped:
            return {"skipped": self.skipped}
        return {"statements": self.statements, "share": round(self.share, 4), "missed": list(self.missed)}

    def sentence(self) -> str:
        """Return the figure, and a line for each file with statements that did not run."""
        if self.skipped:
            return f"coverage: skipped: {self.skipped}"
        told = f"coverage: {self.share:.1%} of {self.statements} statements of shared/ ran in the traced VM"
        by_file: dict[str, list[int]] = {}
        for place in self.missed:
            path, _, line = place.rpartition(":")
            by_file.setdefault(path, []).append(int(line))
        rows = [f"  {path}: {', '.join(map(str, sorted(lines)))}" for path, lines in sorted(by_file.items())]
        return "\n".join([told + (", not these lines:" if rows else ""), *rows])


class TracedNode(Node):
    """The build with sys.settrace, on the sources as they are."""

    name = "node-settrace"
    timeout_s = 600.0

    def __init__(self) -> None:
        super().__init__("micropython-settrace.wasm")


def cover(sources: Path, work: Path) -> Coverage:
    """Run the vectors in the traced VM; RuntimeFailure if the VM fails."""
    runtime = TracedNode()
    skipped = runtime.missing()
    if skipped:
        return Coverage(skipped=skipped)
    work.mkdir(parents=True)
    tree = runtime.prepare(sources, work)
    ran = runtime.ask(tree, f"from probe import trace\ntrace.lines({VECTORS})\n")["lines"]
    if not ran:
        raise RuntimeFailure("node-settrace: no line of shared/ was traced")
    return compare(sources, {path: set(lines) for path, lines in ran.items()})


def compare(sources: Path, ran: dict[str, set[int]]) -> Coverage:
    """Return which statements inside functions have none of their lines in ``ran``."""
    statements, missed = 0, []
    for path in sorted((sources / "shared").rglob("*.py")):
        name = path.relative_to(sources).as_posix()
        lines = ran.get(name, set())
        for first, last in spans(ast.parse(path.read_bytes())):
            statements += 1
            if not lines & set(range(first, last + 1)):
                missed.append(f"{name}:{first}")
    return Coverage(statements, tuple(missed))


def spans(tree: ast.Module) -> Iterator[tuple[int, int]]:
    """Yield the first and last line of every statement inside a function; of compound ones only the head."""
    for function in ast.walk(tree):
        if not isinstance(function, ast.FunctionDef):
            continue
        for node in ast.walk(function):
            if not isinstance(node, ast.stmt) or node is function or _is_text(node):
                continue
            body = getattr(node, "body", None)
            last = body[0].lineno - 1 if body else node.end_lineno or node.lineno
            yield node.lineno, max(node.lineno, last)


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
