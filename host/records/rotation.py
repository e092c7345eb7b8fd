"""Keeps a folder of records within a size by removing the oldest finished ones.

It never removes a record that this or another process is writing, nor a file that is not a record of `--log FOLDER`.
"""

import fcntl
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

PARTS = 4  # a running record is finished at a quarter of the size, and goes on in another file (chosen)
NAME = re.compile(r"caramelo-\d{8}-\d{6,9}(-\d+)?\.mcap")  # date and time, of older ones without ms


def claim(file: Any) -> None:
    """Mark an open record as being written, for as long as it is open."""
    with suppress(OSError):  # a file system without locks: its records look finished to other processes
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def make_room(folder: Path, most_bytes: int, running: Path) -> None:
    """Remove the oldest finished records until all of them take at most ``most_bytes``. OSError if it can't be done."""
    records = []
    for path in folder.iterdir():
        if NAME.fullmatch(path.name) and path.is_file() and not path.is_symlink() and path != running:
            with suppress(FileNotFoundError):  # another process also keeps this folder small
                about = path.stat()
                records.append((about.st_mtime_ns, path.name, about.st_size, path))
    total = sum(size for _, _, size, _ in records)
    for _, _, size, path in sorted(records):
        if total <= most_bytes:
            return
        if _is_finished(path):
            path.unlink(missing_ok=True)
            total -= size


def _is_finished(path: Path) -> bool:
    with suppress(FileNotFoundError), path.open("rb") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        except OSError:
            return True  # see claim
    return True


def next_part(path: Path, part: int) -> Path:
    """Return the name of a record's part: the second one of "caramelo-DATE-TIME.mcap" ends in "-2.mcap"."""
    first = re.sub(r"(-\d{8}-\d{6,9})-\d+$", r"\1", path.stem)
    return path.with_name(f"{first}-{part}{path.suffix}")
