"""The commands: one line for every error that says what to do, one JSON object, several boards at once."""

import json
import os
import pty
import threading

import pytest
import serial

from host.flash import link as link_module
from host.flash.shell import join
from tests.flash.pretend import PretendBoard
from tests.flash.trees import image_of, tree


@pytest.fixture
def small(monkeypatch, tmp_path):
    """Let `caramelo flash` build a small firmware of a version."""

    def use(version):
        build = image_of(tree(tmp_path / "src", version=version))
        monkeypatch.setattr("host.commands.flash._image", lambda role, emitter, arch, robot: build(emitter, arch))

    return use


def one_line(answer, code, *words):
    assert answer[0] == code
    assert answer[1] == ""
    assert answer[2].count("\n") == 1
    for word in words:
        assert word in answer[2]


@pytest.mark.parametrize("command", [("flash",), ("board", "info"), ("board", "logs"), ("board", "reset")])
def test_no_board(run, command):
    one_line(run(*command, "--port", "/dev/ttyACM99"), 2, "/dev/ttyACM99: no such port")


def test_no_permission(run, tmp_path, monkeypatch):
    port = tmp_path / "ttyACM0"
    port.touch()
    monkeypatch.setattr(os, "access", lambda path, mode: False)
    one_line(run("flash", "--port", str(port)), 2, "no permission: sudo usermod -aG dialout $USER")


def test_the_system_refuses_permission(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    assert "no permission" in link_module._refusal("x", OSError())


def test_port_busy(run):
    board, port = pty.openpty()
    with serial.Serial(os.ttyname(port), exclusive=True):
        one_line(run("flash", "--port", os.ttyname(port)), 2, "another program uses it: close it")
    os.close(board)
    os.close(port)


def test_something_else_on_the_port(run, monkeypatch):
    monkeypatch.setattr(link_module, "PROMPT_TIMEOUT_S", 0.3)
    board, port = pty.openpty()
    one_line(run("flash", "--port", os.ttyname(port)), 1, "does not answer as MicroPython does", "docs/flashing.md")
    os.close(board)
    os.close(port)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "name one board with --port"),
        (("--port", "x", "--port", "y"), "several with --all"),
        (("--port", "x", "--role", "cook"), "--role cook: not known; there are joint, gait"),
        (("--port", "x", "--slot", "c"), "--slot c: not known; there are auto, a, b"),
        (("--port", "x", "--role", "gait", "--id", "3"), "only joints have one"),
        (("--all", "--port", "x", "--port", "y", "--id", "3"), "flash them one by one"),
    ],
)
def test_wrong_use(run, arguments, words):
    one_line(run("flash", *arguments), 2, words)


def test_all_without_a_board(run, monkeypatch):
    monkeypatch.setattr(link_module, "found_ports", list)
    one_line(run("flash", "--all"), 2, "no board is plugged in")


def test_several_boards_info_logs_and_reset(run, small, tmp_path):
    small("1")
    with PretendBoard(tmp_path / "one") as one, PretendBoard(tmp_path / "two") as two:
        code, out, err = run("flash", "--all", "--port", one.port, "--port", two.port, "--port", "/dev/none", "--json")
        answer = json.loads(out)
        assert (code, [board["self_test"] for board in answer["boards"]]) == (1, ["passed", "passed"])
        assert list(answer["failures"]) == ["/dev/none"]
        assert err.count("\n") == 1
        assert "nothing to do: slot a" in run("flash", "--port", one.port)[1]
        small("2")
        assert "would write slot b" in run("flash", "--port", one.port, "--dry-run")[1]
        flashed = one.after_reset(lambda: run("flash", "--port", one.port), b"running 2", count=2)
        assert "self-test passed, confirmed" in flashed[1]
        info = one.after_reset(lambda: run("board", "info", "--port", one.port, "--json"), b"running 2")
        facts = json.loads(info[1])
        assert (facts["running"], facts["confirmed"], facts["version"], facts["mpy"]) == ("b", True, "2", "6.3")
        assert facts["file_system"] == "VfsLfs2"
        info = one.after_reset(lambda: run("board", "info", "--port", one.port), b"running 2")
        assert "version      2" in info[1]
        assert "nothing noted" in run("board", "logs", "--port", one.port)[1]
        assert run("board", "reset", "--port", one.port)[0] == 0
        assert one.wait_for(b"running 2")


def test_a_bare_micropython_answers_info(run, tmp_path):
    with PretendBoard(tmp_path / "board") as board:
        facts = json.loads(run("board", "info", "--port", board.port, "--json")[1])
    assert (facts["running"], facts["role"], facts["slots"]) == (None, None, {"a": "empty", "b": "empty"})


def test_the_shell_carries_both_ways_until_it_is_left(tmp_path):
    with PretendBoard(tmp_path / "board") as board, link_module.BoardLink(board.port) as link:
        keys, typed = os.pipe()
        shown, out = os.pipe()
        link.send(b"\r\x02")
        carrying = threading.Thread(target=join, args=(link, keys, out))
        carrying.start()
        os.write(typed, b"print(6 * 7)\r")
        heard = b""
        while b"\n42" not in heard:
            heard += os.read(shown, 1024)
        os.write(typed, b"\x1d")
        carrying.join(10)
        assert not carrying.is_alive()


def test_the_shell_needs_a_terminal(run, monkeypatch):
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    one_line(run("board", "shell", "--port", "/dev/null"), 2, "needs a terminal")
