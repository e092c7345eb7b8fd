"""A board's files from the host: what lies there, writing, removing, renaming, hashing, by scripts at its prompt."""

import base64
import errno
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from firmware.slots import LOG, parse_pointer

from ..errors import UserError
from .link import BoardError, BoardLink, BoardScriptError

CHUNK = 1024  # bytes a script carries
ROOT_FILES = ("slots.py", "main.py", "boot.py")  # in this order onto a fresh board
NODE_FILE = "node.txt"  # the joint's id, until it has taken it over (firmware/start_joint.py)

# Sent first to every board: works on one that has never seen our firmware. ``slots`` is firmware/slots.py if it runs.
_HELPERS = """
import binascii, gc, hashlib, json, os, sys
slots = sys.modules.get("slots")
root = (slots.start.root if slots else os.getcwd()).rstrip("/") + "/"
if slots and not slots.start.watchdog:
    slots.hold_watchdog()
def feed():
    if slots:
        slots.feed()
def read_text(name):
    try:
        with open(root + name) as file:
            return file.read()
    except (OSError, ValueError):
        return None
def digest(path):
    feed()
    h = hashlib.sha256()
    buffer = bytearray(512)
    view = memoryview(buffer)
    with open(root + path, "rb") as file:
        while True:
            count = file.readinto(buffer)
            if not count:
                return binascii.hexlify(h.digest()).decode()
            h.update(view[:count])
def walk(folder, found, folders):
    for entry in os.ilistdir(root + folder):
        path = folder + "/" + entry[0]
        if entry[1] & 0x4000:
            walk(path, found, folders)
            folders.append(path)
        else:
            found[path] = [digest(path), os.stat(root + path)[6]]
def answer(value):
    print("@@" + json.dumps(value))
"""
_SURVEY = """
found = {}
folders = []
for entry in os.ilistdir(root):
    if entry[0] in ("a", "b") and entry[1] & 0x4000:
        walk(entry[0], found, folders)
    elif entry[0] in ("slots.py", "main.py", "boot.py"):
        found[entry[0]] = [digest(entry[0]), os.stat(root + entry[0])[6]]
supply = None
if slots and slots.start.slot:
    try:
        from firmware import application
        supply = application.motor_supply_mV()
    except Exception:
        supply = None  # a firmware that can't be imported has started nothing, and must be replaceable
try:
    import vfs
    mounted = [(type(m[0]).__name__, m[1]) for m in vfs.mount()]
except (ImportError, TypeError):
    mounted = []
space = os.statvfs(root)
answer({"mpy": getattr(sys.implementation, "_mpy", 0), "version": list(sys.implementation[1])[:3],
    "machine": getattr(sys.implementation, "_machine", ""), "block": space[0], "free": space[0] * space[3],
    "mounted": mounted, "root": root, "files": found, "folders": folders, "pointer": read_text("slot.txt"),
    "node": read_text("node.txt"), "supply_mV": supply, "report": slots.report() if slots else None})
"""


@dataclass(frozen=True)
class Survey:
    """What lies on a board: sha256 and size by path of both slots and the root files, and what the board is."""

    mpy: int
    version: str
    machine: str
    filesystem: str
    block: int
    free: int
    files: dict[str, str]
    sizes: dict[str, int]
    folders: tuple[str, ...]
    pointer: tuple[str, str, int, int] | None
    node: str | None
    supply_mV: int | None
    report: dict[str, Any] | None

    @property
    def kept_slot(self) -> str:
        """The slot that would start if nothing else did and so has to stay as it is; "" on a fresh board."""
        order = ["a", "b"]
        if self.pointer is not None:
            active, fallback, _, confirmed = self.pointer
            order = [active, fallback] if confirmed else [fallback, active]
        return next((slot for slot in [*order, "a", "b"] if self.complete(slot)), "")

    def complete(self, slot: str) -> bool:
        """Return True if the slot holds a whole firmware."""
        return f"{slot}/manifest.json" in self.files


