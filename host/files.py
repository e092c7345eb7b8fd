"""Files appear whole or not at all: written beside their place under a hidden name, then renamed."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from .errors import UserError


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
