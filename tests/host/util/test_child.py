"""Children end with their input; one that does not is killed once the patience is over."""

import os
import signal
import subprocess
import sys

import pytest

from host.sim.servos.process import Emulator
from host.util.child import end_child


@pytest.mark.parametrize(
    ("code", "patience_s", "ending"),
    [("import sys; sys.stdin.read()", 60.0, 0), ("import signal; signal.pause()", 0.2, -signal.SIGKILL)],
    ids=["obeys", "hangs"],
)
def test_a_child_ends_and_its_pipes_are_closed(code, patience_s, ending):
    process = subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    end_child(process, patience_s)
    assert process.returncode == ending
    assert process.stdin.closed
    assert process.stdout.closed


def test_a_child_without_pipes_needs_no_patience():
    process = subprocess.Popen([sys.executable, "-c", "import signal; signal.pause()"], stdin=subprocess.DEVNULL)
    end_child(process, 0.0)
    assert process.returncode == -signal.SIGKILL
    end_child(process, 0.0)


def test_ctrl_c_while_the_emulated_servos_start_ends_them_too(monkeypatch):
    children = []

    def interrupt(self, end_s):
        children.append(self._process)
        raise KeyboardInterrupt

    monkeypatch.setattr(Emulator, "_line", interrupt)
    with pytest.raises(KeyboardInterrupt):
        Emulator("--robot", "caramelo").start()
    assert children[0].returncode is not None


def test_emulated_servos_whose_starter_is_gone_end_in_silence():
    ours, theirs = os.pipe()
    command = [sys.executable, "-m", "host.sim.servos", "--robot", "caramelo"]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=theirs, stderr=subprocess.PIPE, text=True)
    os.close(theirs)
    os.close(ours)  # before it can say its first line
    assert process.communicate(timeout=60)[1] == ""
    assert process.returncode == 1
