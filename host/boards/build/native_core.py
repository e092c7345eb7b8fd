"""Compiles shared/ for this Python: types (typed.py), then mypyc and the machine's C compiler.

The result is a folder with a package ``shared`` that is the sources and, beside them, their machine code, which
Python prefers. The wire's codec stays as it is: its frames are arrays of several kinds, and it is a small part.
"""

import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

from ... import ROOT
from ...util.errors import NOT_ACHIEVED, UserError
from ...util.extras import how_to_get
from ..core import PACKAGE
from . import c_compile
from .source import BuildError, Module, read_modules
from .typed import typed_modules

_SETUP = """from mypyc.build import mypycify
from setuptools import setup
setup(name="caramelo_core", packages=[], ext_modules=mypycify(
    ["--config-file=", "--ignore-missing-imports", *{paths!r}], opt_level="1", debug_level="0", multi_file=True))
"""  # more of either takes longer and is no faster; in several files a Pi has the memory for it
_TIME_LIMIT_S = 3600.0  # a minute on a PC; a small Pi takes many
_LEFT = ("shared.runtime", "shared.record", "shared.wire.")


def why_not() -> str | None:
    """Return what is missing to compile here, with what to do; None if nothing is."""
    for library in ("mypyc", "setuptools"):
        if importlib.util.find_spec(library) is None:
            return f"{library} is not installed: {how_to_get(library)}"
    return c_compile.why_not()


def build_core(target: Path, root: Path = ROOT, package: str = PACKAGE) -> None:
    """Compile ``root``/shared, to be imported as ``package``, into the new folder ``target``.

    UserError with the compiler's last words if it fails.
    """
    missing = why_not()
    if missing:
        raise UserError(f"the core cannot be compiled here: {missing}")
    target.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=".core-", dir=target.parent) as folder:
        work, new = Path(folder, "work"), Path(folder, "new")
        _run_mypyc(work, _write_typed(root, work, package))
        _copy_shared(root, new, package)
        suffix = sysconfig.get_config_var("EXT_SUFFIX")
        for made in [*work.glob(f"*{suffix}"), *(work / package.partition(".")[0]).rglob(f"*{suffix}")]:
            shutil.copy(made, new / made.relative_to(work))
        os.sync()  # a power cut must not leave cut-off machine code: a process that loads it dies
        new.rename(target)


def _copy_shared(root: Path, to: Path, package: str) -> Path:
    """Copy the sources to where ``package`` is looked for below ``to``, and return that folder."""
    place = to.joinpath(*package.split("."))
    shutil.copytree(root / "shared", place, ignore=shutil.ignore_patterns("__pycache__"))
    for above in place.relative_to(to).parents:
        if above.parts:
            (to / above / "__init__.py").touch()
    return place


def _write_typed(root: Path, work: Path, package: str) -> list[str]:
    """Write the package with types; return the paths of what is to be compiled."""
    place = _copy_shared(root, work, package)
    modules = read_modules(root, ("shared",))
    paths = []
    try:
        for name, text in typed_modules(modules, package).items():
            if _is_compiled(modules[name]):
                path = place / Path(modules[name].path).relative_to("shared")
                path.write_bytes(text)
                paths.append(path.relative_to(work).as_posix())
    except BuildError as error:
        raise UserError(str(error)) from error
    return paths


def _is_compiled(module: Module) -> bool:
    return not module.is_package and not module.name.startswith(_LEFT)


def _run_mypyc(work: Path, paths: list[str]) -> None:
    (work / "setup.py").write_text(_SETUP.format(paths=paths))
    command = [sys.executable, "setup.py", "--quiet", "build_ext", "--inplace"]
    try:
        done = subprocess.run(command, cwd=work, capture_output=True, text=True, timeout=_TIME_LIMIT_S,
                              stdin=subprocess.DEVNULL)
    except subprocess.TimeoutExpired as error:
        raise UserError(f"compiling the core took more than {_TIME_LIMIT_S:g} s", NOT_ACHIEVED) from error
    if done.returncode:
        words = [line for line in (done.stdout + done.stderr).splitlines() if "error" in line.lower()]
        raise UserError(f"compiling the core failed: {(words or ['without a word'])[0][:300]}", NOT_ACHIEVED)
