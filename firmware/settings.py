"""Settings that a board keeps over a power cycle, in a journal of two sectors: key -> bytes, the last one counts.

A sector in use begins with its number, a word and its complement. Records follow: magic, length of the key, length of
the data, key, data, padded with ones to words, CRC-32 of all that. ``tidy`` copies what counts into the other sector
and writes that sector's number last: until then the old one is read. A power cut leaves the old value or the new.
"""

import binascii
import struct

from shared.runtime import const

from .flash_map import SETTINGS_SECTORS, sector_at, sector_bytes

_MAGIC = const(0x5E)
_HEAD = "<BBH"  # magic, length of the key, length of the data
_HEAD_BYTES = const(4)
_NUMBER_BYTES = const(8)
_BLANK = b"\xff\xff\xff\xff"
_FULL = const(4096)  # bytes used from which tidy makes room (chosen: nine savings of a joint still fit)


class Journal:
    """The settings in ``flash`` (chip_flash.py). Nothing in here erases but ``tidy``, which is for start-up."""

    def __init__(self, flash):
        self._flash = flash
        self._sectors = SETTINGS_SECTORS
        self._now = -1  # 0 or 1; -1 : neither sector is in use
        self._number = 0
        self._end = 0
        self._places = {}  # key -> (where its data begin, how long they are)
        self._open()

    def get(self, key):
        """Return the bytes last put under a key, None without any."""
        if key not in self._places:
            return None
        at, count = self._places[key]
        return bytes(self._flash.view(at, count))

    def put(self, key, data):
        """Keep ``data``; return 1, or 0 if they do not fit or read back differently: then the old ones count.

        A journal that was never tidied, on a new board, keeps nothing.
        """
        return self._append(self._now, key, data) if self._now >= 0 else 0

    def tidy(self):
        """Make room if much is used: erases a sector, which takes up to half a second, so only before a watchdog."""
        if self._now >= 0 and self._end < _FULL:
            return
        kept = {key: self.get(key) for key in self._places}
        self._begin(1 - self._now if self._now >= 0 else 0, self._number + 1, kept)

    def _open(self):
        """Find the sector in use and read it."""
        numbers = [self._number_of(which) for which in (0, 1)]
        if max(numbers) > 0:
            self._now = numbers.index(max(numbers))
            self._number = max(numbers)
            self._read()

    def _view(self, which):
        sector = self._sectors[which]
        return self._flash.view(sector_at(sector), sector_bytes(sector))

    def _number_of(self, which):
        """Return a sector's number, 0 if it is not in use."""
        number, complement = struct.unpack("<HxxHxx", bytes(self._view(which)[:_NUMBER_BYTES]))
        return number if number ^ complement == 0xFFFF else 0

    def _read(self):
        """Note where each key's last whole record is; what a power cut left is passed over word by word."""
        view = self._view(self._now)
        self._places = {}
        self._end = at = _NUMBER_BYTES
        while at < len(view):
            length = self._record_bytes(view, at)
            if length:
                self._note(view, at)
                at += length
                self._end = at
            else:
                if bytes(view[at : at + 4]) != _BLANK:
                    self._end = at + 4
                at += 4

    def _record_bytes(self, view, at):
        """Return how long the record at ``at`` is, 0 if none is there."""
        if view[at] != _MAGIC or at + _HEAD_BYTES > len(view):
            return 0
        _, key, data = struct.unpack_from(_HEAD, view, at)
        body = _padded(_HEAD_BYTES + key + data)
        if at + body + 4 > len(view):
            return 0
        (crc,) = struct.unpack_from("<I", view, at + body)
        return body + 4 if crc == binascii.crc32(bytes(view[at : at + body])) else 0

    def _note(self, view, at):
        _, key, data = struct.unpack_from(_HEAD, view, at)
        name = bytes(view[at + _HEAD_BYTES : at + _HEAD_BYTES + key]).decode()
        self._places[name] = (sector_at(self._sectors[self._now]) + at + _HEAD_BYTES + key, data)

    def _begin(self, which, number, kept):
        """Take the other sector into use with what is kept; return 1 if it reads back."""
        self._flash.erase(self._sectors[which])
        before = (self._now, self._number, self._end, self._places)
        self._now, self._number, self._end, self._places = which, number, _NUMBER_BYTES, {}
        number &= 0xFFFF
        head = struct.pack("<HHHH", number, 0, number ^ 0xFFFF, 0xFFFF)
        written = all(self._append(which, key, data) for key, data in kept.items())
        if written and self._write(sector_at(self._sectors[which]), head):
            return 1
        self._now, self._number, self._end, self._places = before
        return 0

    def _append(self, which, key, data):
        name = key.encode()
        body = struct.pack(_HEAD, _MAGIC, len(name), len(data)) + name + data
        body += b"\xff" * (_padded(len(body)) - len(body))
        body += struct.pack("<I", binascii.crc32(body))
        start = sector_at(self._sectors[which])
        at = self._end
        if at + len(body) > sector_bytes(self._sectors[which]):
            return 0
        self._end += len(body)  # also when it fails: the place is used
        if not self._write(start + at, body):
            return 0
        self._places[key] = (start + at + _HEAD_BYTES + len(name), len(data))
        return 1

    def _write(self, at, data):
        try:
            self._flash.program(at, data)
        except OSError:
            return 0
        return 1


class Memory:
    """Settings that last as long as the program: for joints that are simulated."""

    def __init__(self):
        self._kept = {}

    def get(self, key):
        """See Journal."""
        return self._kept.get(key)

    def put(self, key, data):
        """See Journal."""
        self._kept[key] = bytes(data)
        return 1


def _padded(count):
    return (count + 3) & ~3
