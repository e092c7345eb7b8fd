"""The joint as viper in a real MicroPython: same numbers for a long life, current step against its float twin."""

import shutil

import pytest

from host.boards.runtimes import CPython, Unix
from host.lab.parity.sources import gather
from shared.joint.current import STEP_INPUT, STEP_LIMIT, STEP_SHAPE
from tests import ROOT
from tests.marks import skip_without

TICKS = 7200
LIFE = f"""
import json
from probe.draw import Digest
from probe.joint import BLOCKS, COMMISSION, FIELDS, PROBES, SETTINGS, STATE, Life, begin, tick

life, digest = Life("life", tick.motion_tick, BLOCKS, (FIELDS, STATE, SETTINGS, COMMISSION), begin=begin), Digest()
life.run({TICKS}, digest)
step, codes = PROBES[0], 0
step.start()
for index in range(1000):
    step.draw(index, 1000)
    codes |= 1 << step.call()
print("@@" + json.dumps(dict(digest=digest.number(), codes=codes)))
"""
COST = """
import json, time
from probe.joint_robot import LOOP, begin
from shared.joint.current import current_step
from twin import CurrentLoop

floats = CurrentLoop(1.7, 0.3, 24.0, 7, 0.1)

def integer():
    for rotor in range(5000):
        current_step(rotor & 16383, 0, LOOP)

def floating():
    step = floats.step
    for _ in range(5000):
        step(1.234, 0.5, -0.2, -0.3)

def best_us(call):
    best = 1 << 30
    for _ in range(5):
        begin()
        start = time.ticks_us()
        call()
        best = min(best, time.ticks_diff(time.ticks_us(), start))
    return best

print("@@" + json.dumps(dict(integer_us=best_us(integer), float_us=best_us(floating))))
"""


@pytest.fixture(scope="module")
def viper(tmp_path_factory):
    """Return what runs a script in the VM, which has the core as viper and the float twin of the current step."""
    runtime = Unix("viper")
    skip_without(runtime)
    tree = runtime.prepare(gather(tmp_path_factory.mktemp("gathered")), tmp_path_factory.mktemp("viper"))
    shutil.copy(ROOT / "tests/float_twin/joint_current.py", tree / "twin.py")
    return lambda script: runtime.ask(tree, script)


def test_viper_gives_the_same_numbers(viper, tmp_path):
    runtime = CPython()
    here = runtime.ask(runtime.prepare(gather(tmp_path), tmp_path / "here"), LIFE)
    assert here == viper(LIFE)
    for code in (STEP_INPUT, STEP_LIMIT, STEP_SHAPE):
        assert here["codes"] >> code & 1, "repaired inputs, limited and shaped voltages all occur"


def test_the_current_step_is_five_times_as_fast_as_its_float_twin(viper):
    found = viper(COST)
    assert found["float_us"] >= 5 * found["integer_us"]
