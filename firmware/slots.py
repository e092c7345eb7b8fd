"""Two slots of firmware, ``a`` and ``b``: which one starts, and back to the old one when the new one does not confirm.

Lies at the board's root as slots.py, beside boot.py and main.py which only call it. ``slot.txt`` says which slot
starts; it is written beside the old one and renamed over it, so that a power cut leaves either the old or the new:

    active fallback starts confirmed crc32

A slot is complete when it holds manifest.json, which is written last and removed first. A slot not yet confirmed may
start three times; then its fallback is the active one again. ``caramelo flash`` confirms after the self-test.
"""

import binascii
import json
import os
import sys
import time

POINTER = "slot.txt"
LOG = "log.txt"
MANIFEST = "manifest.json"
STARTS = 3  # of a slot that nobody confirms (chosen)
LOG_BYTES = 4096  # then the log starts anew (chosen)
START_DELAY_MS = 500  # in which Ctrl-C keeps the application from starting (chosen)
STARTED = "firmware started from slot"  # said when the application gets the board
HOLD_MS = 32000  # the longest a STM32's watchdog waits is 32767 ms

CHOSEN = "chosen"
RUNNING = "running"
STOPPED = "stopped"
FAILED = "failed"


class Start:
    """What happened since power-on; ``start`` below is the only one."""

    def __init__(self):
        self.root = os.getcwd()
        self.slot = ""  # "" : none is complete
        self.stage = ""
        self.self_test = None  # "" when it passed
        self.error = ""
        self.watchdog = None  # the application's, taken over when it was stopped

    def path(self, name):
        """Return where a file of the root is, wherever the application may have gone."""
        return self.root.rstrip("/") + "/" + name


start = Start()


def pack_pointer(active, fallback, starts, confirmed):
    """Return the text of the pointer file; ``fallback`` is ``-`` when there is none."""
    line = f"{active} {fallback} {starts} {confirmed}"
    return f"{line} {binascii.crc32(line.encode()):08x}\n"


def parse_pointer(text):
    """Return (active, fallback, starts, confirmed), or None if the text is not a whole pointer."""
    words = text.split()
    if len(words) != 5 or words[0] not in ("a", "b") or words[1] not in ("a", "b", "-"):
        return None
    if not (words[2].isdigit() and words[3] in ("0", "1")):
        return None
    if pack_pointer(words[0], words[1], int(words[2]), int(words[3])).split() != words:
        return None
    return words[0], words[1], int(words[2]), int(words[3])


def read_pointer():
    """Return the pointer as parse_pointer does; None without a whole one."""
    try:
        with open(start.path(POINTER)) as file:
            return parse_pointer(file.read())
    except (OSError, ValueError):
        return None


def write_pointer(active, fallback, starts, confirmed):
    """Replace the pointer file as a whole."""
    replace(POINTER, pack_pointer(active, fallback, starts, confirmed))


def replace(name, text):
    """Write a file of the root beside its old self and rename it over."""
    draft = start.path(name + ".new")
    with open(draft, "w") as file:
        file.write(text)
    os.rename(draft, start.path(name))
    if hasattr(os, "sync"):
        os.sync()


def complete(slot):
    """Return True if the slot holds a whole firmware."""
    try:
        os.stat(start.path(slot + "/" + MANIFEST))
    except OSError:
        return False
    return True


def choose():
    """Choose the slot of this start, count the start of one not yet confirmed, and make it importable."""
    pointer = read_pointer()
    slot = _by_pointer(*pointer) if pointer else ""
    if not slot:
        slot = "a" if complete("a") else "b" if complete("b") else ""
        if slot and pointer:
            note(f"slot {pointer[0]} is not complete: starting slot {slot}")
    start.slot = slot
    start.stage = CHOSEN
    if slot:
        sys.path.insert(0, start.path(slot))


def _by_pointer(active, fallback, starts, confirmed):
    """Return the slot the pointer stands for now; "" if it is not complete."""
    if not confirmed and starts >= STARTS and fallback != "-" and complete(fallback):
        note(f"slot {active} was not confirmed in {starts} starts: back to slot {fallback}")
        write_pointer(fallback, "-", 0, 1)
        return fallback
    if not complete(active):
        return ""
    if not confirmed and starts < STARTS:
        write_pointer(active, fallback, starts + 1, 0)
    return active


def run():
    """Test the chosen firmware and run its application; what goes wrong is noted in the log."""
    if not start.slot:
        print("no firmware here: caramelo flash --port DEVICE")
        return
    try:
        time.sleep_ms(START_DELAY_MS)
        _run_application()
    except KeyboardInterrupt:
        hold_watchdog()
        if start.stage == RUNNING:
            start.stage = STOPPED
        print("stopped")
    except Exception as error:
        hold_watchdog()
        start.stage = FAILED
        start.error = _words(error)
        note(f"slot {start.slot}: {start.error}")
        print(start.error)
        if not confirmed():
            restart()


def check():
    """Run the slot's self-test; return "" or what is wrong."""
    from firmware.selftest import self_test

    start.self_test = self_test()
    return start.self_test


def confirmed():
    """Return True if the pointer says that the running slot is to stay."""
    pointer = read_pointer()
    return pointer is not None and pointer[0] == start.slot and pointer[3] == 1


def confirm():
    """Make the running slot the one that starts from now on."""
    pointer = read_pointer()
    fallback = pointer[1] if pointer and pointer[0] == start.slot else "-"
    write_pointer(start.slot, fallback, 0, 1)


def report():
    """Return what the host asks after a start, as a dictionary."""
    answer = {
        "slot": start.slot,
        "stage": start.stage,
        "self_test": start.self_test,
        "error": start.error,
        "confirmed": confirmed(),
        "build": None,
        "role": None,
        "version": None,
        "protocol": None,
    }
    if not start.slot:
        return answer
    try:
        with open(start.path(start.slot + "/" + MANIFEST)) as file:
            manifest = json.load(file)
        answer["build"], answer["role"] = manifest["build"], manifest["role"]
        from firmware import application

        answer["version"], answer["protocol"] = application.VERSION, application.PROTOCOL
    except Exception as error:
        answer["error"] = answer["error"] or _words(error)
    return answer


def hold_watchdog():
    """Take over a watchdog that the application may have started: it can't be stopped, but it can be slow."""
    application = sys.modules.get("firmware.application")
    if application and application.WATCHDOG:
        import machine

        start.watchdog = machine.WDT(timeout=HOLD_MS)


def feed():
    """Put off the watchdog that was taken over from the application."""
    if start.watchdog:
        start.watchdog.feed()


def restart():
    """Reset the board."""
    import machine

    machine.reset()


def note(sentence):
    """Add a line to the log; a log that can't be written must not keep the board from starting."""
    try:
        try:
            full = os.stat(start.path(LOG))[6] > LOG_BYTES
        except OSError:
            full = True
        with open(start.path(LOG), "w" if full else "a") as file:
            file.write(sentence + "\n")
    except OSError:
        print(sentence)


def _run_application():
    wrong = check()
    if wrong:
        raise RuntimeError("self-test: " + wrong)
    from firmware.application import start as start_application

    start.stage = RUNNING
    print(STARTED, start.slot)
    start_application()
    raise RuntimeError("the application ended")


def _words(error):
    return f"{type(error).__name__}: {error}"
