"""The command itself: checks of the start, terminal, signals, wrong use, figures."""

import contextlib
import io
import json
import os
import pty
import re
import select
import signal
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import pytest

from host.commands._hardware import kind_of_hardware
from host.control.safety import Fault
from host.records.reader import read_record
from host.robot.file import load_robot
from host.teleop.measure import Measure
from tests.host.control.rig import Rig
from tests.processes import hear_signals
from tests.waiting import PATIENCE_S, wait_until

TELEOP = [sys.executable, "-m", "host.cli", "teleop"]


def measured(robot):
    """Return figures and exit code; on a machine so busy that no emulated servo answers at the start, try again."""
    command = [*TELEOP, "--sim", "--robot", robot, "--measure", "2", "--json"]
    for _ in range(3):
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE_S)
        if done.stdout:
            return json.loads(done.stdout), done.returncode
        assert "caramelo: " in done.stderr
    raise AssertionError(done.stderr)


def test_measure_prints_figures():
    """Of two robots at once: each takes eight seconds, in which it mostly waits."""
    with ThreadPoolExecutor() as both:
        (figures, code), (brushless, _) = both.map(measured, ("caramelo", "parallel"))
    assert brushless["robot"] == "parallel"
    assert figures["bus"] == "servos"
    assert figures["late_ms"]["p50"] < 100
    assert code == (1 if figures["missed"] or figures["failure"] else 0)
    if not figures["failure"]:  # on a machine that is too busy the servos' watchdog lets go
        assert figures["ticks"] >= 50


@pytest.mark.parametrize(
    ("robot", "kind"),
    [("caramelo", "emulated"), ("parallel", "simulated"), ("pupper", "simulated"), ("solo12", "simulated")],
)
def test_only_a_servo_bus_is_emulated(robot, kind):
    """Pupper has servos, but no bus to them: it was refused with --sim."""
    assert kind_of_hardware(load_robot(robot), True, False) == kind
    assert kind_of_hardware(load_robot(robot), True, True) == "simulated"
    assert kind_of_hardware(load_robot(robot), False, False) == "real"


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ([], "no terminal"),
        (["--measure", "0"], "allowed 1 .. 3600"),
        (["--direct"], "only with --sim"),
        (["--robot", "nobody", "--headless"], "nobody"),
        (["--headless", "--port", "/dev/none", "--calibration", "/none.toml"], "none.toml"),
        (["--sim", "--direct", "--headless", "--web", "--listen", "x:y"], "--listen x:y"),
        (["--sim", "--direct", "--headless", "--web", "--listen", "203.0.113.1:8080"], "--listen 203.0.113.1:8080"),
        (["--sim", "--direct", "--headless", "--socket", "/nowhere/x"], "--socket /nowhere/x"),
        (["--sim", "--direct", "--headless", "--gamepad", "/dev/input/none"], "gamepad"),
        (["--sim", "--direct", "--headless", "--keep", "1"], "only with --log FOLDER"),
        (["--sim", "--direct", "--headless", "--keep", "0", "--log", "{}/x"], "allowed 0.01 .. 100000"),
        (["--sim", "--direct", "--headless", "--keep", "1", "--log", "{}/x.mcap"], "FOLDER, not with the file /"),
    ],
)
def test_wrong_use_is_one_line_and_leaves_nothing(options, sentence, run, monkeypatch, tmp_path):
    monkeypatch.setattr("host.control.priority.ask", lambda: "as it is")
    monkeypatch.setattr("sys.stdin", io.StringIO())
    code, _, error = run("teleop", *(option.format(tmp_path) for option in options))
    assert code == 2
    assert sentence in error
    assert error.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_measurement_ends_at_a_fault():
    rig = Rig()
    measure = Measure(5.0, 0.05)
    rig.loop._after_tick = measure.tick
    rig.run(1.0)
    assert not measure.done
    rig.supervisor.safety.raise_fault(Fault("sit", "tripped", "FL thigh: overload"))
    rig.run(0.2)
    assert (measure.done, measure.failure) == (True, "FL thigh: overload; then reset")


class Terminal:
    """The command in a pseudo-terminal."""

    def __init__(self, *options):
        self._ours, theirs = pty.openpty()
        self.process = subprocess.Popen(
            [*TELEOP, "--sim", "--direct", *options], stdin=theirs, stdout=theirs, stderr=theirs,
            start_new_session=True, preexec_fn=hear_signals,
        )  # fmt: skip
        os.close(theirs)
        self.shown = ""

    def type(self, keys):
        os.write(self._ours, keys)

    def read(self, seconds):
        """Take what is painted; a terminal that nobody reads stops being painted."""
        ready, _, _ = select.select([self._ours], [], [], seconds)
        if ready:
            with contextlib.suppress(OSError):
                self.shown += os.read(self._ours, 1 << 16).decode(errors="replace")

    def see(self, pattern, key=None):
        """Read until the pattern is painted; ``key`` is held down meanwhile, as a terminal repeats it."""
        since = len(self.shown)

        def painted():
            if key is not None:
                self.type(key)
            self.read(0.05)
            return re.search(pattern, self.shown[since:])

        wait_until(painted, lambda: f"{pattern} is not shown: {self.shown[-2000:]}")

    def hang_up(self):
        """Take the terminal away, as a broken ssh does."""
        os.close(self._ours)
        self.process.send_signal(signal.SIGHUP)

    def end(self):
        self.process.kill()
        self.process.wait(PATIENCE_S)


@pytest.fixture
def terminal(tmp_path):
    terminal = Terminal("--log", str(tmp_path / "x.mcap"))
    yield terminal
    terminal.end()


def states(path):
    return [row.values["state"] for row in read_record(path).of("/state")]


def sat_down(path):
    """Return whether a record is whole and ends with a robot that sat down."""
    return read_record(path).whole and states(path)[-2:] == ["sitting", "disarmed"]


def test_a_terminal_that_goes_away_sits_the_robot_down(terminal, tmp_path):
    terminal.see("disarmed")
    terminal.type(b"t")
    terminal.see(r" standing ")
    terminal.see("walking", key=b"w")
    terminal.hang_up()
    terminal.process.wait(PATIENCE_S)
    assert sat_down(tmp_path / "x.mcap")


def test_a_drive_in_the_terminal(terminal):
    terminal.see("ok +robot file: caramelo")
    terminal.see("disarmed")
    terminal.see("EMERGENCY STOP")
    terminal.type(b"t")
    terminal.see("standing up")
    terminal.see(r" standing ")
    terminal.see("walking", key=b"w")
    terminal.type(b" ")
    terminal.see("emergency stop by keyboard")
    terminal.type(b"r")
    terminal.see("stand up first")
    terminal.process.send_signal(signal.SIGINT)
    terminal.see("missed their deadline")
    assert terminal.process.wait(PATIENCE_S) == 0


def test_sigterm_ends_a_measurement_once_the_robot_sits(tmp_path):
    path = tmp_path / "x.mcap"
    options = ["--sim", "--direct", "--measure", "60", "--log", str(path)]
    process = subprocess.Popen([*TELEOP, *options], stdout=subprocess.PIPE, text=True)
    assert any(line.startswith("ready") for line in process.stdout)
    wait_until(lambda: "walking" in states(path), "it walks")
    process.send_signal(signal.SIGTERM)
    assert "missed their deadline" in process.stdout.read()
    process.stdout.close()
    process.wait(PATIENCE_S)
    assert sat_down(path)
