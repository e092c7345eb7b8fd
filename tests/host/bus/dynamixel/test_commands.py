"""`caramelo servos` against the emulated servos, as a user runs it."""

import json
from contextlib import contextmanager

import pytest

from host.bus.base import JOINT_LABELS
from host.commands import servos

from .rig import CARAMELO, Rig


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
    code, out, _ = run("servos", "monitor", "--sim", "--seconds", "0.5")
    assert (code, out.count("RL calf"), out[-1]) == (0, 1, "\n"), "in a file the last table alone"
    code, out, _ = run("servos", "monitor", "--sim", "--seconds", "0.5", "--json")
    assert code == 0
    assert len(json.loads(out)["joints"]) == 12


@pytest.fixture
def plugged(monkeypatch):
    """Twelve servos on the bus of the command, on a clock that stands still."""
    rig = Rig()

    @contextmanager
    def port(*arguments):
        yield CARAMELO, rig.bus.link

    monkeypatch.setattr(servos, "servo_port", port)
    return rig


def test_status_shows_the_others_where_some_are_silent(run, plugged):
    plugged.emulated.servo(5).missing = plugged.emulated.servo(6).missing = True
    code, out, err = run("servos", "status", "--sim")
    assert code == 1
    assert out.count("12.0") == 10
    assert out.count("silent") == 2
    assert err == (
        "caramelo: silent: FL thigh (id 5), FL calf (id 6): "
        "check the plugs and cables there, then run: caramelo servos scan\n"
    )
    code, out, _ = run("servos", "status", "--sim", "--json")
    assert [row["id"] for row in json.loads(out)["servos"] if row["silent"]] == [5, 6]


def test_status_goes_on_after_a_servo_that_falls_silent_while_it_is_asked(run, plugged, monkeypatch):
    link = plugged.bus.link
    ping = link.ping

    def loosen(servo, *arguments, **options):
        model = ping(servo, *arguments, **options)
        plugged.emulated.servo(servo).missing = servo == 3
        return model

    monkeypatch.setattr(link, "ping", loosen)
    code, out, err = run("servos", "status", "--sim")
    assert (code, out.count("12.0"), err.count("FR calf (id 3)")) == (1, 11, 1)


def test_status_where_nobody_answers_asks_for_the_power(run, plugged):
    for servo in plugged.servos:
        servo.missing = True
    code, _, err = run("servos", "status", "--sim")
    assert code == 1
    assert "no servo answers on" in err
    assert "is the power on?" in err


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
        (("budget", "--baud", "-5"), 2, "--baud -5: allowed 9600"),
        (("budget", "--baud", "0"), 2, "--baud 0: allowed 9600"),
        (("budget", "--latency", "inf", "--json"), 2, "--latency"),
    ],
)
def test_errors_are_one_line(run, arguments, code, words):
    got, _, err = run("servos", *arguments)
    assert got == code
    assert words in err
    assert err.count("\n") == bool(words)
