"""A board's report on itself: its MicroPython, its slots, its log."""

from typing import Any

from firmware.flash_map import SLOTS

from .answers import Held
from .board import Board
from .link import BoardLink, stopped


def describe(port: str) -> dict[str, Any]:
    """Return what a board is and holds; then start it again."""
    with stopped(port) as link:
        survey = Board(link).survey()
    report = survey.report
    return {
        "port": port,
        "board": report.board,
        "micropython": survey.micropython,
        "slots": {SLOTS[slot]: _held(held) for slot, held in enumerate(survey.slots)},
        "running": SLOTS[report.slot],
        "confirmed": report.confirmed,
        "role": report.role,
        "version": report.version,
        "build": report.build,
        "protocol": report.protocol,
        "self_test": "passed" if report.self_test == "" else report.self_test,
        "supply_mV": survey.supply_mV,
    }


def _held(held: Held | None) -> str:
    return f"version {held.version}, build {held.build}" if held else "empty"


def read_log(port: str) -> list[str]:
    """Return the lines of a board's log; then start it again."""
    with stopped(port) as link:
        return Board(link).log().splitlines()


def restart(port: str) -> None:
    """Reset a board and wait until it is back."""
    with BoardLink(port) as link:
        link.reset()
        link.wait_until_back()
