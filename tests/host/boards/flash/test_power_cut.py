"""Power goes in the middle of a flash write while a board is flashed: whatever the moment, a whole firmware starts.

Here by the command itself on a running board; every single write is cut in test_loader.py and test_settings.py.
"""

import shutil

import pytest

from host.boards.flash.flash import Wish, flash
from host.util.errors import UserError
from tests.waiting import wait_until

from .pretend import PretendBoard
from .trees import make

FEW = 4
MANY = 60


@pytest.fixture(scope="module")
def flashed(tmp_path_factory):
    """Return a board's folder with version 1 on it, and the words written and sectors erased up to version 2."""
    home = tmp_path_factory.mktemp("cut")
    with PretendBoard(home / "board", make("1")) as board:
        assert board.wait_for(b"running 1")
    shutil.copytree(home / "board", home / "count")
    with PretendBoard(home / "count") as board:
        assert board.wait_for(b"running 1")
        flash(board.port, Wish(make("2")))
        board.wait_for_own_start()
        assert board.wait_for(b"running 2")
    return home, [int(line) for line in (home / "count/writes").read_text().split()]


def starts_after_cut(flashed, folder, life, cut):
    """Cut the power at write ``cut`` of life number ``life`` while version 2 is flashed; return what starts."""
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(flashed[0] / "board", folder)
    with PretendBoard(folder, cut=cut, cut_life=life) as board:
        assert board.wait_for(b"running 1")
        with pytest.raises(UserError):
            flash(board.port, Wish(make("2")))
        wait_until(lambda: not board.powered, "flashing failed before the cut")
    with PretendBoard(folder) as board:
        version = board.line_after(b"running ")
        flash(board.port, Wish(make("2")))  # and it can be flashed again
        assert board.wait_for(b"running 2")
    return version


def points(lives, count):
    """Return ``count`` moments, spread over all writes, the last three of each life among them: (life, write)."""
    every = [(life, cut) for life, writes in enumerate(lives) for cut in range(1, writes + 1)]
    ends = [(life, cut) for life, writes in enumerate(lives) for cut in range(max(1, writes - 2), writes + 1)]
    return sorted({*every[:: max(1, len(every) // (count - len(ends)))], *ends})


def sweep(flashed, tmp_path, count):
    found = [starts_after_cut(flashed, tmp_path / "board", *point) for point in points(flashed[1], count)]
    assert set(found) <= {"1", "2"}
    assert found == sorted(found)  # never back to the old one once the new one was switched to
    return found


def test_old_or_new_starts_after_a_power_cut(flashed, tmp_path):
    found = sweep(flashed, tmp_path, 8 + FEW)
    assert {"1", "2"} == set(found)


@pytest.mark.slow
def test_old_or_new_starts_after_many_power_cuts(flashed, tmp_path):
    found = sweep(flashed, tmp_path, MANY)
    assert len(found) >= MANY
    print(f"{len(found)} cuts: {found.count('1')} start the old firmware, {found.count('2')} the new, 0 none")
