"""Flashing a pretend board: what is written, what is refused before, what happens when the new firmware fails."""

import hashlib
import time

import pytest

from firmware.slots import parse_pointer
from host.errors import UserError
from host.flash.board_files import BoardFiles
from host.flash.flash import Wish, flash
from host.flash.link import BoardError, BoardLink
from tests.flash.pretend import PretendBoard
from tests.flash.trees import image_of, tree


def put(board, root, **wish):
    return flash(board.port, Wish("gait", image_of(root), **wish))


def contents(board):
    return hashlib.sha256(board.image.read_bytes()).hexdigest()


def survey(board):
    with BoardLink(board.port) as link:
        return BoardFiles(link).survey()


@pytest.fixture
def board(tmp_path):
    with PretendBoard(tmp_path / "board") as board:
        yield board


def test_fresh_board(board, tmp_path):
    outcome = put(board, tree(tmp_path / "src"))
    assert (outcome.slot, outcome.version, outcome.self_test) == ("a", "1", "passed")
    assert board.wait_for(b"running 1")
    after = survey(board)
    assert after.pointer == ("a", "-", 0, 1)
    assert {"boot.py", "main.py", "slots.py", "a/manifest.json", "a/shared/extra0.mpy"} <= set(after.files)
    assert after.report["stage"] == "stopped"


def test_nothing_is_written_when_nothing_changed(board, tmp_path):
    put(board, tree(tmp_path / "src"))
    before = contents(board)
    outcome = put(board, tree(tmp_path / "src"))
    assert (outcome.changed, outcome.bytes, outcome.uploaded) == (False, 0, [])
    assert contents(board) == before
    put(board, tree(tmp_path / "src", version="2"), dry_run=True)
    assert contents(board) == before


def test_dry_run_tells_what_would_be_sent(board, tmp_path):
    put(board, tree(tmp_path / "src"))
    outcome = put(board, tree(tmp_path / "src", version="2"), dry_run=True)
    assert outcome.dry_run
    assert "b/shared/extra0.mpy" in outcome.uploaded
    assert "b/shared/common.mpy" in outcome.copied


def test_upgrade_sends_only_what_changed_and_the_third_removes_what_is_stale(board, tmp_path):
    put(board, tree(tmp_path / "src", extra=4))
    outcome = put(board, tree(tmp_path / "src", version="2"))
    assert outcome.slot == "b"
    assert outcome.uploaded == [
        "b/firmware/gait.mpy", "b/firmware/gait_app.mpy",
        "b/shared/extra0.mpy", "b/shared/extra1.mpy", "b/shared/extra2.mpy",
    ]  # fmt: skip
    assert "b/shared/common.mpy" in outcome.copied
    with BoardLink(board.port) as link:
        BoardFiles(link).write("a/shared/common.py", b"NAME = 'shadows common.mpy'\n", lambda part: None)
        link.reset()
    outcome = put(board, tree(tmp_path / "src", version="3", extra=2))
    assert (outcome.slot, outcome.version) == ("a", "3")
    assert outcome.removed == ["a/shared/common.py", "a/shared/extra2.mpy", "a/shared/extra3.mpy"]
    after = survey(board)
    assert after.pointer == ("a", "b", 0, 1)
    assert not {"a/shared/common.py", "a/shared/extra3.mpy"} & set(after.files)


def test_files_of_ones_own_stay(board, tmp_path):
    with BoardLink(board.port) as link:
        BoardFiles(link).write("joint.bin", b"parameters", lambda part: None)
    for version in "12":
        put(board, tree(tmp_path / "src", version=version))
    with BoardLink(board.port) as link:
        assert BoardFiles(link).digest("joint.bin") == hashlib.sha256(b"parameters").hexdigest()


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({"body": "raise ValueError('broken build')"}, "ValueError: broken build"),
        ({"body": "import nothing_like_it"}, "ImportError"),
        ({"self_test": "return 'sin is 3'"}, "self-test: sin is 3"),
    ],
)
def test_a_broken_build_falls_back(board, tmp_path, broken, words):
    put(board, tree(tmp_path / "src"))
    with pytest.raises(BoardError, match="the new firmware did not start") as error:
        put(board, tree(tmp_path / "src", version="2", **broken))
    assert words in str(error.value)
    assert "the board is back on slot a" in str(error.value)
    assert board.wait_for(b"running 1")
    assert survey(board).pointer == ("a", "-", 0, 1)
    assert put(board, tree(tmp_path / "src", version="3")).slot == "b"


