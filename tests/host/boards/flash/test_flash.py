"""Flashing a pretend board: what is written, what is refused before, what happens when the new firmware fails."""

import hashlib

import pytest

from firmware.flash_map import CONFIRMED, HEADER, slot_at
from host.boards.flash.board import Board
from host.boards.flash.flash import Wish, flash
from host.boards.flash.inspect import describe
from host.boards.flash.link import BoardError, BoardLink
from host.util.errors import UserError

from .pretend import PretendBoard
from .trees import frame, make


def put(board, image, **wish):
    """Flash it, and wait until it runs again: flashing ends with a reset, also where it is refused."""
    try:
        return flash(board.port, Wish(image, **wish))
    finally:
        board.wait_for_own_start()


def contents(board):
    return hashlib.sha256(board.flash.read_bytes()).hexdigest()


def survey(board):
    with BoardLink(board.port) as link:
        return Board(link).survey()


@pytest.fixture
def board(tmp_path):
    with PretendBoard(tmp_path / "board", make()) as board:
        assert board.wait_for(b"running 1")
        yield board


def test_a_board_written_by_dfu_runs_slot_a_and_takes_its_first_update(board):
    first = survey(board)
    assert (first.report.slot, first.report.build, first.wished) == (0, make().about.build, None)
    assert first.slots[1] is None
    outcome = put(board, make("2"))
    assert (outcome.slot, outcome.version, outcome.self_test, outcome.changed) == ("b", "2", "passed", True)
    assert board.wait_for(b"running 2")
    after = survey(board)
    assert (after.report.slot, after.wished, after.report.stage) == (1, (1, CONFIRMED), "stopped")
    assert put(board, make("3")).slot == "a"


def test_nothing_is_written_when_nothing_changed(board):
    put(board, make("2"))
    before = contents(board)
    outcome = put(board, make("2"))
    assert (outcome.changed, outcome.bytes, outcome.slot) == (False, 0, "b")
    outcome = put(board, make("3"), dry_run=True)
    assert (outcome.changed, outcome.dry_run, outcome.slot, outcome.bytes) == (True, True, "a", len(make("3").slots[0]))
    assert contents(board) == before


def test_a_slot_that_holds_the_image_already_is_only_switched_to(board):
    put(board, make("2"))
    outcome = put(board, make("1"))
    assert (outcome.slot, outcome.version, outcome.bytes, outcome.changed) == ("a", "1", 0, True)


def test_a_damaged_slot_is_written_anew_though_its_header_says_it_is_the_one(board):
    put(board, make("2"))
    data = bytearray(board.flash.read_bytes())
    data[slot_at(0) + HEADER + 20] = 0
    board.flash.write_bytes(data)
    assert put(board, make("1")).bytes == len(make("1").slots[0])


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({"body": "raise ValueError('broken build')"}, "ValueError: broken build"),
        ({"body": "import nothing_like_it"}, "ImportError"),
        ({"self_test": "return 'sin is 3'"}, "self-test: sin is 3"),
    ],
)
def test_a_broken_build_falls_back(board, broken, words):
    with pytest.raises(BoardError, match="the new firmware did not start") as error:
        put(board, make("2", **broken))
    assert words in str(error.value)
    assert "the board is on slot a" in str(error.value)
    assert board.wait_for(b"running 1")
    after = survey(board)
    assert (after.report.slot, after.settled) == (0, True)
    assert put(board, make("3")).slot == "b"


# It fails before the host listens again, which waits in vain; the next times it is heard.
BROKEN = """import os, time
if "failed" in os.listdir():
    time.sleep_ms(300)
open("failed", "w").close()
raise ValueError("broken start-up")
"""


def test_a_build_that_cannot_even_be_asked_falls_back(board):
    broken = {**frame(), "firmware/startup.py": BROKEN}
    with pytest.raises(BoardError, match=r"the new firmware did not start.*; the board is on slot a"):
        put(board, make("2", modules=broken))
    assert board.wait_for(b"running 1")
    assert put(board, make("3")).slot == "b"


def test_a_board_nobody_confirms_goes_back_by_itself(board):
    put(board, make("2"))
    with BoardLink(board.port) as link:
        Board(link).link.run("u._record(1, 3)")
        for _ in range(3):
            board.after_reset(link.reset, b"running 2")
            link.interrupt()
        assert not Board(link).report().confirmed
        board.after_reset(link.reset, b"running 1")
        link.interrupt()
        assert Board(link).report().confirmed
        assert Board(link).log() == "slot b was not confirmed in its starts: back to slot a\n"


def test_a_computer_that_went_before_it_confirmed_tries_again(board):
    put(board, make("2"))
    with BoardLink(board.port) as link:
        Board(link).link.run("u._record(1, 3)")
        board.after_reset(link.reset, b"running 2")
    outcome = put(board, make("2"))
    assert (outcome.slot, outcome.version, outcome.bytes) == ("b", "2", 0)
    with BoardLink(board.port) as link:
        Board(link).link.run("u._record(1, 3)")
        board.after_reset(link.reset, b"running 2")
    outcome = put(board, make("3"))  # the slot on trial is replaced, not the one that worked
    assert (outcome.slot, outcome.version) == ("b", "3")


