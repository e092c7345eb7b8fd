"""The interface of a runtime: it can be missing, it prepares a tree of sources, it runs a script on that tree."""

import json
import shutil
import subprocess
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Any

MARK = "@@"  # a script's answer is the line that starts with this; other lines are ignored


class RuntimeFailure(Exception):
    """A script that ended without an answer; the text contains its output."""


class Runtime(ABC):
    """One way to run the core.

    ``prepare`` receives a folder with the sources and returns the folder for scripts;
    ``execute`` runs a script there and returns its output.
    """

    name: str
    emitter: str  # "source": the files as they are
    arch = "any"
    timeout_s: float = 300.0
    afresh = True  # whether each script starts with an empty memory

    @abstractmethod
    def missing(self) -> str | None:
        """Return why this runtime can't be used here, with what to install; None if it can."""

    def prepare(self, sources: Path, work: Path) -> Path:
        """Return the folder to run on, made in ``work`` from ``sources``."""
        if self.emitter == "source":
            return shutil.copytree(sources, work / "source", ignore=shutil.ignore_patterns("__pycache__"))
        return compile_sources(sources, work, self.emitter, self.arch)

    @abstractmethod
    def execute(self, tree: Path, script: str) -> str:
        """Run ``script`` with ``tree`` importable and return its output; RuntimeFailure if it fails."""

    def close(self) -> None:
        """Release the runtime's resources; most have none."""
        return

    def ask(self, tree: Path, script: str) -> dict[str, Any]:
        """Run a script that answers with one marked line of JSON, and return that."""
        return self._answers(tree, script, 1)[0]

    def ask_each(self, tree: Path, scripts: list[str]) -> list[dict[str, Any]]:
        """Return the answers to independent scripts, in a process each if memory is short."""
        if self.afresh:
            return [self.ask(tree, script) for script in scripts]
        return self._answers(tree, "".join(scripts), len(scripts))

    def _answers(self, tree: Path, script: str, wanted: int) -> list[dict[str, Any]]:
        output = self.execute(tree, script)
        found = [json.loads(line[len(MARK) :]) for line in output.splitlines() if line.startswith(MARK)]
        if len(found) < wanted:
            raise RuntimeFailure(f"{self.name}: no answer; it printed: {output.strip()[-2000:]!r}")
        return found


def run_command(command: list[str], folder: Path, timeout_s: float, name: str) -> str:
    """Return the output of ``command`` in ``folder``; RuntimeFailure if it fails or takes too long."""
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, timeout=timeout_s, stdin=subprocess.DEVNULL
        )
    except subprocess.TimeoutExpired as error:
        raise RuntimeFailure(f"{name}: no answer within {timeout_s:g} s") from error
    if done.returncode:
        raise RuntimeFailure(f"{name}: exit {done.returncode}: {(done.stderr or done.stdout).strip()[-2000:]}")
    return done.stdout


def compile_sources(sources: Path, work: Path, emitter: str, arch: str) -> Path:
    """Return the sources as converted by the firmware build."""
    from ..build.tree import compile_tree, write_tree

    tree = work / f"{emitter}-{arch}"
    packages = tuple(sorted(p.name for p in sources.iterdir() if p.is_dir() and p.name != "__pycache__"))
    write_tree(compile_tree(sources, emitter, arch, packages), tree)
    return tree
