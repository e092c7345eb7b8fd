"""The gait board's whole cycle takes no memory: a 32-bit VM runs it with a locked heap, to the same end as CPython."""

import random
import shutil
from pathlib import Path

import pytest

from firmware import link
from firmware.mpu6050 import OK, SATURATED
from host.boards.runtimes import Unix, Wasi
from host.protocol.gait_frames import frame
from host.robot.file import load_robot
from host.robot.plane import planar_robot
from host.robot.scale import attitude_block, brad, core_params
from shared.planner.status import LIMP, STANDING, WALKING
from shared.record import pack
from tests.marks import skip_without

from .gait_run import run
from .gait_vm import copy_modules
from .test_gait_board import walk_command

ROBOT = load_robot("caramelo")
TICKS = 1000
SCRIPT = """
import json, micropython
from data import ATTITUDE, BLOCKS, PARAMS
from gait_run import gait_run
from shared.sense.attitude import Attitude
from shared.body.params import Params
from shared.record import unpack
%s
params, attitude = Params(), Attitude()
unpack(params, PARAMS)
unpack(attitude, ATTITUDE)
figures = gait_run.run(
    params, attitude, BLOCKS, micropython.heap_lock, micropython.heap_unlock)
print("@@" + json.dumps({"figures": figures}))
"""
PLANTED = """
good = gait_run.take_block
def bad(*given):
    [0] * 20
    good(*given)
gait_run.take_block = bad
"""


def blocks():
    """Return one block for each tick: commands, joints, questions, noise and torn frames, cut anywhere."""
    noise = random.Random(3)
    rest = [brad(a) for a in planar_robot(ROBOT).stand_pose_rad]
    limp = walk_command()
    limp.mode = 0
    stream, found = b"", []
    for tick in range(TICKS):
        stream += frame(link.COMMAND, pack(limp if tick < 3 else walk_command()), 4)[: noise.choice((99, 99, 99, 30))]
        stream += noise.choice((b"", b"", b"\xca", b"\xca\x5e\x01\x02", noise.randbytes(5)))
        stream += noise.choice((b"", frame(link.READ, (tick & 255,))))
        stream += frame(link.SENSED, rest, 2) if tick % 3 == 0 else b""
        if 700 <= tick < 760:  # enough of them that some come whole
            stream += frame(link.STOP if tick < 730 else link.RESET)
        count = min(noise.randrange(40, 65), len(stream))
        found.append(stream[:count])
        stream = stream[count:][-200:]
    return found


@pytest.fixture(scope="module")
def reference():
    return run(core_params(ROBOT), attitude_block(ROBOT), blocks(), int, int)


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """The application with what it imports, its inputs and the run."""
    folder = tmp_path_factory.mktemp("gait")
    copy_modules(folder, "firmware.gait_main", "firmware.mpu6050")
    (folder / "gait_run").mkdir()
    (folder / "gait_run" / "__init__.py").write_text("")
    shutil.copy(Path(__file__).with_name("gait_run.py"), folder / "gait_run" / "gait_run.py")
    (folder / "data").mkdir()
    params, attitude = pack(core_params(ROBOT)), pack(attitude_block(ROBOT))
    (folder / "data" / "__init__.py").write_text(f"PARAMS = {params}\nATTITUDE = {attitude}\nBLOCKS = {blocks()}\n")
    return folder


def ran(runtime, sources, work, planted=""):
    skip_without(runtime)
    return runtime.ask(runtime.prepare(sources, work), SCRIPT % planted)["figures"]


def test_the_run_means_something(reference):
    sent, _, states, faults, numbers, reader, _ = reference
    assert sent > TICKS + 200  # questions were answered
    assert states == 1 << LIMP | 1 << STANDING | 1 << WALKING
    assert faults == 1 << OK | 1 << SATURATED
    assert not numbers[-2]  # stopped
    assert reader[-1] > 50  # broken


def test_a_32_bit_vm_does_the_same_and_takes_no_memory(reference, sources, tmp_path):
    assert ran(Wasi(), sources, tmp_path) == reference


@pytest.mark.parametrize("emitter", ["viper", "native"])
def test_machine_code_does_the_same_and_takes_no_memory(reference, sources, tmp_path, emitter):
    assert ran(Unix(emitter), sources, tmp_path) == reference


def test_a_planted_allocation_is_found(sources, tmp_path):
    with pytest.raises(Exception, match="memory allocation failed, heap is locked"):
        ran(Wasi("source"), sources, tmp_path, PLANTED)