def test_a_board_nobody_confirms_goes_back_by_itself(board, tmp_path):
    put(board, tree(tmp_path / "src"))
    put(board, tree(tmp_path / "src", version="2"))
    with BoardLink(board.port) as link:
        link.run("import slots\nslots.write_pointer('b', 'a', 0, 0)")
        for _ in range(3):
            board.after_reset(link.reset, b"running 2")
            link.interrupt()
        assert not link.ask(REPORT)["confirmed"]
        board.after_reset(link.reset, b"running 1")
        link.interrupt()
        assert link.ask(REPORT)["confirmed"]
        assert "slot b was not confirmed in 3 starts: back to slot a" in BoardFiles(link).log()


REPORT = "import json, slots\nprint('@@' + json.dumps(slots.report()))"


@pytest.mark.parametrize("pointer", [b"a b 0 1 00000000\n", b"\xff\xfe"])
def test_a_pointer_that_is_none_starts_what_is_whole(board, tmp_path, pointer):
    put(board, tree(tmp_path / "src"))
    with BoardLink(board.port) as link:
        BoardFiles(link).write("slot.txt", pointer, lambda part: None)
        link.reset()
    assert board.wait_for(b"running 1")
    assert put(board, tree(tmp_path / "src", version="2")).slot == "b"


def test_the_slot_that_works_is_not_overwritten(board, tmp_path):
    put(board, tree(tmp_path / "src"), slot="b")
    before = contents(board)
    with pytest.raises(UserError, match="slot b holds the firmware that works"):
        put(board, tree(tmp_path / "src", version="2"), slot="b")
    assert contents(board) == before


def test_motor_supply_must_be_off(board, tmp_path):
    put(board, tree(tmp_path / "src", supply=24000))
    before = contents(board)
    with pytest.raises(UserError, match=r"the motor supply is on, 24\.0 V: switch it off"):
        put(board, tree(tmp_path / "src", version="2"))
    assert contents(board) == before
    assert board.wait_for(b"running 1")


WATCHED = """import machine
    dog = machine.WDT(timeout=300)
    while True:
        time.sleep_ms(5)
        dog.feed()"""


def test_motor_supply_is_asked_for_even_before_the_application_started(board, tmp_path):
    put(board, tree(tmp_path / "src", supply=24000))
    with BoardLink(board.port) as link:
        link.run("import sys\ndel sys.modules['firmware.application']")
        assert BoardFiles(link).survey().supply_mV == 24000


def test_a_firmware_that_cannot_be_imported_can_be_replaced(board, tmp_path):
    root = tree(tmp_path / "src")
    put(board, root)
    with BoardLink(board.port) as link:
        BoardFiles(link).write("a/firmware/application.mpy", b"torn", lambda part: None)
        link.reset()
    assert put(board, tree(tmp_path / "src", version="2")).version == "2"


def test_a_watchdog_is_held_off(board, tmp_path):
    root = tree(tmp_path / "src", body=WATCHED)
    text = (root / "firmware/gait_app.py").read_text().replace("WATCHDOG = False", "WATCHDOG = True")
    (root / "firmware/gait_app.py").write_text(text)
    put(board, root)
    board.settle(b"running 1")
    resets = board.resets
    with BoardLink(board.port) as link:
        BoardFiles(link)
        link.run("import time\ntime.sleep(1)")
        assert board.resets == resets
        assert (board.folder / "watchdog").read_text() == "32000"
        link.run("slots.start.watchdog.__init__(300)")
        end = time.monotonic() + 10
        while board.resets == resets and time.monotonic() < end:
            time.sleep(0.01)
    assert board.resets == resets + 1  # the check can fail: a watchdog not held off resets the board


