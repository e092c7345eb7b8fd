"""What a bare board gets once: loader and slot A, as a file for dfu-util (DfuSe, ST's UM0391) and as Intel HEX."""

import struct
import zlib

from firmware.flash_map import BASE, slot_at

from .image_file import ImageFile

_VENDOR, _PRODUCT, _DEVICE = 0x0483, 0xDF11, 0xFFFF  # ST's loader in ROM; any version of it
_DFUSE = 0x011A
_RECORD_BYTES = 32


def parts(image: ImageFile) -> list[tuple[int, bytes]]:
    """Return what goes where in the flash, by address."""
    return [(BASE, image.loader), (BASE + slot_at(0), image.slots[0])]


def dfu_file(image: ImageFile) -> bytes:
    """Return a DfuSe file with one target, the internal flash."""
    elements = b"".join(struct.pack("<II", at, len(data)) + data for at, data in parts(image))
    target = struct.pack("<6sBI255sII", b"Target", 0, 1, b"caramelo", len(elements), len(parts(image))) + elements
    head = struct.pack("<5sBIB", b"DfuSe", 1, len(target) + 11, 1)
    suffix = struct.pack("<HHHH3sB", _DEVICE, _PRODUCT, _VENDOR, _DFUSE, b"UFD", 16)
    whole = head + target + suffix
    return whole + struct.pack("<I", zlib.crc32(whole) ^ 0xFFFFFFFF)


def hex_file(image: ImageFile) -> str:
    """Return the same as Intel HEX, for programmers on the debug port."""
    lines = []
    for start, data in parts(image):
        for at in range(0, len(data), _RECORD_BYTES):
            address = start + at
            if at == 0 or address & 0xFFFF == 0:
                lines.append(_record(4, 0, struct.pack(">H", address >> 16)))
            lines.append(_record(0, address & 0xFFFF, data[at : at + _RECORD_BYTES]))
    return "\n".join([*lines, _record(1, 0, b"")]) + "\n"


def _record(kind: int, offset: int, data: bytes) -> str:
    body = struct.pack(">BHB", len(data), offset, kind) + data
    return f":{body.hex().upper()}{-sum(body) & 0xFF:02X}"
