"""A simulated flash: bits are only written from one to zero, erased a sector at a time, and power can go in between.

Runs on CPython and MicroPython: the host's tests and the pretend board's firmware use the same one. ``cut`` counts down
words written and sectors erased; the last one is torn: some of its bits are written, or erased, and the rest are not.
"""

from firmware.flash_map import SIZE, sector_at, sector_bytes


class PowerCut(Exception):
    """The power has gone."""


class SimFlash:
    """``store`` keeps the bytes: anything with read(at, count) and write(at, data)."""

    def __init__(self, store, cut=0, seed=1):
        self.store = store
        self.cut = cut
        self.done = 0  # words written and sectors erased
        self._seed = seed

    def view(self, at, count):
        """Return bytes as they are."""
        return self.store.read(at, count)

    def program(self, at, data):
        """Write words; OSError if they don't read back."""
        if at % 4 or len(data) % 4:
            raise OSError("only whole words can be written")
        if 0 < self.cut - self.done <= len(data) // 4:
            whole = (self.cut - self.done - 1) * 4
            self._write(at, data[:whole])
            self._write(at + whole, self._torn(data[whole : whole + 4]))
            self._gone()
        self._write(at, data)
        self.done += len(data) // 4
        if bytes(self.view(at, len(data))) != bytes(data):
            raise OSError("reads back something else")

    def erase(self, sector):
        """Set a sector to ones."""
        at, count = sector_at(sector), sector_bytes(sector)
        self.done += 1
        if self.done == self.cut:
            self._half_erase(at, count)
            self._gone()
        self.store.write(at, b"\xff" * count)

    def _write(self, at, data):
        old = self.view(at, len(data))
        self.store.write(at, bytes([old[i] & data[i] for i in range(len(data))]))

    def _torn(self, data):
        """Return a word of which some zeros are not written."""
        return bytes([byte | self._random() for byte in data])

    def _half_erase(self, at, count):
        """Leave parts as they were, erase parts, and set some more bits of others."""
        for part in range(at, at + count, 256):
            old = self.view(part, 256)
            kind = self._random() % 3
            if kind == 1:
                self.store.write(part, b"\xff" * 256)
            elif kind == 2:
                self.store.write(part, bytes([byte | self._random() for byte in old]))

    def _random(self):
        self._seed = (self._seed * 75 + 74) % 65537
        return self._seed & 0xFF

    def _gone(self):
        raise PowerCut


class Memory:
    """A store in this process."""

    def __init__(self, data=None):
        self.data = bytearray(b"\xff" * SIZE) if data is None else bytearray(data)

    def read(self, at, count):
        """Return bytes."""
        return bytes(self.data[at : at + count])

    def write(self, at, data):
        """Take bytes as they are."""
        self.data[at : at + len(data)] = data
