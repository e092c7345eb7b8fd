"""Files appear complete or not at all: they are written beside their place under a hidden name, then renamed."""

import errno
import os
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any
from urllib.parse import quote

from .errors import NOT_ACHIEVED, WRONG_USE, UserError

DEEPEST = 20  # tables and lists within each other in a TOML file; ours have four
LARGEST = 100_000_000  # bytes: an hour of a recorded sensor has a tenth
TOO_DEEP = "its tables or lists are nested too deeply"


def check_folder(flag: str, path: Path | None) -> None:
    """Refuse a folder that can't take results before hours of work would be lost; create nothing yet."""
    if path is None:
        return
    there = next(place for place in (path.absolute(), *path.absolute().parents) if place.exists())
    if not there.is_dir():
        raise UserError(f"{flag} {path}: {there} is a file: name a folder")
    if not os.access(there, os.W_OK | os.X_OK):
        raise UserError(f"{flag} {path}: you may not write to {there}: name another folder")


def check_file(flag: str, path: Path | None) -> None:
    """Refuse a name that no file can have before hours of work would be lost; create nothing yet."""
    if path is not None:
        _refuse_no_file(path, f"{flag} {path}")
        check_folder(flag, path.parent)


def _refuse_no_file(path: Path, told: str) -> None:
    if not path.name:
        raise UserError(f"{told}: names no file to write: give it a name")
    if path.exists() and not path.is_file():
        raise UserError(f"{told}: can't be written: it is a folder or a device: name a file")


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn the system's errors while writing ``path`` into one sentence."""
    try:
        yield
    except OSError as error:
        raise not_written(path, error) from error


def not_written(place: object, error: OSError) -> UserError:
    """Return what the system refused to write, in one sentence; on a full disk another name would not help."""
    full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    return UserError(f"{place}: can't be written: {error.strerror or error}", NOT_ACHIEVED if full else WRONG_USE)


def file_name(foreign: str) -> str:
    """Return a name from a file or a board as the name of one file, which can't lead elsewhere.

    All but ASCII letters, digits and ``_.-~`` becomes ``%2F`` and the like, also a leading dot; different names stay
    different.
    """
    name = quote(foreign.encode("utf-8", "surrogatepass"), safe="")
    return f"%2E{name[1:]}" if name.startswith(".") else name or "%"


def read_toml(path: Path) -> dict[str, Any]:
    """Return the tables of a TOML file; OSError if it can't be read, ValueError if it is not TOML."""
    return parse_toml(read_text(path))


def read_text(path: Path) -> str:
    """Return the text of a UTF-8 file, without the mark that some editors put before it; OSError if it is too large."""
    return read_bytes(path).decode("utf-8-sig").replace("\r\n", "\n")


def read_bytes(path: Path) -> bytes:
    """Return the content of a file; OSError if it is too large: a device may never end."""
    with path.open("rb") as file:
        content = file.read(LARGEST + 1)
    if len(content) > LARGEST:
        raise OSError(errno.EFBIG, os.strerror(errno.EFBIG))
    return content


def parse_toml(text: str) -> dict[str, Any]:
    """Return the tables of a TOML file's text; ValueError if it is not TOML."""
    try:
        tables = tomllib.loads(text)
    except RecursionError:
        raise ValueError(TOO_DEEP) from None
    inner: list[Any] = [tables]
    for _ in range(DEEPEST):
        inner = [each for table in inner for each in (table.values() if isinstance(table, dict) else table)
                 if isinstance(each, dict | list)]  # fmt: skip
    if inner:
        raise ValueError(TOO_DEEP)
    return tables


@contextmanager
def atomic_path(path: Path) -> Iterator[Path]:
    """Yield a hidden path with the same ending to write to; it becomes ``path`` if the block ends well.

    Any exception, Ctrl-C included, leaves an older ``path`` and the folders as they were. Missing folders are made. A
    link stays one. UserError if the system refuses, or if ``path`` is a folder or a device, or a folder's by its form.
    """
    with writing(path):
        _refuse_no_file(path, str(path))
        place = Path(os.path.realpath(path))
        draft = place.with_name(f".{place.stem}.{os.getpid()}{place.suffix}")
        made = [folder for folder in place.parents if not folder.exists()]
        try:
            place.parent.mkdir(parents=True, exist_ok=True)
            yield draft
            os.replace(draft, place)
        finally:
            with suppress(OSError):  # it may never have been made
                draft.unlink()
            with suppress(OSError):  # as soon as one is not empty, as all are after a success
                for folder in made:
                    folder.rmdir()


def write_bytes(path: Path, content: bytes) -> None:
    """Write a complete file and sync it to the disk, or write nothing."""
    with atomic_path(path) as draft, draft.open("wb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def write_text(path: Path, content: str) -> None:
    """Write a complete UTF-8 text file and sync it to the disk, or write nothing."""
    write_bytes(path, content.encode())
