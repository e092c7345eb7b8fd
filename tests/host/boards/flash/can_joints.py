"""Joints that are updated over their bus: the real application and update, on the chip's flash as its model has it.

Each start is decided by the loader's own C (loader.py). A joint has the receive queue of its chip, three frames deep,
and is deaf while its processor stands still: for an erase and a half word as long as the model of the flash takes.
"""

import threading

from firmware.board_sim import SimBoard
from firmware.chip_flash import ChipFlash
from firmware.flash_map import BASE, CONFIRMED, slot_at
from firmware.joint import Joint
from firmware.settings import Journal
from firmware.update import Update
from host.boards.build.image_file import make_image
from host.sim.chip.chip import Chip
from host.sim.chip.view import View
from host.sim.joints.bus import SimBus
from shared.wire.names import PROTOCOL_HASH

from .loader import choose

BOARD = "CARAMELO_JOINT"
PERIPHERALS = 0x40000000
CYCLES_PER_US = 168
BOOT_US = 1_200_000  # loader, MicroPython, half a second for Ctrl-C, self-test (assumed)
TURN_US = 40  # of the main loop with a frame, without the flash (assumed)
STALL_US = 200  # shorter than this a standstill delays no frame
FIFO = 3  # frames (RM0090 section 32.7.3)
MAILBOXES = 3
TURNS_MOST = 12  # of the main loop in a millisecond without frames, as far as something goes on


class PowerOff(BaseException):
    """The power has gone. Not an Exception, for no program can catch that."""


