"""Every Python that the core must agree on, behind one interface."""

from .base import Runtime, RuntimeFailure
from .board import Board
from .cpython import CPython
from .node import Node
from .unix import Unix
from .wasi import Wasi

__all__ = ["Board", "CPython", "Node", "Runtime", "RuntimeFailure", "Unix", "Wasi", "all_runtimes"]


def all_runtimes(port: str | None = None) -> list[Runtime]:
    """Return the runtimes in the order they are reported; the board only with a ``port``."""
    runtimes: list[Runtime] = [
        CPython(),
        Wasi("source"),
        Wasi("bytecode"),
        Node(),
        Unix("source"),
        Unix("bytecode"),
        Unix("native"),
        Unix("viper"),
    ]
    if port:
        runtimes.append(Board(port))
    return runtimes
