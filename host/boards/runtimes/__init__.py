"""Every Python on which the core must give the same results, behind one interface."""

from .base import Runtime
from .board import Board
from .c_core import CCore
from .compiled import Compiled
from .cortex_m import CortexM
from .cpython import CPython
from .node import Node
from .unix import Unix
from .wasi import Wasi


def all_runtimes(port: str | None = None, emulated: bool = False) -> list[Runtime]:
    """Return the runtimes in reporting order; the board only with a ``port``.

    ``emulated``: also the emulated Cortex-M4, which takes minutes.
    """
    runtimes: list[Runtime] = [
        CPython(),
        Compiled(),
        CCore(),
        Wasi("source"),
        Wasi("bytecode"),
        Node(),
        Unix("source"),
        Unix("bytecode"),
        Unix("native"),
        Unix("viper"),
    ]
    if emulated:
        runtimes.append(CortexM())
    if port:
        runtimes.append(Board(port))
    return runtimes
