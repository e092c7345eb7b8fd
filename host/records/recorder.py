"""Writes a record while the robot runs: the loop hands over messages; a thread encodes, writes and syncs them.

Four times a second the current chunk is closed, written and synced, so a power cut costs less than a second. A disk
that is full or gone ends the record, not the walk; one that hangs costs the messages that do not fit into memory.
"""

import json
import os
import queue
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from ..util.errors import UserError
from ..util.files import check_folder, not_written
from .channels import CHANNELS, DRAWN, schema
from .rotation import PARTS, claim, make_room, next_part

SYNC_S = 0.25
MOST_WAITING = 5000  # messages the loop may be ahead of the disk: ten seconds
KEEP_UP_S = 0.01
CLOSE_S = 5.0  # for what is still waiting at the end
CHUNK = 1 << 16  # bytes before compression; a chunk is also closed at each sync
ROBOT = "robot"


class Recorder:
    """One file. ``put`` never blocks; ``trouble`` says why writing has stopped, "" if all is well."""

    def __init__(
        self,
        path: Path,
        about: dict[str, str],
        sync: Callable[[int], None] = os.fsync,
        most_bytes: int | None = None,
    ) -> None:
        """``most_bytes``: limit for this and the older records of its folder together (rotation.py)."""
        self.path, self.trouble, self.dropped = path, "", 0
        self._about, self._sync, self._most_bytes, self._part = about, sync, most_bytes, 0
        self._over = threading.Event()
        self._queue: queue.Queue[tuple[str, int, dict[str, Any]] | None] = queue.Queue(MOST_WAITING)
        self._epoch_ns = time.time_ns() - time.monotonic_ns()
        self._counts = dict.fromkeys((*CHANNELS, *DRAWN), 0)
        try:
            self._begin(path)
        except OSError as error:
            with suppress(OSError):  # what it still holds can't be written either
                self._file.close()
            path.unlink(missing_ok=True)
            raise not_written(f"--log {path}", error) from None
        self._thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._thread.start()

    @property
    def missing(self) -> str:
        """Why a part of the record is missing, so far; empty if none is."""
        return self.trouble or (f"{self.path}: the disk is too slow" if self.dropped else "")

    def _begin(self, path: Path) -> None:
        """Start a file; if it continues another, its metadata contain the part's number."""
        from mcap.writer import CompressionType, Writer

        self._file = _create(path)
        claim(self._file)
        self.path, self._part = path, self._part + 1
        if self._most_bytes is not None:
            try:
                make_room(path.parent, self._most_bytes - self._most_bytes // PARTS, path)
            except OSError as error:
                raise UserError(f"--keep: {error.filename}: can't be removed: {error.strerror}") from None
        self._writer = Writer(self._file, CHUNK, compression=CompressionType.ZSTD)
        self._writer.start(profile="", library="caramelo")
        self._writer.add_metadata(ROBOT, {**self._about, "part": str(self._part)})
        self._ids = {topic: self._register(topic) for topic in (*CHANNELS, *DRAWN)}
        self._force()

    def put(self, topic: str, time_s: float, values: dict[str, Any]) -> None:
        """Hand over a message; ``time_s`` is monotonic. Dropped and counted if the disk can't keep up."""
        try:
            self._queue.put_nowait((topic, self.time_ns(time_s), values))
        except queue.Full:
            self.dropped += 1

    def time_ns(self, time_s: float) -> int:
        """Return a monotonic time as ns since 1970."""
        return self._epoch_ns + int(time_s * 1e9)

    def keep_up(self) -> None:
        """Wait for the disk if it is far behind, which ticks in simulated time need."""
        while self._queue.qsize() > MOST_WAITING // 2 and self._thread.is_alive():
            time.sleep(KEEP_UP_S)

    def close(self) -> None:
        """Write the waiting messages and the index. A disk that hangs gets five seconds, and is then left behind."""
        self._over.set()
        with suppress(queue.Full):  # then it is awake, and looks by itself once it has written all
            self._queue.put_nowait(None)
        self._thread.join(CLOSE_S)
        if self._thread.is_alive():
            self.trouble = self.trouble or f"{self.path}: the disk hangs, so the end of the record is missing"

    def _register(self, topic: str) -> int:
        told = schema(topic)
        number = self._writer.register_schema(told["title"], "jsonschema", json.dumps(told).encode())
        channel: int = self._writer.register_channel(topic, "json", number)
        return channel

    def _write_all(self) -> None:
        try:
            while self._write_some():
                self._force()
                self._go_on()
            self._writer.finish()
            self._force()
        except (OSError, UserError) as error:
            self.trouble = f"{self.path}: the record ends here: {getattr(error, 'strerror', None) or error}"
            self._throw_away()
        finally:
            self._close_file()

    def _go_on(self) -> None:
        """Finish a file that has reached its size, and begin the next."""
        if self._has_its_share():
            self._writer.finish()
            self._force()
            self._file.close()
            self._begin(next_part(self.path, self._part + 1))

    def _has_its_share(self) -> bool:
        return self._most_bytes is not None and self._file.tell() >= self._most_bytes // PARTS

    def _write_some(self) -> bool:
        """Write messages until it is time to sync or to go on in another file; False after the last."""
        end_s = time.monotonic() + SYNC_S
        while (left_s := end_s - time.monotonic()) > 0 and not self._has_its_share():
            try:
                message = self._queue.get(timeout=left_s)
            except queue.Empty:
                return not self._over.is_set()
            if message is None:
                return False
            self._write(*message)
        return True

    def _write(self, topic: str, time_ns: int, values: dict[str, Any]) -> None:
        data = json.dumps(values, separators=(",", ":")).encode()
        self._writer.add_message(self._ids[topic], time_ns, data, time_ns, self._counts[topic])
        self._counts[topic] += 1

    def _force(self) -> None:
        self._writer.flush()
        self._file.flush()
        self._sync(self._file.fileno())

    def _close_file(self) -> None:
        try:
            self._file.close()
        except OSError as error:
            self.trouble = self.trouble or f"{self.path}: {error.strerror or error}"

    def _throw_away(self) -> None:
        """Let the loop go on without a record."""
        while True:
            try:
                message = self._queue.get(timeout=SYNC_S)
            except queue.Empty:
                message = None
            if message is not None:
                self.dropped += 1
            elif self._over.is_set():
                return


def record_path(wanted: Path) -> Path:
    """Return the file to write: ``wanted`` if it ends in .mcap; any other name is a folder for a new file."""
    if wanted.suffix != ".mcap" or wanted.is_dir():
        now = datetime.now()  # to the ms: a program may open a simulated robot many times a second
        return wanted / f"caramelo-{now:%Y%m%d-%H%M%S}{now.microsecond // 1000:03}.mcap"
    return wanted


def _create(path: Path) -> Any:
    """Open a new file; an older record is never overwritten."""
    try:
        check_folder("--log", path.parent)
        path.parent.mkdir(parents=True, exist_ok=True)
        return path.open("xb")
    except FileExistsError:
        raise UserError(f"--log {path}: the file exists: name another, or a folder") from None
    except OSError as error:
        raise not_written(f"--log {path}", error) from None
