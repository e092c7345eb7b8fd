"""A board that is none: the unix VM with a simulated flash behind a pseudo-terminal; it resets, and power can be cut.

At every start the loader's own decision (loader.py) chooses the slot, whose modules the VM then runs: an
image here is a text of them. It can be interrupted where it waits, listens or uses its flash (harness.py).
"""

import json
import os
import select
import shutil
import signal
import time
from pathlib import Path

from firmware.flash_map import BASE, HEADER, parse_header, slot_at
from host.boards.build.dfu import parts
from tests.waiting import PATIENCE_S, stays, wait_until

from ..runtimes.pretend_board import UnixVmBoard
from .loader import choose
from .sim_flash import Memory, SimFlash

HARNESS = Path(__file__).with_name("harness.py")
STARTS = b"pretend board"  # what the harness says first


class PretendBoard(UnixVmBoard):
    """Use as a context; ``folder`` keeps its flash from one to the next.

    ``image``: what a new board is given in slot A, as by DFU. ``cut``: power goes in the middle of that word written or
    sector erased, counted from the start after ``cut_life`` resets.
    """

    def __init__(self, folder, image=None, cut=0, cut_life=0):
        super().__init__()
        self.folder = Path(folder)
        self.folder.mkdir(exist_ok=True)
        self._cut, self._cut_life = cut, cut_life
        if image is not None:
            store = Memory()
            for at, data in parts(image):
                store.write(at - BASE, data)
            self.flash.write_bytes(store.data)
        self.slot = -1
        self.said = b""
        self.resets = 0
        self.powered = True

    @property
    def flash(self):
        return self.folder / "flash.bin"

    def __enter__(self):
        (self.folder / "writes").unlink(missing_ok=True)
        self._start()
        self._relay.start()
        assert self.wait_for(STARTS)
        return self

    def wait_for(self, words):
        """Wait until the board has said ``words`` since its last start."""
        return wait_until(lambda: words in self.said, lambda: (words, self.said))

    def line_after(self, words):
        """Wait for the line that holds ``words`` and return what stands behind them in it."""
        wait_until(lambda: b"\n" in self.said.partition(words)[2], lambda: (words, self.said))
        return self.said.partition(words)[2].partition(b"\n")[0].strip().decode()

    def wait_for_own_start(self):
        """Wait until it has started again and nobody has stopped it since: a reset is only asked for by its words."""
        wait_until(lambda: b"running" in self.said and b"raw REPL" not in self.said, lambda: self.said)

    def settle(self, words, quiet_s=0.5):
        """Wait until the board has said ``words`` and has not been reset for so long."""

        def quiet():
            resets = self.resets
            return words in self.said and stays(lambda: self.resets == resets, quiet_s)

        wait_until(quiet, lambda: (words, self.said))

    def after_reset(self, reset, words):
        """Return once ``reset`` has made the board start again and it has said ``words``."""
        wanted = self.resets + 1
        reset()
        wait_until(lambda: self.resets >= wanted, f"reset number {wanted}")
        self.wait_for(words)

    def _start(self):
        """Start the board; ``resets`` counts it only when the new one runs and nothing of the last is in ``said``."""
        (self.folder / "watchdog").unlink(missing_ok=True)
        self.said = b""
        again = self._process is not None
        cut = self._cut if self.resets + again == self._cut_life else 0
        self._load()
        settings = {"slot": self.slot, "cut": cut, "tests": str(HARNESS.parent)}
        (self.folder / "board.json").write_text(json.dumps(settings))
        while select.select([self._heard], [], [], 0)[0]:
            os.read(self._heard, 4096)  # the last one did not hear it
        self._start_vm(["-X", "heapsize=4M", "-i", str(HARNESS)], self.folder)
        self.resets += again

    def _load(self):
        """Do what the loader does, and lay out the modules of the slot that it chooses."""
        flash = SimFlash(Memory(self.flash.read_bytes()))
        self.slot = choose(flash)
        assert self.slot >= 0, "the loader finds no slot to start: this board is dead"
        self.flash.write_bytes(flash.store.data)
        header = parse_header(flash.view(slot_at(self.slot), HEADER))
        running = self.folder / "running"
        shutil.rmtree(running, ignore_errors=True)
        for path, text in json.loads(flash.view(slot_at(self.slot) + HEADER, header.length).rstrip(b"\xff")).items():
            (running / path).parent.mkdir(parents=True, exist_ok=True)
            (running / path).write_text(text)

    def _goes_on(self):
        """Start the board again after a reset, and let its port go when the power goes."""
        self._watch()
        code = self._process.poll()
        if code == -signal.SIGKILL:
            self.powered = False
            self._ends.remove(self._outside)
            os.close(self._outside)  # the port is gone; _outer keeps its number from being given to another board
        elif code is not None:
            self._start()
        return self.powered

    def _listens(self):
        return STARTS in self.said  # before it, USB is not open

    def _read(self, end):
        data = super()._read(end)
        if end == self._board:
            self.said += data
        return data

    def _watch(self):
        """Reset a board that did not feed its watchdog."""
        path = self.folder / "watchdog"
        try:
            timeout_ms = int(path.read_text() or "100000")
            late = time.time() - path.stat().st_mtime > timeout_ms / 1000
        except FileNotFoundError:
            return
        if late:
            self._process.terminate()
            self._process.wait(PATIENCE_S)
