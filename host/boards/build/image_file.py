"""An image file, ``.caramelo``: the same firmware linked for either slot of a board, and the loader. A zip archive.

``image.json`` says what it is, ``slot_a.bin`` and ``slot_b.bin`` are what goes into a slot, header first, and
``loader.bin`` is written once by DFU (dfu.py).
"""

import binascii
import hashlib
import io
import json
import zipfile
import zlib
from dataclasses import asdict, dataclass
from pathlib import Path

from firmware.flash_map import HEADER, IMAGE_MOST, SLOTS, Header, parse_header

from ...util.errors import UserError
from ...util.files import read_bytes, write_bytes

FORMAT = 1
_ABOUT = "image.json"
_DAMAGED = (  # what zipfile and json raise for a file in which anything may stand
    OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, RuntimeError, zipfile.BadZipFile, zlib.error)


@dataclass(frozen=True)
class About:
    """What an image is. ``protocol`` is None for a board that speaks none; ``build`` is a hash of both slots."""

    role: str
    board: str
    build: str
    version: str
    protocol: int | None
    micropython: str


@dataclass(frozen=True)
class ImageFile:
    """``slots`` are the two slots' bytes, header first."""

    about: About
    slots: tuple[bytes, bytes]
    loader: bytes

    def header(self, slot: int) -> Header:
        """Return the header of a slot's half."""
        found = parse_header(self.slots[slot][:HEADER])
        assert found is not None
        return found


def make_image(
    role: str, board: str, version: str, protocol: int | None, micropython: str, images: list[bytes], loader: bytes
) -> ImageFile:
    """Put headers before both linked images."""
    images = [image + b"\xff" * (-len(image) % 4) for image in images]
    build = hashlib.sha256(b"".join(images)).hexdigest()[:16]
    about = About(role, board, build, version, protocol, micropython)
    a, b = (_headed(slot, image, about) for slot, image in enumerate(images))
    return ImageFile(about, (a, b), loader)


def _headed(slot: int, image: bytes, about: About) -> bytes:
    if len(image) > IMAGE_MOST:
        raise ValueError(f"{len(image)} bytes: a slot holds {IMAGE_MOST}")
    digest = hashlib.sha256(image).digest()
    texts = (about.board, about.build, about.version, about.role)
    head = Header(slot, len(image), binascii.crc32(image), about.protocol or 0, digest, *texts)
    return head.pack() + image


def write_image_file(image: ImageFile, path: Path) -> None:
    """Write the file whole; the same image gives the same bytes."""
    parts = {_ABOUT: json.dumps({"format": FORMAT, **asdict(image.about)}, indent=1).encode() + b"\n"}
    parts |= {f"slot_{SLOTS[slot]}.bin": data for slot, data in enumerate(image.slots)}
    parts["loader.bin"] = image.loader
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in parts.items():
            archive.writestr(zipfile.ZipInfo(name), data, zipfile.ZIP_DEFLATED)
    write_bytes(path, packed.getvalue())


def read_image_file(path: Path) -> ImageFile:
    """Return the image of a file; UserError if it is none, or not whole."""
    try:
        with zipfile.ZipFile(io.BytesIO(read_bytes(path))) as archive:
            about = json.loads(archive.read(_ABOUT))
            slots = tuple(archive.read(f"slot_{name}.bin") for name in SLOTS)
            loader = archive.read("loader.bin")
        if about.pop("format") != FORMAT:
            raise ValueError("of another format")
        found = ImageFile(About(**about), (slots[0], slots[1]), loader)
    except FileNotFoundError as error:
        raise UserError(f"{path}: no such file: caramelo firmware image makes it") from error
    except _DAMAGED as error:
        raise UserError(f"{path}: not an image file of caramelo: make it anew with caramelo firmware image") from error
    _check(path, found)
    return found


def _check(path: Path, image: ImageFile) -> None:
    """UserError unless both halves are whole and what the file says."""
    for slot, data in enumerate(image.slots):
        header = parse_header(data[:HEADER])
        if header is None or header.slot != slot or hashlib.sha256(data[HEADER:]).digest() != header.sha256:
            raise UserError(f"{path}: slot {SLOTS[slot]} in it is damaged: make it anew with caramelo firmware image")
        said = (image.about.board, image.about.build, image.about.role, image.about.protocol or 0)
        if (header.board, header.build, header.role, header.protocol) != said:
            raise UserError(f"{path}: slot {SLOTS[slot]} in it is not what the file says it is: make it anew")