class BoardFiles:
    """Files of the board behind ``link``; each call is one or more scripts."""

    def __init__(self, link: BoardLink) -> None:
        self.link = link
        link.run(_HELPERS)

    def survey(self) -> Survey:
        """Return what lies on the board."""
        found = self.link.ask(_SURVEY, timeout_s=60)
        pointer = parse_pointer(found["pointer"]) if found["pointer"] else None
        return Survey(
            mpy=found["mpy"],
            version=".".join(map(str, found["version"])),
            machine=found["machine"],
            filesystem=_filesystem(found["mounted"], found["root"]),
            block=found["block"],
            free=found["free"],
            files={path: entry[0] for path, entry in found["files"].items()},
            sizes={path: entry[1] for path, entry in found["files"].items()},
            folders=tuple(found["folders"]),
            pointer=pointer,
            node=found["node"],
            supply_mV=found["supply_mV"],
            report=found["report"],
        )

    def digest(self, path: str) -> str:
        """Return the sha256 of a file as the board reads it."""
        return str(self.link.ask(f"answer({{'sha256': digest({path!r})}})")["sha256"])

    def make_folder(self, path: str) -> None:
        """Make one folder, if it is not there."""
        self._step(f"try:\n    os.mkdir(root + {path!r})\nexcept OSError as e:\n    if e.args[0] != 17:\n        raise")

    def remove(self, path: str) -> None:
        """Remove one file."""
        self._step(f"os.remove(root + {path!r})")

    def remove_folder(self, path: str) -> None:
        """Remove one empty folder."""
        self._step(f"os.rmdir(root + {path!r})")

    def rename(self, old: str, new: str) -> None:
        """Rename a file over another: on LittleFS that happens wholly or not at all."""
        self._step(f"os.rename(root + {old!r}, root + {new!r})\nif hasattr(os, 'sync'):\n    os.sync()")

    def write(self, path: str, data: bytes, done: Callable[[int], None]) -> None:
        """Write one file, a script for each part; ``done`` is told its bytes."""
        start = f"out = open(root + {path!r}, 'wb')\n"
        for at in range(0, max(1, len(data)), CHUNK):
            part = data[at : at + CHUNK]
            end = "\nout.close()" if at + CHUNK >= len(data) else ""
            self._step(f"{start}out.write(binascii.a2b_base64({base64.b64encode(part)!r})){end}")
            start = ""
            done(len(part))

    def copy(self, old: str, new: str) -> None:
        """Copy a file on the board itself."""
        self._step(
            f"with open(root + {old!r}, 'rb') as old, open(root + {new!r}, 'wb') as new:\n"
            "    part = old.read(512)\n    while part:\n        feed()\n        new.write(part)\n"
            "        part = old.read(512)"
        )

    def replace(self, path: str, data: bytes) -> None:
        """Write a file of the root beside its old self, compare, and rename it over."""
        import hashlib

        self.write(path + ".new", data, lambda count: None)
        if self.digest(path + ".new") != hashlib.sha256(data).hexdigest():
            raise BoardError(f"{self.link.port}: {path}: the board reads back something else: is its flash worn out?")
        self.rename(path + ".new", path)

    def log(self) -> str:
        """Return the board's log."""
        return str(self.link.ask(f"answer({{'log': read_text({LOG!r})}})")["log"] or "")

    def _step(self, script: str) -> None:
        try:
            self.link.run("feed()\n" + script)
        except BoardScriptError as error:
            if error.number == errno.ENOSPC:
                raise BoardError(
                    f"{self.link.port}: the board's file system is full: remove files of your own from it "
                    f"(caramelo board shell), then flash again; the old firmware still starts"
                ) from error
            raise


def check_filesystem(port: str, survey: Survey) -> None:
    """UserError unless files of this file system can be replaced without ever being torn."""
    if survey.filesystem != "VfsLfs2":
        raise UserError(
            f"{port}: its file system is {survey.filesystem}: a power cut tears files on it; "
            f"format it as LittleFS once (docs/flashing.md)"
        )


def _filesystem(mounted: list[list[str]], root: str) -> str:
    """Return the type of the file system that holds ``root``."""
    fitting = [(len(point), kind) for kind, point in mounted if root.startswith(point.rstrip("/") + "/")]
    return max(fitting)[1] if fitting else "unknown"