def image_of(kibibytes=3, text="new", protocol=PROTOCOL_HASH, board=BOARD, version="0.2.0"):
    """Return an image whose two halves differ, as linked ones do; its length is no multiple of a block's."""
    halves = []
    for slot in "ab":
        seed = sum(text.encode()) + ord(slot)
        halves.append(bytes((seed * i + i * i // 7) & 0xFF for i in range(1024 * kibibytes + 4)))
    return make_image("joint", board, version, protocol, "1.29.0", halves, b"\xff" * 256)


class Stalled(View):
    """Registers and memory to a program that runs from the same flash: it stands still while that is busy (3.6)."""

    def __getitem__(self, index):
        self.chip.flash._wait()
        return self.chip.read(self.base + index * self.size, self.size)

    def __setitem__(self, index, value):
        self.chip.write(self.base + index * self.size, value & ((1 << 8 * self.size) - 1), self.size)


class Handle:
    """What stands for an address in the driver."""

    def __init__(self, chip, base):
        self.words, self.halves = Stalled(chip, base, 4, 0), Stalled(chip, base, 2, 0)


class ModelFlash(ChipFlash):
    """The firmware's driver on the model."""

    def __init__(self, chip):
        super().__init__(Handle(chip, PERIPHERALS), Handle(chip, BASE))
        self.model = chip.flash

    def view(self, at, count):
        self.model._wait()
        return bytes(self.model.contents[at : at + count])


class LoaderFlash:
    """The same flash to the loader's C, which writes words by itself."""

    def __init__(self, contents):
        self.store = self
        self.data = contents

    def program(self, at, word):
        for i, byte in enumerate(word):
            self.data[at + i] &= byte


class Board(SimBoard):
    """The simulated board whose frames go to a node of the bus, and whose clock goes on while the flash is busy."""

    STEP_US = 1000

    def __init__(self, joint):
        super().__init__(bytes((joint.node, *range(11))))
        self._of = joint
        self.pairs = []

    def ticks_us(self):
        return self._of.time_us() & 0x3FFFFFFF

    def can_filters(self, pairs, count):
        self.pairs = [(pairs[2 * i], pairs[2 * i + 1]) for i in range(count)]

    def can_send(self, identifier, frame, length):
        data = b"".join(int(word).to_bytes(2, "little") for word in frame)[:length]
        return int(self._of.say(identifier, data))


class CanJoint:
    """One joint, with firmware ``old`` in a slot. ``send(identifier, data)`` puts a frame on its bus.

    ``broken``: builds whose self-test fails. ``cut_at``: the power goes in the middle of that word programmed or
    sector erased, counted from now; ``cut`` tells that it has gone.
    """

    def __init__(self, node, old, slot=0, broken=()):
        self.node, self.broken = node, broken
        self.chip = Chip()
        self.chip.muted.add("FLASH")
        contents = self.chip.flash.contents
        contents[slot_at(slot) : slot_at(slot) + len(old.slots[slot])] = old.slots[slot]
        self.send = lambda identifier, data: True
        self.now_us = self.busy_us = self.off_until_us = 0
        self.said = self.starts = self.overruns = 0
        self.cut_at, self.done, self.cut = 0, 0, False
        self.chip.flash.step = self._step
        self.waiting = []
        self._late = []  # (when, identifier, data): said after the processor stood still
        self._base = self.chip.now
        self.set_node()
        self.boot()

    def set_node(self):
        """Keep the node as ``caramelo joints set-id`` does."""
        journal = Journal(ModelFlash(self.chip))
        journal.tidy()
        joint = Joint(Board(self), journal)
        joint.set_node(self.node)
        assert joint.parameters.save()

    def _step(self, what, address, value):
        """Count what is programmed and erased; the model leaves half done what is under way when the power goes."""
        self.done += 1
        if self.done == self.cut_at:
            self.chip.at(self.chip.now + 1, self._lose_power)

    def _lose_power(self):
        raise PowerOff

    def time_us(self):
        """Return the time as the joint's own clock has it."""
        return int(self.now_us + (self.chip.now - self._base) // CYCLES_PER_US)

    def say(self, identifier, data):
        """Send a frame, when the program gets there."""
        self.said += 1
        if self.time_us() - self.now_us > STALL_US:
            self._late.append((self.time_us(), identifier, data))
            return True
        return self.send(identifier, data)

    def boot(self):
        """Start: the loader's decision, what start-up does with it, the application."""
        self.starts += 1
        self.chip.flash.reset()
        self.chip.flash.value["ACR"] = 0x705
        self.slot = choose(LoaderFlash(self.chip.flash.contents))
        assert self.slot >= 0, "the loader finds no slot to start: this joint is dead"
        flash = ModelFlash(self.chip)
        self.update = Update(flash, self.slot, BOARD)
        assert self.update.is_whole(self.slot, lambda: None)
        self.build = self.update.header(self.slot).build
        self.off_until_us = self.now_us + BOOT_US
        self.waiting = []
        if self.build in self.broken and self.update.wished() not in (None, (self.slot, CONFIRMED)):
            self.joint = None  # the self-test has failed: startup.py starts anew
            return
        wished = self.update.wished()
        if wished is not None and wished[0] != self.slot:
            self.update.confirm()
        journal = Journal(flash)
        journal.tidy()
        self.board = Board(self)
        self.joint = Joint(self.board, journal, self.update)
        assert self.joint.parameters.node == self.node
        self.joint.start()

    def hears(self, identifier):
        return any(identifier & mask == wanted & mask for wanted, mask in self.board.pairs)

    def deliver(self, time_us, identifier, data):
        """Let a frame arrive."""
        if self.cut or self.joint is None or time_us < self.off_until_us or not self.hears(identifier):
            return
        while self.waiting and self.busy_us <= time_us and not self.cut:
            self._turn(self.busy_us)
        if len(self.waiting) >= FIFO:
            self.overruns += 1
            return
        self.waiting.append((identifier, data))
        self._turn(time_us)

    def tick(self, time_us):
        """Do what the main loop does in a millisecond."""
        if self.cut or time_us < self.off_until_us:
            return
        while self._late and self._late[0][0] <= time_us:
            self.send(*self._late.pop(0)[1:])
        if self.joint is None:
            self.now_us = time_us
            self.boot()
            return
        if self.board.handler:
            self.board.now_us = time_us
            self.board.handler()
        for _ in range(TURNS_MOST):
            said = self.said
            self._turn(time_us)
            if (self.said == said and not self.waiting) or self.cut or time_us < self.off_until_us:
                return

    def _turn(self, time_us):
        """One turn of the main loop, if the last one is over."""
        if time_us < self.busy_us:
            return
        self.now_us, self._base = time_us, self.chip.now
        if self.waiting:
            identifier, data = self.waiting.pop(0)
            words = [int.from_bytes(data[i : i + 2].ljust(2, b"\0"), "little") for i in range(0, 8, 2)]
            self.board.deliver(identifier, words, len(data))
        try:
            self.joint.poll()
        except PowerOff:
            self.cut = True
            return
        self.busy_us = time_us + (self.chip.now - self._base) / CYCLES_PER_US + (TURN_US if self.waiting else 0)
        if self.board.resets:
            self.boot()

    def power_up(self):
        """Give the power back."""
        self.cut, self.cut_at = False, 0
        self.busy_us = 0
        self.boot()


class Bench:
    """Joints on a simulated bus in simulated time; SimPort(bench) is the host's end of it."""

    def __init__(self, joints, seed=0, loss=0.0):
        self.joints = joints
        self.bus = SimBus(seed=seed)
        self.lock = threading.RLock()
        self.each_ms = []
        self.marks = []  # (time in us, bits) every millisecond
        self._ms = 0
        self.nodes = []
        for joint in joints:
            node = self.bus.attach(joint.deliver, MAILBOXES)
            node.loss = loss
            joint.send = node.send
            self.nodes.append(node)

    @property
    def time_s(self):
        return self.bus.now_us * 1e-6

    def advance_us(self, to_us):
        while (self._ms + 1) * 1000 <= to_us:
            self._ms += 1
            self.bus.advance(self._ms * 1000)
            for joint in self.joints:
                joint.tick(self._ms * 1000)
            for call in self.each_ms:
                call(self._ms)
            self.marks.append(self.bus.bits)
        self.bus.advance(to_us)

    def peak_load(self, window_ms=100):
        """Return the largest share of the bus taken in any window."""
        spans = zip(self.marks, self.marks[window_ms:], strict=False)
        return max((after - before for before, after in spans), default=0) / (1000 * window_ms)

    def settle(self, seconds=1.5):
        """Let time go by."""
        self.advance_us(self.bus.now_us + seconds * 1e6)


def running(joints):
    """Return the builds that run."""
    return {joint.build for joint in joints}
