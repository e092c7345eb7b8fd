"""Writes the slot that does not run, checks it, and says which slot is to start.

``caramelo flash`` drives it by scripts over USB, a joint by the frames of its bus (can_update.py).

At any moment the loader finds a sound slot: the running one is never written, the other one gets its header last, and
a boot record counts only as a whole (flash_map.py).
"""

import hashlib

from shared.wire.names import (
    UPDATE_WHY_ARMED,
    UPDATE_WHY_DIFFERENT,
    UPDATE_WHY_FLASH,
    UPDATE_WHY_NOT_A_HEADER,
    UPDATE_WHY_OTHER_BOARD,
    UPDATE_WHY_RUNNING_SLOT,
)

from .flash_map import (
    CONFIRMED,
    HEADER,
    RECORDS_SECTOR,
    SLOT_SECTORS,
    SLOTS,
    TRIAL_STARTS,
    pack_record,
    parse_header,
    read_records,
    sector_at,
    sector_bytes,
    slot_at,
)

_ROOM = 128  # bytes of boot records that an update finds free: one trial takes 40
_HASH_BYTES = 4096


class UpdateError(Exception):
    """The update can't be done; the text says why, and ``reason`` in a number for a bus."""

    def __init__(self, text, reason=UPDATE_WHY_FLASH):
        super().__init__(text)
        self.reason = reason


class Update:
    """Both slots of ``flash`` seen from the one that runs, ``running``, on a board of the type ``board``."""

    def __init__(self, flash, running, board):
        self.flash = flash
        self.running = running
        self.other = 1 - running
        self._board = board
        self._header = b""  # of the image being written; it goes last

    def wished(self):
        """Return (slot, starts left) of the last boot record, or None."""
        return read_records(self._records())[0]

    def header(self, slot):
        """Return a slot's Header, or None if none is whole there."""
        return parse_header(self.flash.view(slot_at(slot), HEADER))

    def is_whole(self, slot, feed):
        """Return True if the image in a slot is what its header says."""
        header = self.header(slot)
        return header is not None and self._digest(slot, header.length, feed) == header.sha256

    def begin(self, data, armed):
        """Check the header of a new image and that nothing is armed; return the sectors to erase, in this order.

        Confirms the running slot if it is on trial: it is the one that remains.
        """
        header = parse_header(data)
        if header is None:
            raise UpdateError("this is not the header of an image", UPDATE_WHY_NOT_A_HEADER)
        if armed:
            raise UpdateError("the joint is armed: disarm it, then flash again", UPDATE_WHY_ARMED)
        if header.board != self._board:
            text = f"an image for {header.board}; this board is a {self._board}"
            raise UpdateError(text, UPDATE_WHY_OTHER_BOARD)
        if header.slot != self.other:
            text = f"an image for slot {SLOTS[header.slot]}, from which this board runs now"
            raise UpdateError(text, UPDATE_WHY_RUNNING_SLOT)
        self._header = bytes(data)
        need = HEADER + header.length
        first = SLOT_SECTORS[self.other][0]
        return [sector for sector in SLOT_SECTORS[self.other] if sector_at(sector) - sector_at(first) < need]

    def erase(self, sector):
        """Erase one of the sectors of ``begin``. The first one takes the slot's header; then records get room."""
        if sector not in SLOT_SECTORS[self.other] or not self._header:
            raise UpdateError(f"sector {sector} is not to be erased")
        self.flash.erase(sector)
        if sector == SLOT_SECTORS[self.other][0]:
            self._make_room()

    def write(self, at, data):
        """Write a part of the image, whole words; ``at`` counts from the image's beginning."""
        length = parse_header(self._header).length
        if at < 0 or at + len(data) > length:
            raise UpdateError(f"{at}: outside of the image, which has {length} bytes")
        self.flash.program(self.place() + at, data)

    def place(self):
        """Return where the new image begins behind its header, bytes from the flash's beginning."""
        return slot_at(self.other) + HEADER

    def finish(self, feed):
        """Compare the whole image and write its header: the slot is sound from then on."""
        header = parse_header(self._header)
        if self._digest(self.other, header.length, feed) != header.sha256:
            raise UpdateError("the image reads back as something else: is the flash worn out?", UPDATE_WHY_DIFFERENT)
        self.flash.program(slot_at(self.other), self._header)
        self._header = b""

    def activate(self):
        """Let the other slot start from now on, on trial."""
        if self.header(self.other) is None:
            raise UpdateError(f"slot {SLOTS[self.other]} holds no whole image")
        self._record(self.other, TRIAL_STARTS)

    def go_back(self):
        """Let the other slot start from now on, for good: the running one is to be replaced."""
        if self.header(self.other) is None:
            raise UpdateError(f"slot {SLOTS[self.other]} holds no whole image")
        self._record(self.other, CONFIRMED)

    def confirm(self):
        """Let the running slot start from now on, for good."""
        if self.wished() != (self.running, CONFIRMED):
            self._record(self.running, CONFIRMED)

    def _records(self):
        return self.flash.view(sector_at(RECORDS_SECTOR), sector_bytes(RECORDS_SECTOR))

    def _make_room(self):
        """Begin the boot records anew when they are full. The other slot is not sound now: this one starts."""
        if read_records(self._records())[1] > sector_bytes(RECORDS_SECTOR) - _ROOM:
            self.flash.erase(RECORDS_SECTOR)
        self.confirm()

    def _record(self, slot, starts):
        """Append a boot record; where a power cut has left a place that does not take it, the next place."""
        at = read_records(self._records())[1]
        while at < sector_bytes(RECORDS_SECTOR):
            try:
                self.flash.program(sector_at(RECORDS_SECTOR) + at, pack_record(slot, starts))
                return
            except OSError:
                at += 8
        raise UpdateError("no room for a boot record: update this board")

    def _digest(self, slot, length, feed):
        """Return the sha256 of so much of a slot's image; ``feed`` is called all the while."""
        whole = hashlib.sha256()
        start = slot_at(slot) + HEADER
        for at in range(0, length, _HASH_BYTES):
            feed()
            whole.update(self.flash.view(start + at, min(_HASH_BYTES, length - at)))
        return whole.digest()
