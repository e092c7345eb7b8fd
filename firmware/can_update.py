"""A joint's firmware over its bus: the same update as over USB (update.py), driven by frames.

``begin`` takes a joint that is not armed out of its application: bridge off, interrupt off, watchdog at its longest.
Then come the image's header in blocks, which is checked; ``erase``; the image's blocks, straight into the slot that
does not run; ``verify``; ``switch``, which starts anew. Whatever ends early (ten seconds of silence, a cut of the
power) starts the old firmware: its slot is not touched, and the new one gets its header last.

These frames never change, whatever else of the protocol does: so a joint of any age can be updated.
"""

import gc
from array import array

from shared.joint.layout import JointState
from shared.runtime import const
from shared.wire.codec import (
    UpdateAnswer,
    UpdateMissing,
    UpdateRequest,
    decode_update_request,
    encode_update_answer,
    encode_update_missing,
)
from shared.wire.framing import BLOCK_HEADER, BLOCK_MASK, BLOCK_SLOT, update_filters
from shared.wire.names import (
    MODE_UPDATING,
    STATE_NOT_READY,
    UPDATE_ANSWER_ID,
    UPDATE_ANSWER_LENGTH,
    UPDATE_BEGIN,
    UPDATE_BLOCK_ID,
    UPDATE_CANCEL,
    UPDATE_CONFIRM,
    UPDATE_ERASE,
    UPDATE_IS_CHECKED,
    UPDATE_IS_ERASING,
    UPDATE_IS_FAILED,
    UPDATE_IS_LEAVING,
    UPDATE_IS_REFUSED,
    UPDATE_IS_RUNNING,
    UPDATE_IS_TAKING,
    UPDATE_IS_WAITING,
    UPDATE_IS_WHOLE,
    UPDATE_LOOK,
    UPDATE_MISSING,
    UPDATE_MISSING_ID,
    UPDATE_MISSING_LENGTH,
    UPDATE_REQUEST_ID,
    UPDATE_SWITCH,
    UPDATE_VERIFY,
    UPDATE_WHY_ARMED,
    UPDATE_WHY_FLASH,
    UPDATE_WHY_NO_FLASH,
    UPDATE_WHY_NO_MEMORY,
    UPDATE_WHY_NONE,
    UPDATE_WHY_OTHER_IMAGE,
    UPDATE_WHY_OTHER_UPDATE,
    UPDATE_WHY_WRONG_STATE,
)

from .flash_blocks import BLOCK_BYTES, Taking, begin_taking, next_missing, take_block
from .flash_map import CONFIRMED, HEADER, parse_header, slot_at
from .update import UpdateError

VERSION = const(1)  # of these frames
LOOK_FLAGS = const(128)  # index of look: flags and version instead of a word of the header
FLAG_CONFIRMED = const(2)
FLAG_ARMED = const(4)
HEADER_BLOCKS = const(86)  # of 6 bytes, for 512
TELL_MOST = const(8)  # frames of missing blocks after one question
_FRAMES_MOST = const(8)
_LENGTH_8 = const(8 << 11)
_SILENT_US = const(10000000)  # without a frame of the update for so long the joint starts anew (chosen)
_HEARTBEAT_US = const(200000)
_LEAVE_US = const(20000)  # so that the answer gets out before the reset (chosen)
_MASK = const(0x3FFFFFFF)


def build_number(header):
    """Return the first 24 bits of a header's build, 0 if that is not written in hexadecimal."""
    try:
        return int(header.build[:6], 16)
    except ValueError:
        return 0


