"""The joint as viper in a real MicroPython: same numbers, no allocation, current step against its float twin."""

import shutil
from pathlib import Path

import pytest

from host.boards.runtimes import Unix
from shared.record import pack
from tests import ROOT
from tests.marks import skip_without

from .plant import made
from .trace import Trace

TICKS = 4800

SCRIPT = """
import json, micropython, time
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
print("@@" + json.dumps({"digest": digest, "codes": trace.codes, "bytes": allocated(trace),
                         "integer_us": best_us(integer, 5000), "float_us": best_us(floating, 5000)}))
"""


def block_values():
    blocks = made(has_joint_encoder=False)
    blocks.settings.commissioned = 1
    return pack(blocks.loop_settings), pack(blocks.settings), blocks.curve


@pytest.fixture(scope="module")
def answer(tmp_path_factory):
    runtime = Unix("viper")
    skip_without(runtime)
    sources = tmp_path_factory.mktemp("sources")
    shutil.copytree(ROOT / "shared", sources / "shared")
    (sources / "trace").mkdir()
    shutil.copy(Path(__file__).with_name("trace.py"), sources / "trace" / "__init__.py")
    tree = runtime.prepare(sources, tmp_path_factory.mktemp("joint"))
    shutil.copy(ROOT / "tests/float_twin/joint_current.py", tree / "twin.py")
    loop_settings, settings, curve = block_values()
    (tree / "data.py").write_text(
        f"LOOP_SETTINGS = {loop_settings}\nSETTINGS = {settings}\nCURVE = {curve}\nTICKS = {TICKS}\n"
    )
    return runtime.ask(tree, SCRIPT)


def test_viper_gives_the_same_numbers(answer):
    trace = Trace(*block_values())
    assert trace.run(TICKS) == answer["digest"]
    assert trace.codes == answer["codes"]
    assert trace.codes & 0b1110 == 0b1110  # repaired inputs, limited and shaped voltages all occurred


def test_nothing_is_allocated_per_tick(answer):
    assert answer["bytes"] == 0


def test_the_current_step_is_five_times_as_fast_as_its_float_twin(answer):
    assert answer["float_us"] >= 5 * answer["integer_us"]
