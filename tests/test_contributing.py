"""The recipes of CONTRIBUTING.md do what they say, as they stand there."""

import os
import re
import shutil
import subprocess
import sys

from host.bus.base import Bus
from host.control.loop import Loop
from host.control.supervisor import Supervisor
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from tests import ROOT
from tests.host.control.rig import AHEAD, SCRIPT, STAND, STILL, STOP, Silence

TEXT = (ROOT / "CONTRIBUTING.md").read_text()


def recipe(title):
    """Return what stands under a heading."""
    return TEXT.partition(f"## {title}\n")[2].partition("\n## ")[0]


def typed(tmp_path, title, count):
    """Run the commands under a heading in a folder; return what they print, which is that the robot has arrived."""
    (tmp_path / "caramelo").write_text(f"#!/bin/sh\nexec {sys.executable} -m host.cli \"$@\"\n")
    (tmp_path / "caramelo").chmod(0o755)
    lines = re.findall(r"(?m)^    (.*)$", recipe(title))
    assert len(lines) == count
    around = {**os.environ, "PATH": f"{tmp_path}:{os.environ['PATH']}", "PYTHONPATH": str(ROOT)}
    command = ["sh", "-e", "-c", "\n".join(lines)]
    done = subprocess.run(command, cwd=tmp_path, env=around, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert "ok: arrived" in done.stdout
    return done.stdout


def test_a_gait(tmp_path):
    (tmp_path / "examples").mkdir()
    shutil.copy(ROOT / "examples/amble.toml", tmp_path / "examples")
    assert re.search(r"gait +mine", typed(tmp_path, "Add a gait", 3))


def test_a_robot(tmp_path):
    (tmp_path / "host/robot/files").mkdir(parents=True)
    shutil.copy(ROOT / "host/robot/files/caramelo.toml", tmp_path / "host/robot/files")
    assert re.search(r"robot +mine", typed(tmp_path, "Add a robot", 4))


def test_a_bus():
    (code,) = re.findall(r"(?s)```python\n(.*?)```", recipe("Add a bus or a board"))
    found = {}
    exec(code, found)
    (made,) = (each for each in found.values() if isinstance(each, type) and issubclass(each, Bus) and each is not Bus)
    robot, time_s = load_robot("caramelo"), [0.0]
    bus = made(seated_pose_rad(robot), lambda: time_s[0])
    loop = Loop(Supervisor(robot, bus, lambda: (0.0, 0.0)), clock=bus.now)

    def run(seconds, message):
        for _ in range(round(seconds / loop.pacer.period_s)):
            loop.receive(SCRIPT, message)
            loop.tick(Silence())
            time_s[0] += loop.pacer.period_s

    with bus:
        run(0.2, STILL)
        loop.receive(SCRIPT, STAND)
        run(4.0, STILL)
        assert loop.supervisor.state == "standing"
        run(2.0, AHEAD)
        assert loop.supervisor.state == "walking"
        loop.receive(SCRIPT, STOP)
        assert not bus.holds
