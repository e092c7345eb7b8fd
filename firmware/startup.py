"""Starts the application frozen beside this, and tells the host how that went. ``start`` below is the only one.

The loader has chosen the slot (firmware/loader/). A slot on trial that fails starts anew until its starts are used up
and the loader takes the other one; ``caramelo flash`` confirms after the self-test.
"""

import sys
import time

import machine

from .chip_flash import ChipFlash
from .flash_map import BASE, CONFIRMED, HEADER, SLOTS, parse_header, slot_at
from .settings import Journal
from .startup_words import CHOSEN, FAILED, RUNNING, STARTED, STOPPED
from .update import Update, UpdateError

LOG = "log"  # its key in the settings
_LOG_BYTES = 1024  # what is kept of the log (chosen)
_START_DELAY_MS = 500  # in which Ctrl-C keeps the application from starting (chosen)
_HOLD_MS = 32000  # the longest a STM32's watchdog waits is 32767 ms
_VTOR = 0xE000ED08


class Start:
    """What happened since power-on."""

    def __init__(self, flash, slot):
        self.slot = slot  # 0 or 1
        self.header = parse_header(flash.view(slot_at(slot), HEADER))
        self.update = Update(flash, slot, self.header.board)
        self.journal = Journal(flash)
        self.stage = CHOSEN
        self.self_test = None  # "" when it passed
        self.error = ""
        self.watchdog = None  # the application's, taken over when it was stopped

    def settle(self):
        """Before anything runs: note and record that the loader took another slot than wished; make room."""
        self.journal.tidy()
        wished = self.update.wished()
        if wished is None or wished[0] == self.slot:
            return
        slot, starts = wished
        reason = "was not confirmed in its starts" if starts == 0 else "is damaged"
        self.note(f"slot {SLOTS[slot]} {reason}: back to slot {SLOTS[self.slot]}")
        try:
            self.update.confirm()
        except UpdateError as error:
            self.note(str(error))

    def run(self):
        """Test the core and run the application; what goes wrong is noted in the log."""
        try:
            time.sleep_ms(_START_DELAY_MS)  # pyright: ignore[reportAttributeAccessIssue]: not in CPython's time
            self._run_application()
        except KeyboardInterrupt:
            self.hold_watchdog()
            if self.stage == RUNNING:
                self.stage = STOPPED
            print("stopped")
        except Exception as error:
            self.hold_watchdog()
            self.stage = FAILED
            self.error = f"{type(error).__name__}: {error}"
            self.note(f"slot {SLOTS[self.slot]}: {self.error}")
            print(self.error)
            if not self.confirmed():
                machine.reset()

    def check(self):
        """Run the self-test; return "" or what is wrong."""
        from .selftest import self_test

        self.self_test = self_test()
        return self.self_test

    def confirmed(self):
        """Return True if the running slot is to stay."""
        return self.update.wished() in (None, (self.slot, CONFIRMED))

    def hold_watchdog(self):
        """Take over a watchdog that the application may have started: it can't be stopped, but it can be slow."""
        application = sys.modules.get("firmware.application")
        if application and application.WATCHDOG and not self.watchdog:
            self.watchdog = machine.WDT(timeout=_HOLD_MS)

    def feed(self):
        """Put off the watchdog that was taken over from the application."""
        if self.watchdog:
            self.watchdog.feed()

    def note(self, sentence):
        """Add a line to the log, which loses its oldest lines; one that can't be written stops nothing."""
        lines = (self.log() + sentence + "\n")[-_LOG_BYTES:]
        self.journal.put(LOG, lines.encode())

    def log(self):
        """Return the log's text."""
        return (self.journal.get(LOG) or b"").decode()

    def report(self):
        """Return what the host asks after a start, as a dictionary."""
        return {
            "slot": SLOTS[self.slot],
            "stage": self.stage,
            "self_test": self.self_test,
            "error": self.error,
            "confirmed": self.confirmed(),
            "board": self.header.board,
            "build": self.header.build,
            "role": self.header.role,
            "version": self.header.version,
            "protocol": self.header.protocol or None,
        }

    def _run_application(self):
        wrong = self.check()
        if wrong:
            raise RuntimeError("self-test: " + wrong)
        from .application import start as start_application

        self.stage = RUNNING
        print(STARTED, SLOTS[self.slot])
        start_application(self.journal, self.update)
        raise RuntimeError("the application ended")


def running_slot():
    """Return the slot that this runs from: the loader left its vectors' address with the processor."""
    return 0 if machine.mem32[_VTOR] - BASE < slot_at(1) else 1


start = Start(ChipFlash(), running_slot())
