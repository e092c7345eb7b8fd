"""`caramelo servos` against the emulated servos, as a user runs it."""

from contextlib import contextmanager

import pytest

from host.bus.base import JOINT_LABELS
from host.commands import servos

from .rig import CARAMELO, Rig


def test_scan_finds_twelve_and_tells_the_budget(run_json):
    code, found, err = run_json("servos", "scan", "--sim")
    assert (code, err) == (0, "")
    assert [(row["id"], row["joint"]) for row in found["servos"]] == list(enumerate(JOINT_LABELS, 1))
    assert found["budget"]["fits"] is True


def test_status_and_monitor(run, run_json):
    code, out, _ = run("servos", "status", "--sim")
    assert code == 0
    assert out.count("12.0") == 12
    code, out, _ = run("servos", "monitor", "--sim", "--seconds", "0.5")
    assert (code, out.count("RL calf"), out[-1]) == (0, 1, "\n"), "in a file the last table alone"
    code, found, _ = run_json("servos", "monitor", "--sim", "--seconds", "0.5")
    assert (code, len(found["joints"])) == (0, 12)


@pytest.fixture
def plugged(monkeypatch):
    """Twelve servos on the bus of the command, on a clock that stands still."""
    rig = Rig()

    @contextmanager
    def port(*arguments):
        yield CARAMELO, rig.bus.link

    monkeypatch.setattr(servos, "servo_port", port)
    return rig


def test_status_shows_the_others_where_some_are_silent(run, run_json, plugged):
    plugged.emulated.servo(5).missing = plugged.emulated.servo(6).missing = True
    code, out, err = run("servos", "status", "--sim")
    assert code == 1
    assert out.count("12.0") == 10
    assert out.count("silent") == 2
    assert err == (
        "caramelo: silent: FL thigh (id 5), FL calf (id 6): "
        "check the plugs and cables there, then run: caramelo servos scan\n"
    )
    _, found, _ = run_json("servos", "status", "--sim")
    assert [row["id"] for row in found["servos"] if row["silent"]] == [5, 6]


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
    ("arguments", "words"),
    [
        (("scan", "--port", "/dev/ttyUSB97"), "no such port"),
        (("scan", "--robot", "parallel"), "no servo bus"),
        (("scan", "--baud", "5"), "allowed 9600"),
        (("torque", "maybe"), "allowed on, off"),
        (("monitor", "--calibration", "no.toml"), "run: caramelo calibrate"),
        (("budget", "--baud", "-5"), "--baud -5: allowed 9600"),
        (("budget", "--baud", "0"), "--baud 0: allowed 9600"),
        (("budget", "--latency", "inf", "--json"), "--latency"),
    ],
)
def test_errors_are_one_line(refused, arguments, words):
    assert words in refused("servos", *arguments)


@pytest.mark.parametrize(("more", "code"), [((), 0), (("--baud", "57600"), 1)])
def test_a_budget_fits_or_not_and_says_nothing_on_stderr(run, more, code):
    got, _, err = run("servos", "budget", *more)
    assert (got, err) == (code, "")
