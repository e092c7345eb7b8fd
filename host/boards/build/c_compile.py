"""Compiles the core's C for this computer's Python, as a module ``_core`` beside the rest of the modules."""

import os
import shlex
import shutil
import subprocess
import sysconfig
from pathlib import Path

from .c_core import MODULE, build_c_core
from .lower import lowered_modules

FLAGS = ("-O1", "-fwrapv", "-fno-strict-aliasing", "-shared", "-fPIC", "-w")
_TIME_LIMIT_S = 600.0


def why_not() -> str | None:
    """Return what is missing to compile here, with what to do; None if nothing is."""
    if shutil.which(_compiler()[0]) is None:
        return f"there is no C compiler {_compiler()[0]}: install one, on Debian apt-get install gcc python3-dev"
    if not Path(sysconfig.get_path("include"), "Python.h").exists():
        return "Python's C headers are missing: on Debian, apt-get install python3-dev"
    return None


def compile_c_core(sources: Path, tree: Path) -> None:
    """Write the packages under ``sources`` to ``tree``, their hot functions as machine code. OSError if cc fails."""
    packages = tuple(sorted(p.name for p in sources.iterdir() if p.is_dir() and p.name != "__pycache__"))
    modules = lowered_modules(sources, packages)
    core = build_c_core(modules, sorted(modules), "cpython", whole=True)
    for path, text in core.modules.items():
        (tree / path).parent.mkdir(parents=True, exist_ok=True)
        (tree / path).write_bytes(text)
    source = tree / f"{MODULE}.c"
    source.write_text(core.source)
    made = tree / f"{MODULE}{sysconfig.get_config_var('EXT_SUFFIX')}"
    command = [*_compiler(), *FLAGS, f"-I{sysconfig.get_path('include')}", str(source), "-o", str(made)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=_TIME_LIMIT_S, stdin=subprocess.DEVNULL)
    if done.returncode:
        raise OSError(f"the C compiler failed: {done.stderr.strip()[:500]}")


def _compiler() -> list[str]:
    return shlex.split(os.environ.get("CC") or sysconfig.get_config_var("CC") or "cc")