def test_wrong_mpy_version_is_refused_before_anything_is_written(tmp_path):
    with PretendBoard(tmp_path / "board", mpy=5 | 1 << 8 | 2 << 10) as board:
        BoardLink(board.port).interrupt()
        before = contents(board)
        with pytest.raises(UserError, match=r"reads mpy 5\.1, but mpy-cross here makes 6\.3: install the MicroPython"):
            put(board, tree(tmp_path / "src"))
        assert contents(board) == before


def test_unknown_processor_is_refused(tmp_path):
    with (
        PretendBoard(tmp_path / "board", mpy=6 | 3 << 8 | 15 << 10) as board,
        pytest.raises(UserError, match="processor number 15"),
    ):
        put(board, tree(tmp_path / "src"))


def test_fat_is_refused(tmp_path):
    with PretendBoard(tmp_path / "board", filesystem="fat", block=512) as board:
        survey(board)
        before = contents(board)
        with pytest.raises(UserError, match=r"its file system is VfsFat: .* format it as LittleFS once"):
            put(board, tree(tmp_path / "src"))
        assert contents(board) == before


def test_full_disk_is_refused_before_anything_is_written(tmp_path):
    with PretendBoard(tmp_path / "board", size=36 * 4096) as board:
        put(board, tree(tmp_path / "src"))
        before = contents(board)
        with pytest.raises(UserError, match=r"bytes are needed for a second slot, \d+ are free"):
            put(board, tree(tmp_path / "src", version="2", extra=12))
        assert contents(board) == before


def test_a_disk_that_fills_up_leaves_the_old_firmware(tmp_path, monkeypatch):
    monkeypatch.setattr("host.flash.flash.check_space", lambda *_: None)
    with PretendBoard(tmp_path / "board", size=36 * 4096) as board:
        put(board, tree(tmp_path / "src"))
        with pytest.raises(BoardError, match=r"file system is full: .*the old firmware still starts"):
            put(board, tree(tmp_path / "src", version="2", extra=24))
        assert board.wait_for(b"running 1")
        monkeypatch.undo()
        assert put(board, tree(tmp_path / "src", version="3", extra=1)).version == "3"


def test_a_file_read_back_differently_is_named(board, tmp_path, monkeypatch):
    put(board, tree(tmp_path / "src"))
    write = BoardFiles.write

    def spoil(self, path, data, done):
        write(self, path, b"?" + data[1:] if path.endswith("extra1.mpy") else data, done)

    monkeypatch.setattr(BoardFiles, "write", spoil)
    with pytest.raises(BoardError, match=r"b/shared/extra1\.mpy: the board reads back something else"):
        put(board, tree(tmp_path / "src", version="2"))
    assert board.wait_for(b"running 1")


def test_an_id_is_handed_to_the_joint(board, tmp_path):
    taking = tree(tmp_path / "src", body="import os; os.remove('node.txt')")
    outcome = flash(board.port, Wish("joint", image_of(taking), node=7))
    assert outcome.changed
    with pytest.raises(BoardError, match="did not take over id 7"):
        flash(board.port, Wish("joint", image_of(tree(tmp_path / "src", version="2")), node=7))
    assert survey(board).node == "7\n"


def test_pointers_survive_packing():
    from firmware.slots import pack_pointer

    for pointer in (("a", "b", 0, 1), ("b", "-", 3, 0)):
        text = pack_pointer(*pointer)
        assert parse_pointer(text) == pointer
        for at in range(len(text) - 1):
            assert parse_pointer(text[:at] + ("x" if text[at] != "x" else "y") + text[at + 1 :]) is None