class CanUpdate:
    """The update of ``joint`` (joint.py) by its bus; ``update`` is None for a board without a flash of its own."""

    def __init__(self, joint, update):
        self._joint = joint
        self._board = joint.board
        self._update = update
        self.state = UPDATE_IS_RUNNING
        self._reason = UPDATE_WHY_NONE
        self._key = 0
        self._bound = (0, 0)  # the protocol hash and the first 16 bits of the build that the host means
        self._request = UpdateRequest()
        self._answer = UpdateAnswer()
        self._missing = UpdateMissing()
        self._frame = array("H", [0] * 4)
        self._out = array("H", [0] * 4)
        self._taking = Taking()
        self._heard_us = self._beat_us = self._leave_us = 0
        self._tell_from = -1  # the next missing block to be told of, -1 none
        self._told = 0
        self._erase = []  # sectors still to be erased

    def take(self, frame):
        """Do what an update_request says and answer it."""
        r = self._request
        if decode_update_request(frame, r):
            return
        if r.command == UPDATE_LOOK:
            if r.key == self._key:
                self._heard_us = self._board.ticks_us()
            self._look(r.index)
        elif r.command == UPDATE_CONFIRM or r.command == UPDATE_BEGIN:
            self._tell(r.command, self._confirm() if r.command == UPDATE_CONFIRM else self._begin(), r.key)
        elif self.state == UPDATE_IS_RUNNING:
            self._tell(r.command, UPDATE_WHY_WRONG_STATE, r.key)
        elif r.key != self._key:
            self._tell(r.command, UPDATE_WHY_OTHER_UPDATE, r.key)
        else:
            self._go_on(r)

    def _go_on(self, r: UpdateRequest):
        """Do a request that belongs to the update that is under way; a repeated one is only answered."""
        self._heard_us = self._board.ticks_us()
        if r.command == UPDATE_ERASE and self.state == UPDATE_IS_CHECKED:
            self.state = UPDATE_IS_ERASING
            self._told = 0
        elif r.command == UPDATE_MISSING and self.state == UPDATE_IS_TAKING:
            self._tell_from = next_missing(self._taking, self._bitmap, r.low | r.high << 16)
            self._told = 0
            return
        elif r.command == UPDATE_VERIFY and self.state == UPDATE_IS_TAKING and self._taking.left == 0:
            self._do(self._verify)
        elif r.command == UPDATE_SWITCH and self.state == UPDATE_IS_WHOLE:
            self._do(self._switch)
        elif r.command == UPDATE_CANCEL:
            self._leave()
        self._tell(r.command, self._reason, r.key)

    def _begin(self):
        """Leave the application, unless something speaks against it; return why not."""
        r = self._request
        if self.state != UPDATE_IS_RUNNING:
            return self._reason if r.key == self._key else UPDATE_WHY_OTHER_UPDATE
        if self._update is None:
            return UPDATE_WHY_NO_FLASH
        if self._joint.control.armed():
            return UPDATE_WHY_ARMED
        self._key = r.key
        self._bound = (r.low, r.high)
        self._enter()
        return UPDATE_WHY_NONE

    def _enter(self):
        self._board.quiet()
        state: JointState = self._joint.control.state
        state.drive_state = STATE_NOT_READY
        state.mode = MODE_UPDATING
        self._header = bytearray(HEADER_BLOCKS * BLOCK_BYTES)
        self._bitmap = bytearray((HEADER_BLOCKS + 7) // 8)
        self._left = HEADER_BLOCKS
        begin_taking(self._taking, 0, HEADER_BLOCKS * BLOCK_BYTES)
        pairs = array("H", [0] * 4)
        self._board.can_filters(pairs, update_filters(pairs, self._joint.parameters.node, self._update.other))
        self.state = UPDATE_IS_WAITING
        self._heard_us = self._beat_us = self._board.ticks_us()

    def _confirm(self):
        """Let the running firmware stay, if it is the one that the host means; return why not."""
        r = self._request
        if self.state != UPDATE_IS_RUNNING:
            return UPDATE_WHY_WRONG_STATE
        if self._update is None:
            return UPDATE_WHY_NO_FLASH
        if self._joint.control.armed():
            return UPDATE_WHY_ARMED
        if r.low | r.high << 16 != self._joint.build:
            return UPDATE_WHY_OTHER_IMAGE
        try:
            self._update.confirm()
        except UpdateError:
            return UPDATE_WHY_FLASH
        return UPDATE_WHY_NONE

    def poll(self):
        """The main loop's body while an update is under way."""
        self._board.feed_watchdog()
        for _ in range(_FRAMES_MOST):
            came = self._board.can_receive(self._frame)
            if came < 0:
                break
            self._take_frame(came)
        if self.state == UPDATE_IS_ERASING:
            self._erase_next()
        if self._tell_from >= 0:
            self._tell_missing()
        self._look_at_clock()

    def _take_frame(self, came):
        identifier = came & 0x7FF
        other = self._update.other
        if (identifier ^ (UPDATE_BLOCK_ID + BLOCK_SLOT * other)) & BLOCK_MASK:
            if identifier == UPDATE_REQUEST_ID + self._joint.parameters.node:
                self.take(self._frame)
        elif came & ~0x7FF == _LENGTH_8:
            if identifier & BLOCK_HEADER:
                if self.state == UPDATE_IS_WAITING:
                    self._take_header()
            elif self.state == UPDATE_IS_TAKING:
                self._heard_us = self._board.ticks_us()
                flash = self._update.flash
                take_block(flash.chip, flash.memory, self._taking, self._bitmap, self._frame, identifier)

    def _take_header(self):
        """Keep a block of the header; check the header when the last one has come."""
        frame = self._frame
        number = frame[0]
        if number >= HEADER_BLOCKS or self._bitmap[number >> 3] >> (number & 7) & 1:
            return
        self._heard_us = self._board.ticks_us()
        at = number * BLOCK_BYTES
        for i in range(3):
            self._header[at + 2 * i] = frame[1 + i] & 0xFF
            self._header[at + 2 * i + 1] = frame[1 + i] >> 8
        self._bitmap[number >> 3] |= 1 << (number & 7)
        self._taking.left -= 1
        if self._taking.left == 0:
            self._do(self._check)

    def _do(self, step):
        """Do a step of the update; what goes wrong is kept as the reason."""
        try:
            step()
        except UpdateError as error:
            self._fail(UPDATE_IS_REFUSED if self.state == UPDATE_IS_WAITING else UPDATE_IS_FAILED, error.reason)
        except MemoryError:
            self._fail(UPDATE_IS_FAILED, UPDATE_WHY_NO_MEMORY)
        except OSError:
            self._fail(UPDATE_IS_FAILED, UPDATE_WHY_FLASH)

    def _fail(self, state, reason):
        self.state = state
        self._reason = reason

    def _check(self):
        """Look whether the header is that of the image the host means and fits this board; nothing is written yet."""
        update = self._update
        data = bytes(self._header[:HEADER])
        sectors = update.begin(data, self._joint.control.armed())
        header = parse_header(data)
        if header.protocol == 0 or (header.protocol, build_number(header) >> 8) != self._bound:
            raise UpdateError("another image than the host told of", UPDATE_WHY_OTHER_IMAGE)
        self._header = data
        held = bytes(update.flash.view(slot_at(update.other), HEADER)) == data
        if held and update.is_whole(update.other, self._board.feed_watchdog):
            self._taking.left = 0
            self.state = UPDATE_IS_WHOLE
            return
        gc.collect()
        blocks = begin_taking(self._taking, update.place(), header.length)
        self._bitmap = bytearray((blocks + 7) // 8)
        self._erase = sectors
        self.state = UPDATE_IS_CHECKED

    def _erase_next(self):
        """Say which sector is to be erased, erase it in the next turn, and say when all are."""
        if self._told == 0:
            self._told = 1
            a = self._answer
            a.low = self._erase[0]
            a.high = len(self._erase)
            self._send(UPDATE_ERASE, UPDATE_WHY_NONE, self._key)
            return
        self._told = 0
        self._do(self._erase_one)
        self._heard_us = self._board.ticks_us()
        if self.state != UPDATE_IS_ERASING:
            self._tell(UPDATE_ERASE, self._reason, self._key)

    def _erase_one(self):
        self._update.erase(self._erase[0])
        self._erase = self._erase[1:]
        if not self._erase:
            self.state = UPDATE_IS_TAKING

    def _tell_missing(self):
        """Send the next frame of missing blocks; behind the last one the answer."""
        m = self._missing
        taking = self._taking
        bitmap = self._bitmap
        at = self._tell_from
        if at >= taking.blocks or self._told >= TELL_MOST:
            if self._tell(UPDATE_MISSING, self._reason, self._key):
                self._tell_from = -1
                self._told = 0
            return
        m.first = at
        at = next_missing(taking, bitmap, at + 1)
        m.second = at if at < taking.blocks else m.first
        at = next_missing(taking, bitmap, at + 1)
        m.third = at if at < taking.blocks else m.second
        encode_update_missing(self._out, m)
        if self._board.can_send(UPDATE_MISSING_ID + self._joint.parameters.node, self._out, UPDATE_MISSING_LENGTH):
            self._told += 1
            self._tell_from = next_missing(taking, bitmap, at + 1)

    def _verify(self):
        """Compare what the flash holds with the header, and write that: the slot is sound from then on."""
        if self._taking.wrong:
            raise UpdateError("the flash reported an error", UPDATE_WHY_FLASH)
        self._update.finish(self._board.feed_watchdog)
        self.state = UPDATE_IS_WHOLE

    def _switch(self):
        self._update.activate()
        self._leave()

    def _leave(self):
        self.state = UPDATE_IS_LEAVING
        self._leave_us = self._board.ticks_us()

    def _look_at_clock(self):
        now = self._board.ticks_us()
        if (now - self._beat_us) & _MASK >= _HEARTBEAT_US:
            self._beat_us = now
            self._joint.send_heartbeat()
        leaves = self.state == UPDATE_IS_LEAVING and (now - self._leave_us) & _MASK >= _LEAVE_US
        if leaves or (now - self._heard_us) & _MASK >= _SILENT_US:
            self._board.reset(False)

    def _look(self, index):
        """Answer with a word of the running image's header, or with the flags."""
        a = self._answer
        a.index = index & 0xFF
        update = self._update
        if update is None:
            self._send(UPDATE_LOOK, UPDATE_WHY_NO_FLASH, self._request.key)
            return
        if index == LOOK_FLAGS:
            confirmed = update.wished() in (None, (update.running, CONFIRMED))
            a.low = update.running | (FLAG_CONFIRMED if confirmed else 0)
            if self._joint.control.armed():
                a.low |= FLAG_ARMED
            a.high = VERSION
        else:
            word = update.flash.view(slot_at(update.running) + 4 * (index & 0x7F), 4)
            a.low = word[0] | word[1] << 8
            a.high = word[2] | word[3] << 8
        self._send(UPDATE_LOOK, self._reason, self._request.key)

    def _tell(self, command, reason, key):
        """Answer a request with how many blocks are missing, and why it was refused; return 0 without a mailbox."""
        a = self._answer
        a.index = 0
        a.low = self._taking.left & 0xFFFF
        a.high = self._taking.left >> 16
        return self._send(command, reason, key)

    def _send(self, command, reason, key):
        a = self._answer
        a.command = command
        a.key = key
        a.state = self.state
        a.reason = reason
        encode_update_answer(self._out, a)
        return self._joint.send(UPDATE_ANSWER_ID + self._joint.parameters.node, self._out, UPDATE_ANSWER_LENGTH)
