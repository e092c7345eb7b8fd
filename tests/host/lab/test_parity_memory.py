"""The vectors in a VM that collects no garbage: the usual number fits into its megabyte, costs depend on no hole."""

import pytest

from host.boards.runtimes import Wasi
from host.lab.parity.figures import fuel
from host.lab.parity.sources import gather

SCRIPT = """
import gc
from probe.joint import PROBES
before = gc.mem_alloc()
PROBES[0].digest(100, 100)
print("@@" + str(gc.mem_alloc() - before))
"""


def test_a_vector_of_a_joint_keeps_no_memory(tmp_path):
    """An error was made and dropped at each, and a row for each function: `caramelo parity` ran out of memory."""
    runtime = Wasi("bytecode")
    assert runtime.ask(runtime.prepare(gather(tmp_path), tmp_path), SCRIPT) < 1000


def test_a_call_costs_the_same_wherever_the_heap_has_holes(tmp_path):
    """The search for a frame went through the holes that loading had left: a quarter of a walk's cost was that."""
    found = []
    for name, loaded in (("usual", ""), ("holes", "HOLES = []\nfor at in range(2000):\n    HOLES.append(at)\n")):
        (tmp_path / name).mkdir()
        sources = gather(tmp_path / name)
        for path, more in (("__init__.py", 'MODULES = ("stability",)\n'), ("draw.py", loaded)):
            with (sources / "probe" / path).open("a") as file:
                file.write(more)
        found.append(fuel(sources, tmp_path / name))
    assert found[0] == pytest.approx(found[1], rel=0.01)
