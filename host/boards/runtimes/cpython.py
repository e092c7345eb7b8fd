"""CPython itself: the reference, run in a process of its own like every other runtime."""

import sys
from pathlib import Path

from .base import Runtime, run_command


class CPython(Runtime):
    name = "cpython"
    emitter = "source"
    timeout_s = 1000.0  # for all scripts at once
    afresh = False

    def missing(self) -> str | None:
        return None

    def execute(self, tree: Path, script: str) -> str:
        # -I leaves out the environment and the current folder, so only this tree can be imported.
        start = f"import sys; sys.path.insert(0, {str(tree)!r})\n"
        return run_command([sys.executable, "-I", "-c", start + script], tree, self.timeout_s, self.name)
