"""CPython again, with the core as machine code (host/boards/build/native_core.py), which a Raspberry Pi may run."""

import shutil
from pathlib import Path

from ...util.errors import UserError
from ..core import PACKAGE, find_core
from .base import RuntimeFailure
from .cpython import CPython

HERE = "shared"  # the core's name in the runtimes' folders


class Compiled(CPython):
    """Uses the core built from exactly these sources, else compiles them, which takes a minute."""

    name = "cpython-compiled"
    emitter = "mypyc"

    def missing(self) -> str | None:
        from ..build.native_core import why_not

        return None if find_core() else why_not()

    def prepare(self, sources: Path, work: Path) -> Path:
        from ..build.native_core import build_core

        tree, built = work / "compiled", find_core(sources) if PACKAGE == HERE else None
        try:
            if built is None:
                build_core(tree, sources, HERE)
            else:
                shutil.copytree(built, tree)
        except UserError as error:
            raise RuntimeFailure(str(error)) from error
        for path in sources.iterdir():
            if path.is_dir() and path.name not in ("shared", "__pycache__"):
                shutil.copytree(path, tree / path.name, ignore=shutil.ignore_patterns("__pycache__"))
        return tree
