"""The joint as viper in a real MicroPython: same numbers, no allocation, current step against its float twin."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from host.boards.build.lower import lowered_modules
from host.boards.build.rewrite import rewrite
from host.boards.build.source import closure
from host.robot.file import load_robot
from host.robot.joint_gains import joint_blocks
from host.robot.joint_units import JointSetup
from shared.record import pack
from tests import ROOT

from .trace import Trace

VM = Path(sys.executable).with_name("micropython")
TICKS = 4800

SCRIPT = """
import gc, json, micropython, time
from array import array
from data import LOOP_SETTINGS, SETTINGS, CURVE, TICKS
from shared.joint.current import current_step
from shared.joint.thermal import slow_tick
from shared.joint.tick import motion_tick
from trace import Trace
from twin import CurrentLoop

def best_us(call, count):
    best = 1 << 30
    for _ in range(5):
        start = time.ticks_us()
        call(count)
        best = min(best, time.ticks_diff(time.ticks_us(), start))
    return best

trace = Trace(LOOP_SETTINGS, SETTINGS, CURVE)
digest = trace.run(TICKS)
other = Trace(LOOP_SETTINGS, SETTINGS, CURVE)
loop = other.at_rest()
floats = CurrentLoop(1.7, 0.3, 24.0, 7, 0.1)

def integer(count):
    other.at_rest()
    for rotor in range(count):
        current_step(rotor & 16383, 0, loop)

def floating(count):
    step = floats.step
    for _ in range(count):
        step(1.234, 0.5, -0.2, -0.3)

def allocated(trace):
    before = micropython.mem_total()
    for rotor in range(200):
        current_step(rotor, 0, loop)
        motion_tick(trace.loop, trace.settings, trace.state, trace.io, trace.commission)
        slow_tick(trace.settings, trace.state, trace.io, trace.curve)
    return micropython.mem_total() - before

allocated(trace)
other.at_rest()
print(json.dumps({"digest": digest, "codes": trace.codes, "bytes": allocated(trace),
                  "integer_us": best_us(integer, 5000), "float_us": best_us(floating, 5000)}))
"""


def block_values():
    blocks = joint_blocks(load_robot("parallel").actuator, JointSetup(-1.0, 1.9, has_joint_encoder=False))
    blocks.settings.commissioned = 1
    return pack(blocks.loop_settings), pack(blocks.settings), blocks.curve


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    if not VM.exists():
        pytest.skip("no MicroPython unix VM beside this python")
    folder = tmp_path_factory.mktemp("joint")
    sources = tmp_path_factory.mktemp("sources")
    shutil.copytree(ROOT / "shared", sources / "shared")
    (sources / "trace").mkdir()
    shutil.copy(Path(__file__).with_name("trace.py"), sources / "trace" / "__init__.py")
    modules = lowered_modules(sources, ("shared", "trace"))
    for name in closure(modules, ["trace"]):
        module = modules[name]
        target = folder / module.path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(rewrite(module, modules, "viper", "x64"))
    shutil.copy(ROOT / "tests/float_twin/joint_current.py", folder / "twin.py")
    loop_settings, settings, curve = block_values()
    (folder / "data.py").write_text(
        f"LOOP_SETTINGS = {loop_settings}\nSETTINGS = {settings}\nCURVE = {curve}\nTICKS = {TICKS}\n"
    )
    (folder / "main.py").write_text(SCRIPT)
    ran = subprocess.run([VM, "main.py"], cwd=folder, capture_output=True, text=True, timeout=120)
    assert ran.returncode == 0, ran.stdout + ran.stderr
    return json.loads(ran.stdout)


def test_viper_gives_the_same_numbers(answer):
    trace = Trace(*block_values())
    assert trace.run(TICKS) == answer["digest"]
    assert trace.codes == answer["codes"]
    assert trace.codes & 0b1110 == 0b1110  # repaired inputs, limited and shaped voltages all occurred


def test_nothing_is_allocated_per_tick(answer):
    assert answer["bytes"] == 0


def test_the_current_step_is_five_times_as_fast_as_its_float_twin(answer):
    assert answer["float_us"] >= 5 * answer["integer_us"]
