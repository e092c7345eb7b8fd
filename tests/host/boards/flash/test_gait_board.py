"""The real firmware of a gait board on a pretend one: self-test, planner and all, as it is frozen into an image."""

from host.boards.build.frozen import frozen_sources
from host.boards.flash.flash import Wish, flash

from .pretend import PretendBoard
from .trees import make


def image(folder, robot):
    tree = frozen_sources("gait", robot, folder / robot, "bytecode", "any").modules
    files = {path.relative_to(tree).as_posix(): path.read_text() for path in tree.rglob("*.py")}
    return make("1", modules=files)


def test_the_gait_firmware_starts_and_another_robots_takes_its_place(tmp_path):
    with PretendBoard(tmp_path / "board", image(tmp_path, "caramelo")) as board:
        assert board.wait_for(b"firmware started from slot a")
        outcome = flash(board.port, Wish(image(tmp_path, "parallel")))
        assert (outcome.self_test, outcome.slot) == ("passed", "b")
