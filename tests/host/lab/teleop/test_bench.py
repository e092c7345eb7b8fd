"""The bench of teleoperation: its rows, and one source measured through the whole command."""

import time
from random import Random

import pytest

from host.lab.teleop import bench
from host.lab.teleop.watched import Watched
from host.util.errors import UserError


def test_a_figure_is_reached_or_not():
    row = bench.Row("missed deadlines", 0, 0, "")
    assert row.reached
    assert not bench.Row("missed deadlines", 1, 0, "").reached
    assert bench.Bench([row], {"page, key": "no browser"}).as_dict() == {
        "figures": [{"what": "missed deadlines", "value": 0, "at_most": 0, "unit": "", "detail": "", "reached": True}],
        "skipped": {"page, key": "no browser"},
    }


def test_keys_typed_into_the_terminal_reach_the_servos(tmp_path):
    steered, stopped = bench._latencies(tmp_path, "keyboard", bench.SOURCES["keyboard"], 3)
    assert (steered.what, stopped.what) == ("keyboard: stick to packet", "keyboard: stop to torque off")
    assert 0 < steered.value < 2000
    assert 0 < stopped.value < 2000
    assert steered.detail.endswith("3 times")


class Told(Watched):
    """A command that is in one state after the other."""

    def __init__(self, *states):
        self.states = list(states)

    def status(self):
        return {"state": self.states.pop(0)}


def test_a_fault_on_the_way_up_is_reset_and_it_stands_up_again():
    """A busy machine's emulated servos fall silent: that ended `make test` once, and measures nothing."""
    asked, told = [], Told("disarmed", "standing up", "fault", "disarmed", "standing up", "standing", "walking")
    assert told.stand(asked.append, lambda status: status["state"] == "standing") == {"state": "standing"}
    assert asked == ["stand", "reset", "stand", "stand"]


class Stick(Watched):
    """A command whose servos fall silent at some moves of the stick, counted from 1; all others are sent at once."""

    def __init__(self, *silent):
        self.silent, self.moves, self.state, self.sent_s = silent, 0, "disarmed", 0.0

    def ask(self, what):
        self.state = {"stand": "standing", "reset": "disarmed"}.get(what, self.state)
        if what in ("push", "let go"):
            self.moves += 1
            self.state, self.sent_s = "walking", time.monotonic()
            if self.moves in self.silent:
                self.state, self.sent_s = "fault", 0.0

    def status(self):
        told = {"state": self.state, "reason": "12 joints do not answer", "remark": ""}
        return told | {"timing": {"steered_at_s": self.sent_s}}


@pytest.mark.parametrize(("silent", "moves"), [((), 2), ((1,), 3), ((2,), 4), ((1, 3), 5)])
def test_a_push_that_a_fault_ends_is_made_again(silent, moves):
    """A busy machine's emulated servos fell silent while the robot walked: that ended `make test` once, too."""
    stick = Stick(*silent)
    assert 0 <= bench._press(stick, stick.ask, Random(1)) < 1
    assert stick.moves == moves


def test_a_robot_that_always_faults_is_told():
    stick = Stick(*range(1, 100))
    with pytest.raises(UserError, match="a fault ended each of 5 walks: 12 joints do not answer"):
        bench._press(stick, stick.ask, Random(1))
    assert stick.moves == 5


@pytest.mark.parametrize(("value", "code"), [(20.0, 0), (31.0, 1)])
def test_the_command_fails_if_a_figure_is_not_reached(monkeypatch, run, run_json, value, code):
    found = bench.Bench([bench.Row("script: stick to packet", value, 30.0, "ms (p99)")], {"page, key": "no browser"})
    monkeypatch.setattr(bench, "run_bench", lambda *arguments: found)
    assert run_json("bench", "--teleop")[:2] == (code, found.as_dict())
    got, out, _ = run("bench", "--teleop")
    assert got == code
    assert "page, key: skipped: no browser" in out
