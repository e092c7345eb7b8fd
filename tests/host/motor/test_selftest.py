"""The board's self-test: what it measures, tried on the simulated board, and what the host makes of it."""

import pytest

from firmware.board_sim import SimBoard
from firmware.joint_selftest import STEPS, measure
from host.cli import main
from host.motor.selftest import judge


class Running(SimBoard):
    """A simulated board whose interrupt runs whenever the watchdog is fed; ``late_us`` comes on top now and then."""

    late_us = 0

    def feed_watchdog(self):
        super().feed_watchdog()
        self.now_us += 100 + (self.late_us if self.fed % 500 == 0 else 0)
        self.handler()


def test_a_healthy_board_passes():
    board = Running()
    figures = measure(board)
    figures["step_ns"] = 8000  # CPython has no ticks_us
    assert figures["steps"] >= STEPS
    assert [row.name for row in judge(figures) if not row.ok] == []
    assert board.bridge == 0


@pytest.mark.parametrize(
    ("field", "value", "name"),
    [
        ("late_us", 40, "longest time between steps, us"),
        ("rotor", -1, "rotor readings that failed"),
        ("driver_wrong", 5, "gate driver reads back"),
        ("thermistor", 4095, "thermistor, counts"),
        ("driver", 3, "gate driver faults"),
    ],
)
def test_what_is_wrong_is_named(field, value, name):
    board = Running()
    setattr(board, field, value)
    assert name in [row.name for row in judge(measure(board)) if not row.ok]


def test_a_port_that_is_none_is_one_line(capsys):
    assert main(["motor", "selftest", "--port", "/dev/null"]) != 0
    assert capsys.readouterr().err.count("\n") == 1
