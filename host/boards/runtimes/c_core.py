"""CPython with the core in C, as in a board's image (build/c_core.py): shows that the C computes the same."""

from pathlib import Path

from .base import RuntimeFailure
from .cpython import CPython


class CCore(CPython):
    """Compiles the sources' hot functions with the computer's own C compiler, in some seconds."""

    name = "cpython-c"
    emitter = "c"

    def missing(self) -> str | None:
        from ..build.c_compile import why_not

        return why_not()

    def prepare(self, sources: Path, work: Path) -> Path:
        from ..build.c_compile import compile_c_core

        tree = work / "c"
        try:
            compile_c_core(sources, tree)
        except OSError as error:
            raise RuntimeFailure(str(error)) from error
        runtime = tree / "shared" / "runtime.py"  # blocks are arrays, as on a board: machine code reads memory
        runtime.write_text(runtime.read_text().replace('implementation.name == "cpython"', "False"))
        return tree
