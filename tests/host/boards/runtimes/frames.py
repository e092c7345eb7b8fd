"""How many words of frame each function needs in bytecode: over 11, MicroPython takes it from the heap.

The compiler says it (N_STATE) in the unix VM's verbose mode; the tree is the one a board gets.
"""

import re
import sys
from pathlib import Path

from host.boards.build.lower import lowered_modules
from host.boards.build.rewrite import rewrite
from host.boards.build.rules import hot_function
from host.boards.build.source import Module, calls, resolve
from host.boards.runtimes.base import run_command

LARGEST_ON_STACK = 11  # words; VM_MAX_STATE_ON_STACK of py/vm.c

Frames = dict[str, int]  # "shared/num/fixed.py:sin_q15" -> words


def own_frames(root: Path, work: Path) -> Frames:
    """Return the words of every function of shared/ by itself. Needs the unix VM."""
    frames: Frames = {}
    modules = lowered_modules(root, ("shared",))
    for module in modules.values():
        path = work / "frames.py"
        path.write_bytes(rewrite(module, modules, "bytecode", "any"))
        command = [sys.executable, "-m", "micropython_unix", "-v", "-v", "-X", "compile-only", str(path)]
        output = run_command(command, work, 60.0, "unix")
        for name, words in re.findall(r"code block '(\w+)'.*?\(N_STATE (\d+)\)", output, re.DOTALL):
            frames[f"{module.path}:{name}"] = int(words)
    return frames


def deepest_frames(root: Path, frames: Frames) -> Frames:
    """Return for every hot function the largest frame among itself and all it calls."""
    modules = lowered_modules(root, ("shared",))
    calls = {f"{m.path}:{name}": _callees(m, name, modules) for m in modules.values() for name in m.hot}
    return {name: max(frames[one] for one in _reached(name, calls)) for name in calls}


def _callees(module: Module, name: str, modules: dict[str, Module]) -> set[str]:
    found = set()
    for callee, _ in calls(module.hot[name]):
        origin = resolve(module, callee, modules)
        if origin and hot_function(module, callee, modules) is not None:
            found.add(f"{origin[0].path}:{origin[1]}")
    return found


def _reached(name: str, calls: dict[str, set[str]]) -> set[str]:
    found: set[str] = set()
    waiting = [name]
    while waiting:
        one = waiting.pop()
        if one not in found:
            found.add(one)
            waiting += calls.get(one, ())
    return found
