"""The real firmware of a gait board on a pretend one: self-test, planner and all, as it is frozen into an image."""

from firmware.startup_words import STOPPED
from host.boards.build.frozen import frozen_sources
from host.boards.flash.board import Board
from host.boards.flash.flash import Wish, flash
from host.boards.flash.link import BoardLink

from .pretend import PretendBoard
from .trees import frame, make

# It listens so seldom that all bytes of a command may come at once: what follows ten of Ctrl-C is lost with them.
SELDOM = """from firmware.start_gait import UsbStream
    import pyb
    usb, data = UsbStream(pyb.USB_VCP()), bytearray(64)
    while True:
        time.sleep_ms(300)
        usb.readinto(data)"""
STREAM_ONLY = {"firmware/robot_params.py": "PARAMS = ATTITUDE = None\n", "firmware/gait_main.py": "run_board = None\n"}


def image(folder, robot):
    tree = frozen_sources("gait", robot, folder / robot, "bytecode", "any").modules
    files = {path.relative_to(tree).as_posix(): path.read_text() for path in tree.rglob("*.py")}
    return make("1", modules=files)


def test_the_gait_firmware_starts_and_another_robots_takes_its_place(tmp_path):
    with PretendBoard(tmp_path / "board", image(tmp_path, "caramelo")) as board:
        assert board.wait_for(b"firmware started from slot a")
        outcome = flash(board.port, Wish(image(tmp_path, "parallel")))
        assert (outcome.self_test, outcome.slot) == ("passed", "b")


def test_a_gait_board_that_listens_seldom_gives_its_prompt(tmp_path):
    modules = {**frame("firmware.start_gait"), **STREAM_ONLY}
    with PretendBoard(tmp_path / "board", make(body=SELDOM, modules=modules)) as board:
        assert board.wait_for(b"running 1")
        with BoardLink(board.port) as link:
            assert Board(link).report().stage == STOPPED
