"""`caramelo servos` against the emulated servos, as a user runs it."""

import json

import pytest

from host.bus.base import JOINT_LABELS


def test_scan_finds_twelve_and_tells_the_budget(run):
    code, out, err = run("servos", "scan", "--sim", "--json")
    found = json.loads(out)
    assert (code, err) == (0, "")
    assert [(row["id"], row["joint"]) for row in found["servos"]] == list(enumerate(JOINT_LABELS, 1))
    assert found["budget"]["fits"] is True


def test_status_and_monitor(run):
    code, out, _ = run("servos", "status", "--sim")
    assert code == 0
    assert out.count("12.0") == 12
    code, out, _ = run("servos", "monitor", "--sim", "--seconds", "0.5", "--json")
    assert code == 0
    assert len(json.loads(out)["joints"]) == 12


def test_numbering_switching_restarting(run):
    assert run("servos", "set-id", "3", "40", "--sim")[0] == 0
    assert run("servos", "set-id", "3", "4", "--sim")[0] == 1
    assert run("servos", "torque", "on", "--sim", "--seconds", "0.2")[0] == 0
    assert run("servos", "reboot", "5", "--sim")[0] == 0
    assert run("servos", "reboot", "50", "--sim")[0] == 1


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("scan", "--port", "/dev/ttyUSB97"), 2, "no such port"),
        (("scan", "--robot", "parallel"), 2, "no servo bus"),
        (("scan", "--baud", "5"), 2, "allowed 9600"),
        (("torque", "maybe"), 2, "allowed on, off"),
        (("monitor", "--calibration", "no.toml"), 2, "run: caramelo calibrate"),
        (("budget", "--baud", "57600"), 1, ""),
        (("budget",), 0, ""),
    ],
)
def test_errors_are_one_line(run, arguments, code, words):
    got, _, err = run("servos", *arguments)
    assert got == code
    assert words in err
    assert err.count("\n") == bool(words)
