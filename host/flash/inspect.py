"""What a board says of itself: its MicroPython, its file system, its slots, its log."""

from typing import Any

from ..runtimes.board import ARCHES
from .board_files import BoardFiles
from .link import BoardLink
from .plan import SLOTS, mpy_version


def describe(port: str) -> dict[str, Any]:
    """Return what a board is and holds; it is started again afterwards."""
    with BoardLink(port) as link:
        survey = BoardFiles(link).survey()
        link.reset()
    number = survey.mpy >> 10 & 0xF
    report = survey.report or {}
    return {
        "port": port,
        "micropython": survey.version,
        "machine": survey.machine,
        "mpy": mpy_version(survey.mpy),
        "arch": (ARCHES[number] if number < len(ARCHES) else f"number {number}") or "bytecode only",
        "file_system": survey.filesystem,
        "free": f"{survey.free} bytes",
        "slots": {slot: "whole" if survey.complete(slot) else "empty" for slot in SLOTS},
        "running": report.get("slot") or None,
        "confirmed": report.get("confirmed"),
        "role": report.get("role"),
        "version": report.get("version"),
        "build": report.get("build"),
        "protocol": report.get("protocol"),
        "self_test": {None: None, "": "passed"}.get(report.get("self_test"), report.get("self_test")),
        "supply_mV": survey.supply_mV,
    }


def read_log(port: str) -> list[str]:
    """Return the lines of a board's log; it is started again afterwards."""
    with BoardLink(port) as link:
        text = BoardFiles(link).log()
        link.reset()
    return text.splitlines()


def restart(port: str) -> None:
    """Reset a board and wait until it is there again."""
    with BoardLink(port) as link:
        link.reset()
        link.wait_until_back()
