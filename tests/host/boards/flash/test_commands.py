"""The commands: one line for every error that says what to do, one JSON object, several boards at once."""

import json
import os
import random
import threading
import zipfile

import pytest
import serial

from host.boards.build.image_file import read_image_file, write_image_file
from host.boards.flash import link as link_module
from host.boards.flash.shell import join
from host.util.errors import UserError
from tests.waiting import PATIENCE_S

from .pretend import STARTS, PretendBoard
from .trees import LAYOUT_ONLY, make


@pytest.fixture
def images(tmp_path):
    """Return how to write an image file of a version; its path comes back."""

    def write(version):
        path = tmp_path / f"{version}.caramelo"
        write_image_file(make(version), path)
        return str(path)

    return write


@pytest.mark.parametrize("command", [("flash",), ("board", "info"), ("board", "logs"), ("board", "reset")])
def test_no_board(refused, images, command):
    command = (*command, images("1")) if command == ("flash",) else command
    assert "/dev/ttyACM99: no such port" in refused(*command, "--port", "/dev/ttyACM99")


@pytest.mark.parametrize("port", ["/dev/null", "/etc/passwd", "foo://board"])
def test_no_serial_port(refused, port):
    line = refused("board", "info", "--port", port)
    assert f"{port}: can't be opened" in line
    assert "check that it is the board's" in line


def test_no_permission(refused, images, tmp_path, monkeypatch):
    port = tmp_path / "ttyACM0"
    port.touch()
    monkeypatch.setattr(os, "access", lambda path, mode: path != str(port))
    line = refused("flash", images("1"), "--port", str(port))
    assert "no permission: run sudo usermod -aG dialout $USER" in line


def test_the_system_refuses_permission(tmp_path, monkeypatch):
    def refuse(*_, **__):
        raise serial.SerialException(13, "could not open port: Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    assert "no permission" in link_module._refusal("x", OSError())


def test_port_busy(refused, images, silent_port):
    with serial.Serial(silent_port, exclusive=True):
        assert "another program uses it: close it" in refused("flash", images("1"), "--port", silent_port)


def test_something_else_on_the_port(refused, images, silent_port, monkeypatch):
    monkeypatch.setattr(link_module, "PROMPT_TIMEOUT_S", 0.3)
    monkeypatch.setattr(link_module, "READ_TIMEOUT_S", 0.3)
    line = refused("flash", images("1"), "--port", silent_port, code=1)
    assert "does not answer like MicroPython" in line
    assert "docs/flashing.md" in line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "name one board with --port"),
        (("--port", "x", "--port", "y"), "several with --all"),
        (("--all", "--port", "x", "--port", "y", "--id", "3"), "flash them one by one"),
    ],
)
def test_wrong_use(refused, images, arguments, words):
    assert words in refused("flash", images("1"), *arguments)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (None, "no such file: caramelo firmware image makes it"),
        (lambda data: b"hello", "not an image file of caramelo"),
        (lambda data: data[:-30], "not an image file of caramelo"),
        (lambda data: data.replace(b"running", b"runNing"), "not an image file of caramelo"),
    ],
)
def test_an_image_file_that_is_none(refused, images, tmp_path, spoil, words):
    path = tmp_path / "spoilt.caramelo"
    if spoil:
        with zipfile.ZipFile(images("1")) as archive, zipfile.ZipFile(path, "w") as stored:
            for name in archive.namelist():
                stored.writestr(name, archive.read(name))
        path.write_bytes(spoil(path.read_bytes()))
    assert words in refused("flash", str(path), "--port", "/dev/null")


def test_an_image_file_with_any_bytes_changed_is_refused_or_the_same(tmp_path):
    path = tmp_path / "1.caramelo"
    write_image_file(make(), path)
    sound, rng, refused = path.read_bytes(), random.Random(1), 0
    for _ in range(400):
        data = bytearray(sound)
        for _ in range(rng.randrange(1, 4)):
            at = rng.choice([rng.randrange(200), -rng.randrange(1, 300), rng.randrange(len(data))])
            data[at] = rng.randrange(256)
        path.write_bytes(data)
        try:
            assert read_image_file(path) == make()
        except UserError as error:
            refused += "make it anew" in str(error)
    assert refused > 200


def test_an_image_file_whose_half_is_not_what_it_says(refused, images, tmp_path):
    path = tmp_path / "spoilt.caramelo"
    with zipfile.ZipFile(images("1")) as archive, zipfile.ZipFile(path, "w") as stored:
        for name in archive.namelist():
            data = archive.read(name)
            stored.writestr(name, data.replace(b"running", b"runNing") if name == "slot_b.bin" else data)
    assert "slot b in it is damaged" in refused("flash", str(path), "--port", "/dev/null")


def test_all_without_a_board(refused, images, monkeypatch):
    monkeypatch.setattr(link_module, "found_ports", list)
    assert "no board with a USB serial port is plugged in" in refused("flash", images("1"), "--all")


def test_several_boards_info_logs_and_reset(run, run_json, images, tmp_path):
    with PretendBoard(tmp_path / "one", make()) as one, PretendBoard(tmp_path / "two", make()) as two:
        ports = ("--port", one.port, "--port", two.port, "--port", "/dev/none")
        code, answer, err = run_json("flash", images("2"), "--all", *ports)
        assert (code, [board["self_test"] for board in answer["boards"]]) == (1, ["passed", "passed"])
        assert list(answer["failures"]) == ["/dev/none"]
        assert err.count("\n") == 1
        one.wait_for_own_start()

        def to_one(*words):
            answer = run(*words, "--port", one.port)
            one.wait_for_own_start()
            return answer

        assert "nothing to do: slot b" in to_one("flash", images("2"))[1]
        assert "to slot a" in to_one("flash", images("3"), "--dry-run")[1]
        assert "self-test passed, confirmed" in to_one("flash", images("3"))[1]
        facts = json.loads(to_one("board", "info", "--json")[1])
        assert (facts["running"], facts["confirmed"], facts["version"]) == ("a", True, "3")
        assert facts["slots"]["b"] == f"version 2, build {make('2').about.build}"
        assert "version      3" in to_one("board", "info")[1]
        assert "nothing noted" in to_one("board", "logs")[1]
        assert to_one("board", "reset")[0] == 0
        assert one.wait_for(b"running 3")


def test_micropython_without_our_firmware_is_told_what_to_do(refused, tmp_path):
    with PretendBoard(tmp_path / "board", make(modules={"main.py": "", **LAYOUT_ONLY})) as board:

        def ask(command):
            line = refused("board", command, "--port", board.port, code=1)
            assert "caramelo's firmware is not on the board" in line
            assert "dfu-util" in line

        for command in ("info", "logs"):  # each ends with a reset
            board.after_reset(lambda command=command: ask(command), STARTS)


def test_a_board_without_a_joints_firmware_has_no_self_test(refused, tmp_path):
    with PretendBoard(tmp_path / "board", make()) as board:
        line = refused("motor", "selftest", "--port", board.port, code=1)
        assert "does a joint's firmware run on it? caramelo board" in line
        board.wait_for_own_start()


def test_the_shell_carries_both_ways_until_it_is_left(tmp_path):
    with PretendBoard(tmp_path / "board", make()) as board, link_module.BoardLink(board.port) as link:
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
        carrying.join(PATIENCE_S)
        assert not carrying.is_alive()


def test_the_shell_needs_a_terminal(refused, monkeypatch):
    monkeypatch.setattr("sys.stdin.isatty", lambda: False, raising=False)
    assert "needs a terminal" in refused("board", "shell", "--port", "/dev/null")
