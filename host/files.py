"""Files appear whole or not at all: written beside their place under a hidden name, then renamed."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import UserError


def check_folder(flag: str, path: Path | None) -> None:
    """Refuse a folder that results can't be written to before hours of work are lost to it; make nothing yet."""
    if path is None:
        return
    there = next(place for place in (path.absolute(), *path.absolute().parents) if place.exists())
    if not there.is_dir():
        raise UserError(f"{flag} {path}: {there} is a file: name a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise UserError(f"{flag} {path}: {there} may not be written by you: name another folder")


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a hidden path with the same ending to write to; it becomes ``path`` if the block ends well.

    Any exception, Ctrl-C included, leaves an older ``path`` as it was. Missing folders are made.
    UserError if the system refuses.
    """
    draft = path.with_name(f".{path.stem}.{os.getpid()}{path.suffix}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            yield draft
            os.replace(draft, path)
        finally:
            draft.unlink(missing_ok=True)
    except OSError as error:
        raise UserError(f"{path}: can't be written: {error.strerror or error}") from error


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file whole and onto the disk, or not at all."""
    with atomic_path(path) as draft, draft.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def write_text(path: Path, content: str) -> None:
    """Write a UTF-8 text file whole and onto the disk, or not at all."""
    write_bytes(path, content.encode())
