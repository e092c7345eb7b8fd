"""The gait board's program in the unix VM: the real firmware behind pipes, which are its serial link."""

import shutil
import subprocess
import sys
from pathlib import Path

from host import ROOT
from host.boards.build.source import PACKAGES, closure, read_modules
from host.boards.runtimes.unix import Unix
from host.robot.scale import attitude_block, core_params
from shared.record import pack
from tests.marks import skip_without


def copy_modules(to, *names, root=ROOT, packages=PACKAGES):
    """Copy these modules of ``root`` and all that they import into the folder ``to``."""
    modules = read_modules(root, packages)
    for name in closure(modules, list(names)):
        path = modules[name].path
        (to / path).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(root / path, to / path)


def compile_gait(work):
    """Compile the firmware in the folder ``work``, and return the folder that it runs in."""
    unix = Unix("viper")
    skip_without(unix)
    sources = work / "sources"
    copy_modules(sources, "firmware.gait", "firmware.mpu6050")
    tree = unix.prepare(sources, work)
    shutil.copy(Path(__file__).with_name("piped_gait.py"), tree)
    return tree


def start_gait_vm(tree, robot, bufsize=-1):
    """Start what ``compile_gait`` made for a robot; ``bufsize`` is Popen's, of both pipes."""
    script = (
        "import sys\nsys.path.insert(0, '.')\nfrom array import array\nfrom piped_gait import run_piped\n"
        f"run_piped(array('i', {pack(core_params(robot))}), array('i', {pack(attitude_block(robot))}))\n"
    )
    return subprocess.Popen(
        [sys.executable, "-m", "micropython_unix", "-c", script],
        cwd=tree,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        bufsize=bufsize,
    )
