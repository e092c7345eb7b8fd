"""A joint's update over its bus on the model of its chip: controller, filters, queue, watchdog, flash, interrupt."""

import struct

import pytest

from firmware import board_stm32f405
from firmware.flash_map import HEADER, slot_at
from firmware.update import Update
from host.sim.chip.joint_board import CYCLES_PER_MS, JointBoard, Restart
from shared.wire import names as w
from tests.host.boards.flash.can_joints import BOARD, ModelFlash, image_of

from .on_chip import NODE, OnChip

OLD, NEW = image_of(1, "old"), image_of(1, "new")
KEY = 9
FRAME_US = 170  # between two blocks at two thirds of the bus
BOUND = (NEW.about.protocol, int(NEW.about.build[:4], 16))


class Updated(OnChip):
    """A joint with the old firmware in slot A, and its host."""

    def __init__(self):
        board = JointBoard()
        contents = board.model.flash.contents
        contents[slot_at(0) : slot_at(0) + len(OLD.slots[0])] = OLD.slots[0]
        super().__init__(board, Update(ModelFlash(board.model), 0, BOARD))
        self.begin()

    def ask(self, command, low=0, high=0, ms=2):
        """Send a request; return state and reason of the last answer."""
        self.heard.clear()
        self.send(w.UPDATE_REQUEST_ID + NODE, struct.pack("<BBHHH", command, KEY, 0, low, high))
        self.run(ms)
        answers = self.from_joint(w.UPDATE_ANSWER_ID + NODE)
        return answers and (answers[-1].data[2] & 15, answers[-1].data[2] >> 4)

    def blocks(self, part, data):
        """Send blocks at the pace of the host, and let the joint take them."""
        for number in range(-(-len(data) // 6)):
            payload = struct.pack("<H6s", number, data[6 * number : 6 * number + 6].ljust(6, b"\xff"))
            when = self.model.now + number * FRAME_US * CYCLES_PER_MS // 1000
            self.model.at(when, lambda payload=payload: self.send(w.UPDATE_BLOCK_ID + part, payload))
        self.run(number * FRAME_US // 1000 + 5)

    def take(self):
        """Go as far as all blocks."""
        assert self.ask(w.UPDATE_BEGIN, *BOUND) == (w.UPDATE_IS_WAITING, 0)
        self.blocks(6, NEW.slots[1][:HEADER])
        assert self.joint.updating.state == w.UPDATE_IS_CHECKED
        assert self.ask(w.UPDATE_ERASE)
        self.run(1)
        assert self.joint.updating.state == w.UPDATE_IS_TAKING
        self.blocks(2, NEW.slots[1][HEADER:])


def test_an_image_comes_through_controller_queue_and_flash_without_a_block_lost():
    chip = Updated()
    chip.take()
    assert chip.ask(w.UPDATE_MISSING) == (w.UPDATE_IS_TAKING, 0)
    assert chip.joint.updating._taking.left == 0
    assert chip.ask(w.UPDATE_VERIFY) == (w.UPDATE_IS_WHOLE, 0)
    contents = chip.model.flash.contents
    assert contents[slot_at(1) : slot_at(1) + len(NEW.slots[1])] == NEW.slots[1]
    assert contents[slot_at(0) : slot_at(0) + len(OLD.slots[0])] == OLD.slots[0]
    assert not chip.model.resets
    assert not chip.board.outputs_on
    assert not chip.model.complaints
    with pytest.raises(Restart):
        chip.ask(w.UPDATE_SWITCH, ms=40)


def test_the_application_stands_still_while_it_is_updated():
    chip = Updated()
    assert chip.ask(w.UPDATE_BEGIN, *BOUND) == (w.UPDATE_IS_WAITING, 0)
    steps = chip.control.run.steps
    chip.heard.clear()
    chip.run(250)
    assert chip.control.run.steps == steps
    beats = chip.from_joint(w.HEARTBEAT_ID + NODE)
    assert beats
    assert beats[-1].data[0] == w.STATE_NOT_READY | w.MODE_UPDATING << 4


def test_an_erase_needs_the_slow_watchdog(monkeypatch):
    monkeypatch.setattr(board_stm32f405, "slow_watchdog", lambda chip: None)
    chip = Updated()
    with pytest.raises(Restart):
        chip.take()
    assert chip.model.resets[-1][1] == "iwdg"


def test_silence_starts_the_joint_anew(monkeypatch):
    monkeypatch.setattr("firmware.can_update._SILENT_US", 50_000)
    chip = Updated()
    chip.ask(w.UPDATE_BEGIN, *BOUND)
    with pytest.raises(Restart):
        chip.run(60)
    assert chip.model.resets[-1][1] == "software"
