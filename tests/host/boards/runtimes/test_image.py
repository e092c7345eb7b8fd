"""A board's image: what is checked before it is built, the files that come out, its budget. Building it needs more."""

import json
import os
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import pytest

from firmware.flash_map import BASE, HEADER, IMAGE_MOST, slot_at
from host.boards.build import board_image, toolchain
from host.boards.build.dfu import dfu_file, hex_file, parts
from host.boards.build.image_budget import BUDGET, ROWS, over_budget, rows
from host.boards.build.image_file import make_image, read_image_file, write_image_file
from host.util.errors import UserError

LOADER = bytes(range(256)) * 3
MEASURED = json.loads(BUDGET.read_text())


def image(text="a"):
    halves = [(slot + text).encode() * 40001 for slot in "ab"]
    return make_image("joint", "CARAMELO_JOINT", "0.1.0", 0x1234, "1.29.0", halves, LOADER)


def test_an_image_file_gives_back_what_was_put_into_it_and_is_the_same_every_time(tmp_path):
    for name in "12":
        write_image_file(image(), tmp_path / name)
    assert (tmp_path / "1").read_bytes() == (tmp_path / "2").read_bytes()
    assert read_image_file(tmp_path / "1") == image()
    header = image().header(1)
    assert (header.slot, header.length, header.board, header.protocol) == (1, 80004, "CARAMELO_JOINT", 0x1234)
    assert header.build == image().about.build != image("c").about.build


def test_an_image_that_no_slot_holds_is_not_made():
    with pytest.raises(ValueError, match=f"a slot holds {IMAGE_MOST}"):
        make_image("joint", "B", "1", None, "1", [bytes(IMAGE_MOST + 4)] * 2, b"")


def test_a_dfu_file_holds_loader_and_slot_a_at_their_places():
    data = dfu_file(image())
    assert struct.unpack("<I", data[-4:])[0] == zlib.crc32(data[:-4]) ^ 0xFFFFFFFF
    assert struct.unpack("<HHHH3sB", data[-16:-4]) == (0xFFFF, 0xDF11, 0x0483, 0x011A, b"UFD", 16)
    assert struct.unpack("<5sBIB", data[:11]) == (b"DfuSe", 1, len(data) - 16, 1)
    signature, _, named, _, size, count = struct.unpack("<6sBI255sII", data[11:285])
    assert (signature, named, size, count) == (b"Target", 1, len(data) - 16 - 285, 2)
    found, at = [], 285
    while at < len(data) - 16:
        address, length = struct.unpack_from("<II", data, at)
        found.append((address, data[at + 8 : at + 8 + length]))
        at += 8 + length
    assert found == parts(image()) == [(BASE, LOADER), (BASE + slot_at(0), image().slots[0])]


def test_a_hex_file_holds_the_same():
    memory, upper = {}, 0
    for line in hex_file(image()).splitlines():
        record = bytes.fromhex(line.removeprefix(":"))
        assert sum(record) & 0xFF == 0
        count, offset, kind = struct.unpack_from(">BHB", record)
        if kind == 4:
            upper = int.from_bytes(record[4:6], "big") << 16
        for place in range(count if kind == 0 else 0):
            memory[upper + offset + place] = record[4 + place]
    for at, data in parts(image()):
        assert bytes(memory[at + place] for place in range(len(data))) == data
    assert len(memory) == sum(len(data) for _, data in parts(image()))


def sources(folder: Path, version=(1, 29, 0), lib=toolchain.SUBMODULES) -> Path:
    """Return a folder that looks like MicroPython's sources."""
    names = zip(("MAJOR", "MINOR", "MICRO"), version, strict=True)
    texts = {"py/mpconfig.h": "".join(f"#define MICROPY_VERSION_{name} {number}\n" for name, number in names)}
    texts |= {f"lib/{name}/readme": "" for name in lib} | {"ports/stm32/Makefile": "all:\n"}
    for path, text in texts.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text)
    return folder


def test_sources_are_checked(tmp_path):
    assert toolchain.check_sources(sources(tmp_path / "good")) == "1.29.0"
    with pytest.raises(UserError, match=r"no sources of MicroPython: git clone --branch v1\.29\.0 https"):
        toolchain.check_sources(tmp_path / "none")
    with pytest.raises(UserError, match=r"lib/tinyusb is empty: git -C .* submodule update --init"):
        toolchain.check_sources(sources(tmp_path / "empty", lib=("stm32lib", "CMSIS_6")))
    with pytest.raises(UserError, match=r"version 1\.19\.1; 1\.28 or newer is needed"):
        toolchain.check_sources(sources(tmp_path / "old", version=(1, 19, 1)))