@pytest.mark.parametrize(
    ("state", "words"),
    [
        ({"supply": 24000}, r"the motor supply is on, 24\.0 V: switch it off"),
        ({"armed": True}, "the joint is armed: disarm it, then flash again"),
    ],
)
def test_a_board_that_may_move_something_is_not_updated(tmp_path, state, words):
    with PretendBoard(tmp_path / "board", make(**state)) as board:
        assert board.wait_for(b"running 1")
        before = contents(board)
        with pytest.raises(UserError, match=words):
            put(board, make("2"))
        assert contents(board) == before
        assert board.wait_for(b"running 1")


def test_an_image_for_another_board_or_of_another_protocol_is_refused(board):
    before = contents(board)
    with pytest.raises(UserError, match="is a CARAMELO_GAIT, but the image is for a CARAMELO_JOINT, role joint"):
        put(board, make("2", role="joint", board="CARAMELO_JOINT"))
    with pytest.raises(UserError, match=r"speaks protocol 0x1, this computer 0x[0-9a-f]+: build the image again"):
        put(board, make("2", protocol=1))
    with pytest.raises(UserError, match="--id 3: only for joints"):
        put(board, make("2"), node=3)
    assert contents(board) == before


def test_a_firmware_that_cannot_be_imported_can_be_replaced(tmp_path):
    with PretendBoard(tmp_path / "board", make(text="import nothing_like_it\n")) as board:
        assert board.wait_for(b"ImportError")
        assert survey(board).supply_mV is None
        assert put(board, make("2")).version == "2"


WATCHED = """import machine
    dog = machine.WDT(timeout=20000)
    while True:
        time.sleep_ms(5)
        dog.feed()"""


def test_a_watchdog_is_held_off(tmp_path):
    with PretendBoard(tmp_path / "board", make(body=WATCHED, watchdog=True)) as board:
        board.settle(b"running 1")
        resets = board.resets
        with BoardLink(board.port) as link:
            Board(link)
            assert (board.folder / "watchdog").read_text() == "32000"
            assert board.resets == resets
            # The check can fail: a watchdog not held off resets the board.
            board.after_reset(lambda: link.run("start.watchdog.__init__(300)"), b"running 1")


def test_flash_that_reads_back_differently_is_told_and_the_old_firmware_stays(board, monkeypatch):
    run = BoardLink.run

    def spoil(self, script, timeout_s=20.0):
        if script == "u.finish(start.feed)":
            run(self, "flash = u.flash\nflash.store.write(0x80000 + 600, bytes(8))")
        return run(self, script, timeout_s)

    monkeypatch.setattr(BoardLink, "run", spoil)
    with pytest.raises(BoardError, match="the image reads back as something else"):
        put(board, make("2"))
    assert board.wait_for(b"running 1")
    assert survey(board).slots[1] is None


@pytest.mark.parametrize("stage", ["u.wished()", "u.erase", "u.write", "u.finish", "u.activate", "u.confirm"])
def test_ctrl_c_at_any_stage_leaves_the_board_running(board, monkeypatch, stage):
    run = BoardLink.run

    def stop(self, script, timeout_s=20.0):
        if stage in script:
            self._link.exec_raw_no_follow(script)  # Ctrl-C comes while the board works
            raise KeyboardInterrupt
        return run(self, script, timeout_s)

    monkeypatch.setattr(BoardLink, "run", stop)
    with pytest.raises(KeyboardInterrupt):
        flash(board.port, Wish(make("2")))
    board.wait_for_own_start()


def test_ctrl_c_while_the_prompt_is_asked_for_leaves_the_board_running(board, monkeypatch):
    interrupt, asked = BoardLink.interrupt, []

    def stop(self):
        interrupt(self)
        asked.append(self)
        if len(asked) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(BoardLink, "interrupt", stop)
    with pytest.raises(KeyboardInterrupt):
        describe(board.port)
    board.wait_for_own_start()


def test_an_id_is_handed_to_the_joint(tmp_path):
    joint = {"role": "joint", "board": "CARAMELO_JOINT"}
    with PretendBoard(tmp_path / "board", make(**joint)) as board:
        assert board.wait_for(b"running 1")
        taking = make("2", body="print('id', journal.get('node')); journal.put('node', b'')", **joint)
        assert put(board, taking, node=7).changed
        assert put(board, taking).changed is False
        with pytest.raises(BoardError, match="did not take over id 7"):
            put(board, make("3", **joint), node=7)


def test_the_log_loses_its_oldest_lines_and_no_more(board):
    with BoardLink(board.port) as link:
        found = Board(link)
        link.run("for i in range(200):\n    start.note('line %d' % i)\n    start.journal.tidy()")
        lines = found.log().splitlines()
    assert lines[-1] == "line 199"
    assert 50 < len(lines) < 200
