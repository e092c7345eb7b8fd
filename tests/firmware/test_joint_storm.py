"""Ten thousand random frames, resets and sensor faults: the joint's whole application, on CPython and in real VMs.

Never torque outside of operation enabled, never an exception, nothing allocated while armed; and every runtime ends
with the same digest of states, duties and frames sent, so that it is one program everywhere.
"""

import shutil
from pathlib import Path

import pytest

from host import ROOT
from host.boards.build.leaves import leaves_first
from host.boards.build.source import read_modules
from host.boards.runtimes import Unix, Wasi
from host.robot.file import load_robot
from host.sim.motor.bench import Bench
from tests.marks import skip_without

from .gait_vm import copy_modules
from .storm import Storm

FRAMES = 10_000
STARTS = ("firmware.joint", "firmware.board_sim", "firmware.settings")
SCRIPT = """
import json, micropython
from data import STORED
from storm.storm import Storm

storm = Storm(STORED, micropython.heap_lock, micropython.heap_unlock)
%s
storm.run(%d)
print("@@" + json.dumps({"figures": storm.figures()}))
"""
PLANTED = """
good = storm.joint._after_motion
def bad():
    [0] * 20
    good()
storm.joint._after_motion = bad
"""


def settings():
    return Bench(load_robot("parallel").actuator).blocks.stored()


@pytest.fixture(scope="module")
def reference():
    storm = Storm(settings(), int, int)
    storm.run(FRAMES)
    return storm


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """The application with what it imports, the storm, and the joint's integers."""
    folder = tmp_path_factory.mktemp("storm")
    copy_modules(folder, *STARTS)
    (folder / "storm").mkdir()
    shutil.copy(Path(__file__).with_name("storm.py"), folder / "storm" / "storm.py")
    leaves = leaves_first(read_modules(ROOT), list(STARTS))
    (folder / "storm" / "__init__.py").write_text(f"import {', '.join(leaves)}\n")
    (folder / "data").mkdir()
    (folder / "data" / "__init__.py").write_text(f"STORED = {settings()}\n")
    return folder


def ran(runtime, sources, work, frames, planted=""):
    skip_without(runtime)
    tree = runtime.prepare(sources, work)
    return runtime.ask(tree, SCRIPT % (planted, frames))["figures"]


def test_it_is_a_storm(reference):
    assert reference.enabled > 500  # it was armed often enough for the rest to mean something
    assert reference.locked > 500
    assert reference.faults > 500
    assert reference.resets > 5


def test_never_torque_outside_operation_enabled_and_never_an_exception(reference):
    assert (reference.wrong_torque, reference.exceptions) == (0, 0)


def test_a_32_bit_vm_does_the_same_and_allocates_nothing_while_armed(reference, sources, tmp_path):
    assert ran(Wasi(), sources, tmp_path, FRAMES) == reference.figures()


@pytest.mark.parametrize("emitter", ["viper", "native"])
def test_machine_code_does_the_same_and_allocates_nothing_while_armed(reference, sources, tmp_path, emitter):
    assert ran(Unix(emitter), sources, tmp_path, FRAMES) == reference.figures()


def test_a_planted_allocation_is_found(sources, tmp_path):
    figures = ran(Wasi(), sources, tmp_path, 300, PLANTED)
    assert figures[4] > 0  # exceptions
