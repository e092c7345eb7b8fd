"""The self-test of a real joint's board: gets the figures of firmware/joint_selftest.py over USB, and judges them."""

from dataclasses import dataclass
from typing import Any

from ..robot.joint_units import Board
from ..robot.thermistor import OPEN_RAW, SHORT_RAW
from .flash.answers import Answer
from .runtimes.base import MARK

SCRIPT = f"""
import json
from firmware.joint_selftest import run
print({MARK!r} + json.dumps(run(%s)))
"""
TIMEOUT_S = 20.0
STEP_US = 100
STEPS = 2000
# Entry, HAL and MicroPython take some 2 us until the first instruction; the rest of the time is the system's clock.
ENTRY_MOST_NS = 8_000
# 2500 instructions at two cycles are 30 us; the rest of the period is the main loop's, and compares must be written.
END_MOST_NS = 40_000
CURRENT_STEP_MOST_NS = 10_000  # 824 instructions at two cycles
OFFSET_COUNTS = 250  # limit for a sound sensor (offset_spread)
# A count is 4 mA (8.25 A full scale). Noise of 24 counts is 5 % of 2 A peak to peak, which the loop averages; switching
# may double it. A mean that moves by 8 counts is 1.6 % of 2 A: a sample taken while the amplifier still settles.
NOISE_OFF, NOISE_ON, SHIFT_ON = 24, 48, 8


Three = tuple[int, int, int]


class Figures(Answer):
    """The figures of firmware/joint_selftest.py; the last three only if the bridge switches."""

    driver: int
    took_us: int
    raw_low: Three
    raw_high: Three
    steps: int
    failed: int
    stale: int
    bad_rotor: int
    driver_fault: int
    gap_least_us: int
    gap_most_us: int
    entry_most_ns: int
    end_most_ns: int
    bus: int
    thermistor: int
    mcu: int
    joint: int
    step_ns: int
    bridge_on: int | None = None
    on_low: Three | None = None
    on_high: Three | None = None


@dataclass(frozen=True)
class Row:
    """One figure of the board: its name, the value found, the allowed range."""

    name: str
    found: str
    allowed: str
    ok: bool


def judge(figures: dict[str, Any]) -> list[Row]:
    """Return the rows for a board's figures; those of the bridge only if it was asked to switch."""
    rows = [*_driver_and_times(figures), *_sensors(figures)]
    for phase in range(3):
        low, high = figures["raw_low"][phase], figures["raw_high"][phase]
        name = f"shunt {'abc'[phase]}"
        rows.append(
            _row(f"{name} at no current, counts", (low + high) // 2, 2048 - OFFSET_COUNTS, 2048 + OFFSET_COUNTS)
        )
        rows.append(_row(f"{name} noise, counts peak to peak", high - low, 0, NOISE_OFF))
    if "bridge_on" in figures:
        rows += _switched(figures)
    return rows


def _driver_and_times(figures: dict[str, Any]) -> list[Row]:
    steps = max(figures["steps"], 1)
    allowed_us = STEPS * STEP_US
    return [
        _row("gate driver reads back", figures["driver"], -1, -1),
        _row("gate driver faults", figures["driver_fault"], 0, 0),
        _row("steps that failed", figures["failed"], 0, 0),
        _row("current steps", figures["steps"], STEPS, 10**6),
        _row(f"time of {STEPS} steps, us", figures["took_us"], allowed_us - 2 * STEP_US, allowed_us * 101 // 100),
        _row("shortest time between steps, us", figures["gap_least_us"], STEP_US - 10, STEP_US),
        _row("longest time between steps, us", figures["gap_most_us"], STEP_US, STEP_US + 10),
        _row("update to first instruction, ns", figures["entry_most_ns"], 0, ENTRY_MOST_NS),
        _row("update to end of the step, ns", figures["end_most_ns"], 0, END_MOST_NS),
        _row("current step alone, ns", figures["step_ns"], 0, CURRENT_STEP_MOST_NS),
        _row(f"steps without new samples, of {steps}", figures["stale"], 0, 0),
    ]


def _sensors(figures: dict[str, Any]) -> list[Row]:
    board = Board()
    bus_V = figures["bus"] * board.adc_volt * board.bus_divider / 4096
    return [
        _row("rotor readings that failed", figures["bad_rotor"], 0, 0),
        _row("joint encoder, counts", figures["joint"], 0, 16383),
        Row("supply, V", f"{bus_V:.2f}", "above 0", figures["bus"] > 0),
        _row("thermistor, counts", figures["thermistor"], SHORT_RAW + 1, OPEN_RAW - 1),
        _row("temperature sensor of the microcontroller, counts", figures["mcu"], 1, 4094),
    ]


def _switched(figures: dict[str, Any]) -> list[Row]:
    """Return the rows of the bridge: whether it stayed on, and the effect of its switching on the samples."""
    rows = [_row("bridge stayed on", figures["bridge_on"], 1, 1)]
    for phase in range(3 if "on_low" in figures else 0):
        low, high = figures["on_low"][phase], figures["on_high"][phase]
        shift = (low + high - figures["raw_low"][phase] - figures["raw_high"][phase]) // 2
        name = f"shunt {'abc'[phase]} with the bridge on"
        rows.append(_row(f"{name}, shift in counts", shift, -SHIFT_ON, SHIFT_ON))
        rows.append(_row(f"{name}, noise, counts peak to peak", high - low, 0, NOISE_ON))
    return rows


def ask(port: str, bridge: bool = False) -> dict[str, Any]:
    """Return the figures of the board at ``port``; UserError in one line if it does not answer."""
    from .flash.link import BoardError, BoardScriptError, stopped

    try:
        with stopped(port) as link:
            return link.ask(SCRIPT % bridge, Figures, TIMEOUT_S).model_dump(exclude_none=True)
    except BoardScriptError as error:
        raise BoardError(f"{error}: does a joint's firmware run on it? caramelo board info --port {port}") from error


def _row(name: str, value: int, low: int, high: int) -> Row:
    allowed = str(low) if low == high else f"{low} .. {high}"
    return Row(name, str(value), allowed, low <= value <= high)
