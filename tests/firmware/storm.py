"""A joint's application in a storm of frames, resets and sensor faults; the same on CPython and MicroPython.

Integers and drawn numbers only, so that every runtime meets the same storm and its digest says whether the joint did
the same. While the joint is armed the heap is locked: whatever needs memory then fails, which the joint itself latches
as the fault *exception*.
"""

from array import array

from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.settings import Memory
from shared.joint import layout as j
from shared.joint.faults import FAULT_EXCEPTION
from shared.record import pack
from shared.wire import codec
from shared.wire import names as w

MASK = 0xFFFFFF
SESSION = 17
FRAMES_PER_MS = 4
WELL_KNOWN = (0x80, 0x100, 0x102, 0x104, 0x106, w.SERVICE_REQUEST_ID, w.SERVICE_REQUEST_ID + 1)
# Requests that would end the storm's own conversation: another node number, a file written, the boot loader.
LEFT_OUT = (w.COMMAND_SET_ID, w.COMMAND_SAVE_PARAMETERS, w.COMMAND_REBOOT_TO_LOADER)
TORQUE_STATES = (w.STATE_OPERATION_ENABLED, w.STATE_QUICK_STOP_ACTIVE, w.STATE_FAULT_REACTION)


class Storm:
    """``lock`` and ``unlock`` are micropython's, or do nothing."""

    def __init__(self, stored, lock, unlock):
        self.lock, self.unlock = lock, unlock
        self.seed, self.digest, self.ms, self.sequence, self.requested = 4711, 0, 0, 0, 0
        self.enabled = self.locked = self.exceptions = self.wrong_torque = self.faults = self.resets = 0
        self.board = board = SimBoard()
        self.joint = Joint(board, Memory())
        control = self.joint.control
        self.joint.parameters.take(stored)
        control.settings.commissioned = 1
        self.frame, self.sent = array("H", [0] * 4), array("H", [0] * 4)
        self.sync = codec.Sync()
        self.sync.session = SESSION
        self.goal = array("i", [400, w.NO_CHANGE, w.NO_CHANGE, w.NO_CHANGE])
        self.ask = codec.ServiceRequest()
        self.ask.session = SESSION
        self.joint.set_node(1)
        self.joint.start()

    def draw(self, count):
        self.seed = (self.seed * 4093 + 13849) & 0x3FFFF
        return (self.seed >> 4) % count

    def run(self, frames):
        """Send ``frames`` random frames, and what a host sends that does everything right now and then."""
        for number in range(frames):
            if number % FRAMES_PER_MS == 0:
                self.watched_millisecond()
            self.disturb()
            if number % 240 == 0:
                self.behave()
        return self.digest

    def watched_millisecond(self):
        armed = self.joint.control.armed()
        if armed:
            self.locked += 1
            self.lock()
        self.millisecond()
        if armed:
            self.unlock()
        self.judge()

    def millisecond(self):
        board = self.board
        for _ in range(10):
            board.now_us = (board.now_us + 100) & 0x3FFFFFFF
            for phase in range(3):
                board.raw[phase] = 2040 + self.draw(16)
            board.handler()
        self.joint.poll()
        identifier = board.sent.take(self.sent)
        while identifier >= 0:
            self.note(identifier)
            for word in range(4):
                self.note(self.sent[word])
            identifier = board.sent.take(self.sent)
        self.ms += 1

    def note(self, value):
        self.digest = (self.digest * 31 + (value & 0xFFFFF)) & MASK

    def judge(self):
        """Look at what must never be, and put the state into the digest."""
        control = self.joint.control
        state = control.state
        for value in pack(state) if hasattr(state, "FIELDS") else state:  # an array in the VMs: nothing is taken
            self.note(value)
        for phase in range(3):
            self.note(control.loop.duty[phase])
        drive = state.drive_state
        driving = state.torque == j.TORQUE_DRIVE and drive != w.STATE_OPERATION_ENABLED
        if driving or (self.board.bridge and drive not in TORQUE_STATES):
            self.wrong_torque += 1
        self.enabled += drive == w.STATE_OPERATION_ENABLED
        self.faults += drive == w.STATE_FAULT
        self.exceptions += state.fault_code == FAULT_EXCEPTION or control.run.failed_part != 0
        if self.board.resets:
            self.power_cycle()

    def power_cycle(self):
        """What a reboot leaves: the blocks set up anew, no session, no conversation."""
        self.resets += 1
        self.board.resets = 0
        self.joint.service.reboot = 0
        self.joint.control.start()

    def disturb(self):
        """A random frame; now and then a sensor fails or a whole reset comes."""
        kind = self.draw(48)
        board = self.board
        board.rotor = -1 if kind == 0 else self.draw(16384) if kind == 1 else 1200
        board.thermistor = 4095 if kind == 2 else 2048
        board.bus = self.draw(4096) if kind == 3 else 2291
        board.joint = -1 if kind == 4 else 54
        board.driver = self.draw(2048) if kind == 5 and self.draw(8) == 0 else 0
        if self.draw(400) == 0:
            self.power_cycle()
        if kind > 6:
            self.send_random()

    def send_random(self):
        known = self.draw(9)
        identifier = WELL_KNOWN[known] if known < 7 else self.draw(0x800)
        for word in range(4):
            self.frame[word] = self.draw(65536)
        if self.frame[0] & 0xFF in LEFT_OUT:
            return
        if self.draw(200) == 0:
            identifier = w.E_STOP_ID
        self.board.deliver(identifier, self.frame, self.draw(9))

    def behave(self):
        """As a host that wants to drive: clear, home, set-points for a while, arm, set-points again."""
        self.calm(30)
        self.request(w.COMMAND_CLEAR_FAULT, 0, 0)
        self.request(w.COMMAND_HOME, 0, self.joint.service.challenge << 16)
        self.calm(40)
        self.request(w.COMMAND_ARM, 0, self.joint.service.challenge << 16 | w.PROTOCOL_HASH)
        self.calm(25)

    def calm(self, milliseconds):
        """Healthy sensors; a set-point with SYNC every 5 ms."""
        board = self.board
        board.rotor, board.thermistor, board.bus, board.joint, board.driver = 1200, 2048, 2291, 54, 0
        for _ in range(milliseconds):
            if self.ms % 5 == 0:
                codec.encode_group(self.frame, self.goal)
                board.deliver(w.SETPOINT_CURRENT_ID, self.frame, 8)
                self.sequence = (self.sequence + 1) & 0xFF
                self.sync.counter = self.sequence
                codec.encode_sync(self.frame, self.sync)
                board.deliver(w.SYNC_ID, self.frame, w.SYNC_LENGTH)
            self.watched_millisecond()

    def request(self, command, index, value):
        self.requested = (self.requested + 1) & 0xFF
        self.ask.command = command
        self.ask.sequence = self.requested
        self.ask.index = index
        self.ask.value = value
        codec.encode_service_request(self.frame, self.ask)
        self.board.deliver(w.SERVICE_REQUEST_ID + 1, self.frame, 8)

    def figures(self):
        """Return what was counted; the same list on every runtime."""
        counts = [self.digest, self.ms, self.enabled, self.locked, self.exceptions, self.wrong_torque]
        counts.extend([self.faults, self.resets])
        return counts


def run(stored, frames, lock, unlock):
    """Let the storm come over a joint with these parameters; return its figures."""
    storm = Storm(stored, lock, unlock)
    storm.run(frames)
    return storm.figures()
