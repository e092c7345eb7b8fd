"""Files of the user: every kind of TOML is read in one way, and names from files are only names."""

import errno
import os
import re
from pathlib import Path

import pytest

from host.util.errors import UserError
from host.util.files import file_name, read_toml, write_text, writing
from tests import ROOT

# Besides the one place, those that read only what comes with the software.
READERS = {"util/files.py", "protocol/parameters.py", "sim/energy.py", "lab/experiments/data.py"}
NESTED = "a = " + "[" * 3000
COMMANDS = [
    ["robots", "check", "{}"], ["robots", "show", "{}"], ["walk", "--robot", "{}"],
    ["calibrate", "--sim", "--robot", "{}"], ["calibrate", "--sim", "--answers", "{}"],
    ["teleop", "--sim", "--json", "--measure", "1", "--robot", "{}"], ["servos", "scan", "--robot", "{}"],
    ["teleop", "--sim", "--json", "--measure", "1", "--calibration", "{}"],
    ["joints", "scan", "--sim", "--robot", "{}"],
]  # fmt: skip


@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
@pytest.mark.parametrize("content", [NESTED, "a = {b=" * 3000, "\x00", 'name = "\x1b[2J"', "a.b." * 4000 + "c = 1"])
def test_whatever_lies_in_a_toml_file_is_told_in_a_line(refused, tmp_path, command, content):
    path = tmp_path / "x.toml"
    path.write_text(content)
    line = refused(*(word.format(path) for word in command))
    assert line.strip("\n").isprintable()
    assert str(path) in line


def test_no_other_place_parses_toml():
    readers = {path.relative_to(ROOT / "host").as_posix() for path in (ROOT / "host").rglob("*.py")
               if re.search(r"^import tomllib", path.read_text(), re.M)}  # fmt: skip
    assert readers == READERS


def test_toml_that_is_nested_too_deeply_is_no_toml(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text(NESTED)
    with pytest.raises(ValueError, match="nested too deeply"):
        read_toml(path)


@pytest.mark.parametrize("foreign", ["", ".", "..", "/", "../X", "/etc/passwd", "a/b", "a\\b", "C:x", "\x00", "\ud800",
                                     "%2F", ".hidden", "~", "x\ny", "\x1b[2J", "-rf", "ä"])  # fmt: skip
def test_a_foreign_name_is_one_file_in_the_folder(tmp_path, foreign):
    path = tmp_path / file_name(foreign)
    path.write_text("x")
    assert [each.name for each in tmp_path.iterdir()] == [path.name]
    assert re.fullmatch(r"[A-Za-z0-9_%~-][A-Za-z0-9_.%~-]*", path.name)


def test_different_names_stay_different():
    names = ["", "%", ".", "..", "%2E", "%2E.", "/", "%2F", "a/b", "a%2Fb", "A", "a"]
    assert len({file_name(name) for name in names}) >= len(names) - 1  # the empty one is written as %


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs named pipes")
def test_a_device_is_never_replaced_by_a_file(tmp_path):
    """As root, --out /dev/null made /dev/null a file."""
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UserError, match="pipe: can't be written: it is a folder or a device: name a file"):
        write_text(tmp_path / "pipe", "x")
    assert (tmp_path / "pipe").is_fifo()


def test_a_link_stays_one_and_its_file_is_written(tmp_path):
    (tmp_path / "there").mkdir()
    (tmp_path / "link").symlink_to("there/file")
    for content in ("first", "second"):
        write_text(tmp_path / "link", content)
        assert (tmp_path / "link").is_symlink()
        assert (tmp_path / "there/file").read_text() == content
    assert os.listdir(tmp_path / "there") == ["file"]


@pytest.mark.parametrize(("number", "code"), [(errno.ENOSPC, 1), (errno.EDQUOT, 1), (errno.EACCES, 2)])
def test_a_full_disk_is_not_wrong_use(tmp_path, number, code):
    with pytest.raises(UserError, match="x: can't be written: ") as raised, writing(tmp_path / "x"):
        raise OSError(number, os.strerror(number))
    assert raised.value.exit_code == code


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="needs /dev/zero")
@pytest.mark.parametrize(
    "command",
    ["calibrate --sim --answers", "joints params restore 5 --sim --file", "flash --port /dev/null", "robots check"],
)
def test_a_file_that_never_ends_is_a_line(refused, tmp_path, command):
    """They read until the memory was full."""
    path = tmp_path / "endless.toml"
    path.symlink_to("/dev/zero")
    assert refused(*command.split(), str(path)).startswith(f"caramelo: {path}: ")


@pytest.mark.parametrize("wrong", ["folder", "file/sub/x.toml"])
@pytest.mark.parametrize("command", ["calibrate --sim --out", "calibrate --sim --record", "servos setup --sim --record",
                                     "robots new --force", "tune --out"])  # fmt: skip
def test_a_file_that_cannot_be_written_is_refused_before_the_work(refused, tmp_path, monkeypatch, command, wrong):
    """A calibration was asked for to its end first."""
    monkeypatch.setattr("builtins.input", lambda *_: pytest.fail("asked something"))
    (tmp_path / "folder.toml").mkdir()
    (tmp_path / "file").write_text("mine")
    path = tmp_path / (wrong if wrong != "folder" else "folder.toml")
    assert re.search("name a (file|folder)", refused(*command.split(), str(path)))
    assert sorted(os.listdir(tmp_path)) == ["file", "folder.toml"]