def test_a_missing_compiler_is_told_with_what_to_install(monkeypatch):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    with pytest.raises(UserError, match=r"arm-none-eabi-gcc is not installed: sudo apt-get install gcc-arm-none-eabi"):
        toolchain.check_compiler()


def test_a_build_that_fails_tells_its_first_complaint(tmp_path):
    folder = sources(tmp_path / "source")
    rule = "all:\n\t@echo CC one.c\n\t@echo 'one.c:3: error: no such thing'\n\t@false\n"
    (folder / "ports/stm32/Makefile").write_text(rule)
    told = []
    with pytest.raises(UserError, match=r"the build failed: one\.c:3: error: no such thing \(all of it: .*log\)"):
        toolchain.make(folder, "all", {}, 1, tmp_path / "log", lambda: told.append(1))
    assert told == [1]


def test_what_keeps_to_the_budget_is_not_told_and_a_byte_more_is():
    for role, measured in MEASURED.items():
        assert set(measured) == set(ROWS)
        assert over_budget(role, rows(role, measured)) == []
        for name in ROWS:
            worse = {**measured, name: measured[name] + (-1 if name == "heap" else 1)}
            (sentence,) = over_budget(role, rows(role, worse))
            assert f"the budget is at {'least' if name == 'heap' else 'most'} {measured[name]}" in sentence


@pytest.mark.parametrize(("more", "code"), [(0, 0), (1, 1)])
def test_the_command_writes_the_files_and_fails_over_budget(run, run_json, tmp_path, monkeypatch, more, code):
    measured = {**MEASURED["joint"], "frozen": MEASURED["joint"]["frozen"] + more}
    built = board_image.Built(image(), measured)
    monkeypatch.setattr(board_image, "build_board_image", lambda *arguments: built)
    command = ["firmware", "image", "--micropython", str(tmp_path), "--role", "joint", "--out", str(tmp_path / "out")]
    got, answer, _ = run_json(*command)
    assert (got, answer["images"]["joint"]["bytes"], len(answer["over_budget"])) == (code, measured, more)
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["joint.caramelo", "joint.dfu", "joint.hex"]
    assert read_image_file(tmp_path / "out/joint.caramelo") == image()
    got, out, _ = run(*command)
    assert got == code
    assert "CARAMELO_JOINT, version 0.1.0" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(("--role", "cook"), "--role cook: allowed joint, gait"), ((), "no sources of MicroPython")],
)
def test_wrong_use_is_one_line(refused, tmp_path, arguments, words):
    assert words in refused("firmware", "image", "--micropython", str(tmp_path / "none"), *arguments)


def test_pins_are_named_once_and_are_those_that_the_chip_has():
    for board in board_image.BOARD.values():
        lines = (board_image.BOARDS / board / "pins.csv").read_text().splitlines()
        names, pins = zip(*(line.split(",") for line in lines), strict=True)
        assert len(set(names)) == len(names)
        assert len(set(pins)) == len(pins)
        assert {pin[:2] for pin in pins} <= {"PA", "PB", "PC", "PD"}
        assert all(int(pin[2:]) < 16 for pin in pins)


def build_from_sources(role, folder):
    """Build a role's image in ``folder``; skips the test where the sources or the compiler are missing."""
    named = os.environ.get("CARAMELO_MICROPYTHON")
    if named is None:
        pytest.skip("CARAMELO_MICROPYTHON names no sources of MicroPython")
    if shutil.which(toolchain.GCC) is None:
        pytest.skip(f"{toolchain.GCC} is not installed")
    return board_image.build_board_image(role, "caramelo", Path(named), folder, os.cpu_count() or 1)


@pytest.mark.slow
@pytest.mark.parametrize("role", board_image.BOARD)
def test_the_image_is_built_from_real_sources_and_keeps_to_its_budget(tmp_path, role):
    built = build_from_sources(role, tmp_path)
    assert over_budget(role, rows(role, built.bytes)) == []
    for slot, data in enumerate(built.image.slots):
        stack, entry = struct.unpack_from("<II", data, HEADER)
        assert stack == 0x1000FFF8
        assert BASE + slot_at(slot) + HEADER < entry < BASE + slot_at(slot) + len(data)
        assert entry & 1
    command = [toolchain.NM, str(tmp_path / "slot_a.elf")]
    symbols = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert "20020000 " in next(line for line in symbols.splitlines() if line.endswith(" _heap_end"))
