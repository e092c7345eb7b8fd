"""The vectors in a VM that collects no garbage: the usual number of them has to fit into its megabyte."""

from host.boards.runtimes import Wasi
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
