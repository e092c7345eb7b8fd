"""The flash of an STM32F405 as caramelo divides it, a slot's header and the boot records; firmware/loader/ reads them.

    sector 0, 16 KiB          the loader, written once
    sector 1, 16 KiB          boot records, appended to
    sectors 2, 3, 16 KiB each the settings' journal (settings.py)
    sectors 4-7, 448 KiB      slot A
    sectors 8-11, 512 KiB     slot B
"""

import binascii
import struct

from shared.runtime import const

BASE = const(0x08000000)  # where the flash lies in the processor's memory; everything else here counts from it
SIZE = const(0x100000)
SECTOR_KIB = (16, 16, 16, 16, 64, 128, 128, 128, 128, 128, 128, 128)  # RM0090, table 5

RECORDS_SECTOR = const(1)
SETTINGS_SECTORS = (2, 3)
SLOT_SECTORS = ((4, 5, 6, 7), (8, 9, 10, 11))
SLOTS = "ab"

HEADER = const(512)  # bytes; the image behind it begins with its vectors, which have to be aligned so
IMAGE_MOST = const(448 * 1024 - 512)
_MAGIC = const(0x4C524143)
_FORMAT = const(1)
_FIELDS = "<IIIIII32s16s16s16s8s"

CONFIRMED = const(0xFF)  # in the place of the starts that a slot has left
TRIAL_STARTS = const(3)  # of a slot that nobody confirms (chosen)
_RECORD_MAGIC = const(0xB007)  # its upper half
_BLANK = b"\xff" * 8
_STRIDE = const(256)  # blank ones are passed over so many bytes at a time


def sector_at(sector):
    """Return where a sector begins."""
    return sum(SECTOR_KIB[:sector]) * 1024


def sector_bytes(sector):
    """Return how long a sector is."""
    return SECTOR_KIB[sector] * 1024


def slot_at(slot):
    """Return where the slot 0 or 1 begins, with its header."""
    return sector_at(SLOT_SECTORS[slot][0])


class Header:
    """What a slot holds: ``slot`` 0 or 1, ``length`` of the image in bytes, texts as str, ``sha256`` of the image."""

    def __init__(self, slot, length, image_crc, protocol, sha256, board, build, version, role):
        self.slot = slot
        self.length = length
        self.image_crc = image_crc
        self.protocol = protocol  # hash of the wire protocol; 0 for a board that speaks none
        self.sha256 = sha256
        self.board = board
        self.build = build
        self.version = version
        self.role = role

    def pack(self):
        """Return the header's 512 bytes, with their CRC-32 at the end."""
        texts = [text.encode() for text in (self.board, self.build, self.version, self.role)]
        fields = (_MAGIC, _FORMAT, self.slot, self.length, self.image_crc, self.protocol, self.sha256)
        head = struct.pack(_FIELDS, *fields, *texts)
        head += b"\xff" * (HEADER - 4 - len(head))
        return head + struct.pack("<I", binascii.crc32(head))


def parse_header(data):
    """Return the Header in 512 bytes, or None if they are not a whole one."""
    data = bytes(data)
    if len(data) != HEADER or struct.unpack("<I", data[-4:])[0] != binascii.crc32(data[:-4]):
        return None
    magic, form, slot, length, crc, protocol, sha256, *texts = struct.unpack_from(_FIELDS, data, 0)
    if magic != _MAGIC or form != _FORMAT or slot > 1 or not 0 < length <= IMAGE_MOST or length % 4:
        return None
    board, build, version, role = [text.split(b"\0")[0].decode() for text in texts]
    return Header(slot, length, crc, protocol, sha256, board, build, version, role)


def pack_record(slot, starts):
    """Return a boot record: this slot is to start, so often or CONFIRMED. A word and its complement, little-endian."""
    low = slot << 8 | starts
    return struct.pack("<HHHH", low, _RECORD_MAGIC, low ^ 0xFFFF, _RECORD_MAGIC ^ 0xFFFF)


def parse_record(data):
    """Return (slot, starts) from eight bytes, or None if they are no whole record."""
    low, magic, low_again, magic_again = struct.unpack("<HHHH", data)
    if low ^ low_again != 0xFFFF or magic ^ magic_again != 0xFFFF or magic != _RECORD_MAGIC or low > 0x1FF:
        return None
    return low >> 8, low & 0xFF


def read_records(view):
    """Return (last record or None, where the next one goes) of the boot records' sector."""
    last = None
    following = 0
    for start in range(0, len(view), _STRIDE):
        part = bytes(view[start : start + _STRIDE])
        if part == _BLANK * (_STRIDE // 8):
            continue
        for at in range(0, _STRIDE, 8):
            data = part[at : at + 8]
            if data != _BLANK:
                following = start + at + 8
                last = parse_record(data) or last
    return last, following
