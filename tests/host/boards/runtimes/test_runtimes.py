"""The runtimes themselves: what is missing is said, what fails is a sentence, nothing hangs."""

import time

import pytest

from host.boards.runtimes import Board, CPython, Node, Unix, Wasi
from host.boards.runtimes.base import RuntimeFailure, run_command
from host.lab.parity.check import call
from tests.marks import NEEDS_UNIX, skip_without

from .pretend_board import PretendBoard

ASK = "print('chatter')\nprint('@@{\"answer\": 42}')\n"


def test_node_answers(few, tmp_path):
    skip_without(Node())
    assert Node().ask(Node().prepare(few, tmp_path), ASK) == {"answer": 42}


@pytest.mark.parametrize("runtime", [CPython(), Wasi("source"), pytest.param(Unix("source"), marks=NEEDS_UNIX)])
def test_a_failing_script_is_a_failure_with_its_words(tmp_path, runtime):
    with pytest.raises(RuntimeFailure, match="on purpose"):
        runtime.ask(tmp_path, "raise ValueError('on purpose')\n")
    with pytest.raises(RuntimeFailure, match="no answer"):
        runtime.ask(tmp_path, "print('nothing marked')\n")


def test_a_script_that_does_not_end_is_ended(tmp_path):
    with pytest.raises(RuntimeFailure, match="no answer within 1 s"):
        run_command(["sleep", "infinity"], tmp_path, 1.0, "sleeper")


def test_fuel_is_the_same_in_every_run(tmp_path):
    mark = "import host\nhost.call('', '')\n"
    script = mark + "x = 0\nfor i in range(1000):\n    x += i\n" + mark + "print('@@{}')\n"
    burnt = []
    for _ in range(2):
        runtime = Wasi(counting=True)
        runtime.ask(tmp_path, script)
        burnt.append((runtime.fuel, runtime.marks))
    assert burnt[0] == burnt[1]
    assert len(burnt[0][1]) == 2


def test_the_compiled_vm_is_kept_and_a_torn_file_is_not_used(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    assert Wasi("source").ask(tmp_path, ASK) == {"answer": 42}
    kept = next((tmp_path / "cache" / "caramelo").iterdir())
    whole = kept.read_bytes()
    kept.write_bytes(whole[:1000] + bytes(10) + whole[1010:])
    assert Wasi("source").ask(tmp_path, ASK) == {"answer": 42}
    assert kept.read_bytes() == whole


def test_no_cache_is_no_error(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("not a folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert Wasi("source").ask(tmp_path, ASK) == {"answer": 42}


def test_what_is_missing_says_what_to_do(tmp_path, monkeypatch):
    monkeypatch.setenv("CARAMELO_MICROPYTHON_JS", str(tmp_path))
    assert "npm install" in str(Node().missing()) or "node is not installed" in str(Node().missing())
    monkeypatch.setattr("platform.machine", lambda: "aarch64")
    assert Unix("viper").missing() == "the unix VM exists only for linux x86_64, this is linux aarch64"
    monkeypatch.setattr("host.util.extras.find_spec", lambda name: None)
    assert Wasi().missing() == "wasmtime is not installed: run make setup EXTRAS=test in the project's folder"


@NEEDS_UNIX
def test_a_board_is_asked_over_its_serial_port_and_left_as_it_was(few, tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    (home / "main.py").write_text("print('of the owner')\n")
    with PretendBoard(home) as pretend:
        board = Board(pretend.port)
        assert board.missing() is None
        tree = board.prepare(few, tmp_path)
        assert (home / "parity" / "shared" / "num" / "fixed.mpy").exists()
        expected = CPython().ask(CPython().prepare(few, tmp_path), call("parity", "fixed", 20))
        assert board.ask(tree, call("parity", "fixed", 20)) == expected
        with pytest.raises(RuntimeFailure, match="on purpose"):
            board.ask(tree, "raise ValueError('on purpose')\n")
        board.close()
    assert [path.name for path in home.iterdir()] == ["main.py"]


def test_a_board_that_says_nothing_is_a_failure_in_time(sources, tmp_path):
    started = time.monotonic()
    with PretendBoard(tmp_path, silent=True) as pretend:
        board = Board(pretend.port)
        with pytest.raises(RuntimeFailure, match="does not answer"):
            board.prepare(sources, tmp_path)
    assert time.monotonic() - started < 60


def test_a_port_that_is_none(sources, tmp_path):
    with pytest.raises(RuntimeFailure, match="/dev/nothing-here: no such port"):
        Board("/dev/nothing-here").prepare(sources, tmp_path)
