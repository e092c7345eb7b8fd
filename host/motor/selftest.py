"""The self-test of a joint's real board: asks it over USB for what firmware/joint_selftest.py measures, and judges."""

from dataclasses import dataclass
from typing import Any

from ..joint_units import Board
from ..runtimes.base import MARK

SCRIPT = f"""
import json
from firmware.joint_selftest import run
print({MARK!r} + json.dumps(run()))
"""
TIMEOUT_S = 20.0
STEP_US = 100


@dataclass(frozen=True)
class Row:
    """One figure of the board: what it is, what was found, what is allowed."""

    name: str
    found: str
    allowed: str
    ok: bool


def judge(figures: dict[str, Any]) -> list[Row]:
    """Return the rows for what a board measured."""
    board = Board()
    bus_V = figures["bus"] * board.adc_volt * board.bus_divider / 4096
    rows = [
        _row("gate driver reads back", figures["driver"], -1, -1),
        _row("gate driver faults", figures["driver_fault"], 0, 0),
        _row("steps that failed", figures["failed"], 0, 0),
        _row("current steps", figures["steps"], 2000, 10**6),
        _row("shortest time between steps, us", figures["gap_least_us"], STEP_US - 10, STEP_US),
        _row("longest time between steps, us", figures["gap_most_us"], STEP_US, STEP_US + 10),
        _row("longest handler, us", figures["handler_most_us"], 0, STEP_US // 2),
        _row("current step alone, ns", figures["step_ns"], 0, 10_000),
        _row("rotor readings that failed", figures["bad_rotor"], 0, 0),
        _row("joint encoder, counts", figures["joint"], 0, 16383),
    ]
    for phase in range(3):
        low, high = figures["raw_low"][phase], figures["raw_high"][phase]
        rows.append(_row(f"shunt {'abc'[phase]} at no current, counts", (low + high) // 2, 1798, 2298))
        rows.append(_row(f"shunt {'abc'[phase]} noise, counts peak to peak", high - low, 0, 24))
    rows.append(Row("supply, V", f"{bus_V:.2f}", "any", True))
    rows.append(_row("thermistor, counts", figures["thermistor"], 33, 4031))
    rows.append(_row("temperature sensor of the microcontroller, counts", figures["mcu"], 1, 4094))
    return rows


def ask(port: str) -> dict[str, Any]:
    """Return what the board at ``port`` measures; UserError in one line if it does not answer."""
    from ..flash.link import BoardLink

    with BoardLink(port) as link:
        figures = link.ask(SCRIPT, TIMEOUT_S)
        link.reset()  # the watchdog that came with the interrupt would do it anyway
        return figures


def _row(name: str, value: int, low: int, high: int) -> Row:
    allowed = str(low) if low == high else f"{low} .. {high}"
    return Row(name, str(value), allowed, low <= value <= high)
