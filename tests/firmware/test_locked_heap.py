"""Both applications in real VMs whose heap is locked: to the same end as on CPython, and nothing is allocated.

The gait board takes a stream cut anywhere (gait_run.py), the joint a storm of frames, resets and sensor faults, in
which there is never torque outside of operation enabled and never an exception (storm.py).
"""

import random
import shutil
from functools import cache
from pathlib import Path

import pytest

from firmware import link
from firmware.mpu6050 import OK, SATURATED
from host import ROOT
from host.boards.build.leaves import leaves_first
from host.boards.build.source import read_modules
from host.boards.runtimes import Unix, Wasi
from host.protocol.gait_frames import frame
from host.robot.file import load_robot
from host.robot.plane import planar_robot
from host.robot.scale import attitude_block, brad, core_params
from host.sim.motor.bench import Bench
from shared.planner.status import LIMP, STANDING, WALKING
from shared.record import pack
from tests.marks import skip_without

from . import gait_run, storm
from .gait_vm import copy_modules
from .test_gait_board import walk_command

ROBOT = load_robot("caramelo")
TICKS, FRAMES = 1000, 10_000
RUNS = {  # of a role: what runs, and what it starts from
    "gait": (gait_run, ("firmware.gait_main", "firmware.mpu6050")),
    "joint": (storm, ("firmware.joint", "firmware.board_sim", "firmware.settings")),
}
SCRIPT = """
import json, micropython
from runs import data, run
%s
figures = run.run(*data.GIVEN, micropython.heap_lock, micropython.heap_unlock)
print("@@" + json.dumps({"figures": figures}))
"""
PLANTED = """
from %s import %s as owner
good = owner.%s
def bad(*given):
    [0] * 20
    good(*given)
owner.%s = bad
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


@cache
def given(role):
    """Return what a run is given beside the locks."""
    if role == "gait":
        return pack(core_params(ROBOT)), pack(attitude_block(ROBOT)), blocks()
    return Bench(load_robot("parallel").actuator).blocks.stored(), FRAMES


@cache
def reference(role):
    """Return the figures of a run on CPython."""
    return RUNS[role][0].run(*given(role), int, int)


def ran(role, runtime, work, planted=""):
    """Return the figures of a run in a VM."""
    skip_without(runtime)
    module, starts = RUNS[role]
    sources = work / "sources"
    copy_modules(sources, *starts)
    (sources / "runs").mkdir()
    shutil.copy(Path(module.__file__), sources / "runs" / "run.py")
    leaves = leaves_first(read_modules(ROOT), list(starts))
    (sources / "runs" / "__init__.py").write_text(f"import {', '.join(leaves)}\n")
    (sources / "runs" / "data.py").write_text(f"GIVEN = {given(role)}\n")
    return runtime.ask(runtime.prepare(sources, work), SCRIPT % planted)["figures"]


def test_the_gait_boards_run_means_something():
    sent, _, states, faults, numbers, reader, _ = reference("gait")
    assert sent > TICKS + 200  # questions were answered
    assert states == 1 << LIMP | 1 << STANDING | 1 << WALKING
    assert faults == 1 << OK | 1 << SATURATED
    assert not numbers[-2]  # stopped
    assert reader[-1] > 50  # broken


def test_the_joints_is_a_storm_without_wrong_torque_and_exceptions():
    _, _, enabled, locked, exceptions, wrong_torque, faults, resets = reference("joint")
    assert min(enabled, locked, faults) > 500  # it was armed often enough for the rest to mean something
    assert resets > 5
    assert (wrong_torque, exceptions) == (0, 0)


@pytest.mark.parametrize("runtime", [Wasi(), Unix("viper")], ids=lambda runtime: runtime.name)
@pytest.mark.parametrize("role", RUNS)
def test_a_vm_does_the_same_and_allocates_nothing(role, runtime, tmp_path):
    assert ran(role, runtime, tmp_path) == reference(role)


def test_a_planted_allocation_of_the_gait_board_is_found(tmp_path):
    planted = PLANTED % ("runs", "run", "take_block", "take_block")
    with pytest.raises(Exception, match="memory allocation failed, heap is locked"):
        ran("gait", Wasi("source"), tmp_path, planted)


def test_a_planted_allocation_of_the_joint_is_found(tmp_path):
    planted = PLANTED % ("firmware.joint", "Joint", "_after_motion", "_after_motion")
    shorter = "data.GIVEN = data.GIVEN[0], 300\n"  # what is planted would fill the memory, which nobody collects
    exceptions = ran("joint", Wasi(), tmp_path, planted + shorter)[4]
    assert exceptions > 0
