"""The vectors: a joint's long life drives in every mode; without garbage collection they fit, and cost the same."""

import pytest

from host.boards.runtimes import CPython, Wasi
from host.lab.parity.figures import fuel
from host.lab.parity.sources import gather
from shared.wire import names as w
from tests.firmware.gait_vm import copy_modules

TICKS = 2000  # of `caramelo parity` as it is called without options
DRIVES = (w.MODE_POSITION, w.MODE_VELOCITY, w.MODE_CURRENT, w.MODE_IMPEDANCE, w.MODE_COMMISSIONING, w.MODE_HOMING)
LIFE = """
from probe import joint, joint_robot
life = [probe for probe in joint.PROBES if probe.name == "motion_tick:life"][0]
life.start()
modes = []
for index in range(TICKS):
    life.draw(index, TICKS)
    life.call()
    if joint_robot.STATE.drive_state == ENABLED and joint_robot.STATE.mode not in modes:
        modes.append(joint_robot.STATE.mode)
print("@@" + str(modes))
""".replace("TICKS", str(TICKS)).replace("ENABLED", str(w.STATE_OPERATION_ENABLED))
MEMORY = """
import gc
from probe.joint import PROBES
before = gc.mem_alloc()
PROBES[0].digest(100, 100)
print("@@" + str(gc.mem_alloc() - before))
"""


def few(folder, *names):
    """Return a folder with these modules of the vectors and what they import: to compile all takes long."""
    copy_modules(folder / "few", *names, root=gather(folder), packages=("shared", "probe"))
    return folder / "few"


def test_a_joints_life_drives_in_every_mode(tmp_path):
    """Its two encoders disagreed from its first turn on: it faulted in the tick in which it began to drive."""
    runtime = CPython()
    modes = runtime.ask(runtime.prepare(few(tmp_path, "probe.joint"), tmp_path), LIFE)
    assert set(modes) >= set(DRIVES)


def test_a_vector_of_a_joint_keeps_no_memory(tmp_path):
    """An error was made and dropped at each, and a row for each function: `caramelo parity` ran out of memory."""
    runtime = Wasi("bytecode")
    assert runtime.ask(runtime.prepare(few(tmp_path, "probe.joint"), tmp_path), MEMORY) < 1000


def test_a_call_costs_the_same_wherever_the_heap_has_holes(tmp_path):
    """The search for a frame went through the holes that loading had left: a quarter of a walk's cost was that."""
    found = []
    for name, loaded in (("usual", ""), ("holes", "HOLES = []\nfor at in range(2000):\n    HOLES.append(at)\n")):
        sources = few(tmp_path / name, "probe.answer", "probe.measure", "probe.stability")
        for path, more in (("__init__.py", 'MODULES = ("stability",)\n'), ("draw.py", loaded)):
            with (sources / "probe" / path).open("a") as file:
                file.write(more)
        found.append(fuel(sources, tmp_path / name))
    assert found[0] == pytest.approx(found[1], rel=0.01)
