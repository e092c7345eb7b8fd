"""A board seen from the host: reads what it holds and runs, and writes the other slot, by scripts at its prompt.

The scripts only call firmware/startup.py and firmware/update.py, which are frozen into the board's firmware.
"""

import base64
from collections.abc import Callable

from firmware.flash_map import HEADER

from .answers import Report, Sector, Survey
from .link import BoardError, BoardLink, BoardScriptError

CHUNK = 2048  # bytes of an image that a script carries (chosen)
HASH_TIMEOUT_S = 60.0

_HELPERS = """
import binascii, json, sys
from firmware.startup import start
start.hold_watchdog()
u = start.update
def answer(value):
    print("@@" + json.dumps(value))
def told(slot):
    h = u.header(slot)
    return h and {"build": h.build, "version": h.version, "sha256": binascii.hexlify(h.sha256).decode()}
"""
_SURVEY = """
supply = None
try:
    from firmware import application
    supply = application.motor_supply_mV()
except Exception:
    supply = None  # an application that can't be imported has started nothing, and must be replaceable
answer({"version": list(sys.implementation[1])[:3], "report": start.report(), "slots": [told(0), told(1)],
    "wished": u.wished(), "supply_mV": supply})
"""
_BEGIN = """
from firmware import application
answer(u.begin(binascii.a2b_base64(%r), application.armed()))
"""
_BEGIN_BROKEN = """
answer(u.begin(binascii.a2b_base64(%r), False))
"""


class NoFirmware(BoardError):
    """MicroPython answers, but our firmware in it does not."""


class Board:
    """The board behind ``link``, which is at its prompt; each call runs one or more scripts."""

    def __init__(self, link: BoardLink) -> None:
        self.link = link
        try:
            link.run(_HELPERS)
        except BoardScriptError as error:
            raise NoFirmware(
                f"{link.port}: MicroPython answers, but caramelo's firmware is not on the board ({error}): "
                f"write a first image with dfu-util (docs/flashing.md)"
            ) from error

    def survey(self) -> Survey:
        """Return what the board is."""
        return self.link.ask(_SURVEY, Survey)

    def report(self) -> Report:
        """Return the running firmware's report on its start."""
        return self.link.ask("answer(start.report())", Report)

    def is_whole(self, slot: int) -> bool:
        """Return True if the board reads the image in a slot as its header says."""
        return self.link.ask(f"answer(bool(u.is_whole({slot}, start.feed)))", bool, HASH_TIMEOUT_S)

    def write(self, data: bytes, progress: Callable[[float, float], None]) -> None:
        """Write a slot's bytes, header first among them, into the slot that does not run, and compare."""
        head, body = data[:HEADER], data[HEADER:]
        sectors = self._sectors(head)
        total = len(body)
        for sector in sectors:
            self.link.run(f"start.feed()\nu.erase({sector})")
        for at in range(0, total, CHUNK):
            part = base64.b64encode(body[at : at + CHUNK])
            self.link.run(f"start.feed()\nu.write({at}, binascii.a2b_base64({part!r}))")
            progress(min(total, at + CHUNK), total)
        self.link.run("u.finish(start.feed)", HASH_TIMEOUT_S)

    def _sectors(self, head: bytes) -> list[int]:
        """Let the board check the header; return the sectors to erase."""
        packed = base64.b64encode(head)
        try:
            return self.link.ask(_BEGIN % packed, list[Sector])
        except BoardScriptError as error:
            if "UpdateError" in str(error):
                raise
            return self.link.ask(_BEGIN_BROKEN % packed, list[Sector])  # what can't be imported arms nothing

    def activate(self) -> None:
        """Let the other slot start next, on trial."""
        self.link.run("u.activate()")

    def go_back(self) -> None:
        """Let the other slot start next, permanently."""
        self.link.run("u.go_back()")

    def confirm(self) -> None:
        """Confirm the running slot."""
        self.link.run("u.confirm()")

    def set_node(self, node: int) -> None:
        """Store the joint's id for its next start; BoardError if the settings are full."""
        if not self.link.ask(f"answer(bool(start.journal.put('node', bytes([{node}]))))", bool):
            raise BoardError(f"{self.link.port}: the board did not store the id: reset it, then flash again")

    def node_waits(self) -> bool:
        """Return True if the joint has not taken over the stored id."""
        return self.link.ask("answer(bool(start.journal.get('node')))", bool)

    def log(self) -> str:
        """Return the board's log."""
        return self.link.ask("answer(start.log())", str)
