"""Small firmware for pretend boards: the project's start-up and update, and an application that says its version.

What is linked and frozen on a board is here a text of modules; both halves of the image hold the same.
"""

import json
from functools import cache

from host import ROOT
from host.boards.build.image_file import make_image
from host.boards.build.source import closure, read_modules

APPLICATION = '''"""Application of a test."""

WATCHDOG = {watchdog}
VERSION = "{version}"


def motor_supply_mV():
    return {supply}


def armed():
    return {armed}


def start(journal, update):
    import time

    print("running", VERSION)
    {body}
    print("in its loop")
    while True:
        time.sleep_ms(5)
'''
IN_ITS_LOOP = b"in its loop"  # said when nothing is left in which it could fail
RUNTIME = ("firmware.startup", "firmware.main", "shared.runtime")

# What the pretend board's own harness needs, and no more: MicroPython without our firmware.
LAYOUT_ONLY = {path: (ROOT / path).read_text() for path in ("firmware/flash_map.py", "shared/runtime.py")}


def make(version="1", role="gait", board="CARAMELO_GAIT", protocol=None, text=None, modules=None, **parts):
    """Return an image: ``parts`` of the application that differ from harmless ones, or its whole ``text``."""
    words = {"supply": 0, "armed": False, "watchdog": False, "body": "pass", "self_test": "return ''"} | parts
    files = dict(frame() if modules is None else modules)
    files.setdefault("firmware/selftest.py", f"def self_test():\n    {words.pop('self_test')}\n")
    files.setdefault("firmware/application.py", text or APPLICATION.format(version=version, **words))
    files["padding"] = version * 3000
    packed = json.dumps(files, sort_keys=True).encode()
    return make_image(role, board, version, protocol, "1.29.0", [packed, packed], b"\xff" * 256)


@cache
def frame(*more):
    """Return, read once, the modules that start a board, quick to start, without those that tests replace."""
    known = read_modules(ROOT)
    names = closure(known, [*RUNTIME, *more])
    names = [name for name in names if name not in ("firmware.selftest", "firmware.chip_flash")]
    files = {known[name].path: known[name].text.decode() for name in names if not name.startswith("shared.num.fixed")}
    files["main.py"] = files.pop("firmware/main.py")
    startup = files["firmware/startup.py"]
    # Short, but long enough for the host to listen again when it says that it has started: else it waits in vain.
    files["firmware/startup.py"] = startup.replace("_START_DELAY_MS = 500", "_START_DELAY_MS = 300")
    return files
