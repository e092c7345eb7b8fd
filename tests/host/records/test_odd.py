"""Records that somebody else wrote: every command takes them, or says in one line what is wrong; no traceback."""

import os
import time

import numpy as np
import pytest
from mcap.writer import CompressionType

from host.records import plot
from host.records.reader import Record, messages, read_record

from .odd import damaged, drive, mcap, odd_values, whole_files

CSV, PLOT = "export csv", "plot"
COMMANDS = ("info", "info --json", "replay", CSV)
OUT = {CSV: "out/csv", PLOT: "out/x.png"}


def is_one_line(code, err):
    """Return True if a command said nothing, or one printable line: why it refused, or that a part is missing."""
    lines = err.splitlines()
    missing = "cut off or damaged" in err
    return len(lines) == (code == 2 or missing) and err.strip("\n").isprintable()


def try_all(run, name, path, folder, commands):
    """Run the commands on a file; nothing but results may appear in the folder, all or none."""
    out = folder / "out"
    for command in commands:
        options = ("--out", str(folder / OUT[command])) if command in OUT else ()
        code, shown, err = run("log", *command.split(), str(path), *options)
        assert code in (0, 1, 2), (name, command)
        assert is_one_line(code, err), (name, command, err)
        assert all(line.isprintable() for line in shown.splitlines()), (name, command)
        made = [path for path in folder.rglob("*") if out in path.parents and path.is_file()]
        assert code == 0 or made == [], (name, command)
        assert all(path.parent == (out / "csv" if command == CSV else out) for path in made), (name, made)
        assert not any(path.name.startswith(".") for path in made)
        for path_made in made:
            path_made.unlink()


def test_odd_files_are_read_or_refused_in_a_line(run, tmp_path):
    (tmp_path / "in").mkdir()
    for name, path in whole_files(tmp_path / "in"):
        try_all(run, name, path, tmp_path, COMMANDS)
    assert set(os.listdir(tmp_path)) <= {"in", "out"}, "a topic led elsewhere"


@pytest.mark.parametrize("seed", range(2))
def test_odd_values_are_read_or_refused_in_a_line(run, tmp_path, seed):
    (tmp_path / "in").mkdir()
    for name, path in odd_values(tmp_path / "in", seed, 40):
        try_all(run, name, path, tmp_path, COMMANDS)


def test_odd_records_are_drawn_or_refused_in_a_line(run, tmp_path):
    """Some of each kind: a picture takes a second."""
    (tmp_path / "in").mkdir()
    for name, path in [*odd_values(tmp_path / "in", 9, 4), *list(whole_files(tmp_path / "in"))[::12]]:
        try_all(run, name, path, tmp_path, [PLOT])


@pytest.mark.parametrize("seed", range(3))
def test_damage_never_breaks_the_reader(tmp_path, run, seed):
    for name, path in damaged(tmp_path, seed, 120):
        code, _, err = run("log", "info", str(path))
        assert code in (0, 2), name
        assert is_one_line(2 if err else 0, err), name


def test_a_wrong_value_is_named(tmp_path, refused):
    wrong = [*drive(2), ("/joints", {"wanted_rad": [0.0] * 11, "measured_rad": [0.0] * 12})]
    path = mcap(tmp_path / "x.mcap", wrong)
    line = refused("log", "plot", str(path))
    assert line == f"caramelo: {path}: message 3 of /joints: wanted_rad: allowed: 12 numbers\n"
    assert os.listdir(tmp_path) == ["x.mcap"]


LONG = "x" * 300


@pytest.mark.parametrize(
    ("messages", "command", "words"),
    [
        ([("/gps", {"x": 1})], ["plot"], "nothing to draw: it contains no message of /state, /joints"),
        ([], ["export", "csv"], "nothing to export: it contains no messages"),
        ([("/gps", {"x": 1}), (LONG, {"x": 1})], ["export", "csv"], f"{LONG}.csv: can't be written: File name too"),
        ([("/gps", {"x": 1}), ("/gps", b"?")], ["export", "csv"], "message 2 of /gps: not JSON"),
    ],
)
def test_what_can_not_be_shown_is_told_and_leaves_nothing(tmp_path, refused, messages, command, words):
    path = mcap(tmp_path / "x.mcap", messages)
    assert words in refused("log", *command, str(path))
    assert os.listdir(tmp_path) == ["x.mcap"]


def test_foreign_files_are_named_and_their_compression_is(tmp_path, run, refused):
    path = mcap(tmp_path / "x.mcap", [("/gps", {"x": 1})], about=None)
    code, out, _ = run("log", "info", str(path))
    assert code == 0
    assert out.startswith(f"{path}: 0.0 s\n")
    path = mcap(tmp_path / "y.mcap", [("/gps", {"x": 1})], about=None, compression=CompressionType.LZ4)
    told = f"{path}: not a record (a chunk is compressed with lz4, not with zstd): allowed"
    assert told in refused("log", "info", str(path))


def test_a_topic_leads_nowhere_else(tmp_path, run):
    path = mcap(tmp_path / "x.mcap", [("/../X", {"x": 1}), ("/a/b", {"x": 1}), ("/load", {"load": [0.5] * 12})])
    assert run("log", "export", "csv", str(path), "--out", str(tmp_path / "deep" / "csv"))[0] == 0
    assert sorted(os.listdir(tmp_path / "deep" / "csv")) == ["%2E.%2FX.csv", "a%2Fb.csv", "load.csv"]
    assert sorted(os.listdir(tmp_path)) == ["deep", "x.mcap"]


def test_only_what_is_wanted_is_kept(tmp_path):
    path = mcap(tmp_path / "x.mcap", drive(50))
    record = read_record(path, {"/state": ("state",)})
    assert set(record.rows) == {"/state"}
    assert record.of("/state")[-1].values == {"state": "walking"}
    assert record.counts["/joints"] == 50
    assert len(list(messages(Record(path)))) == record.counts.total()


@pytest.mark.parametrize(("arguments", "words"), [
    (["export", "logs"], "logs is not a format: use caramelo log export csv FILE, such as caramelo log export csv l"),
    (["export", "csv"], "names no record: use caramelo log export csv FILE, such as caramelo log export"),
    (["plot", "x.mcap", "--out", "x.mcap"], "--out x.mcap: give a name that ends in .png"),
])  # fmt: skip
def test_wrong_use_is_told_with_an_example(refused, arguments, words):
    assert words in refused("log", *arguments)


@pytest.mark.parametrize("command", [["info"], ["export", "csv"]])
def test_a_pipe_is_refused_before_it_is_read(tmp_path, refused, command):
    reader, writer = os.pipe()
    os.write(writer, mcap(tmp_path / "x.mcap", drive(1)).read_bytes())
    os.close(writer)
    path = f"/dev/fd/{reader}"
    line = refused("log", *command, path)
    os.close(reader)
    assert line == f"caramelo: {path}: is a pipe: write the record into a file first\n"


def test_a_picture_never_replaces_its_record(tmp_path, refused):
    path = mcap(tmp_path / "x.png", drive(2))
    before = path.read_bytes()
    assert "is the record itself" in refused("log", "plot", str(path))
    assert path.read_bytes() == before


def test_a_picture_of_many_messages_takes_seconds(tmp_path, run):
    """It took a step for each pair of messages: 480 million of these 22 000, which are half a minute's work alone."""
    path = mcap(tmp_path / "x.mcap", drive(2000))
    began_s = time.process_time()
    assert run("log", "plot", str(path))[0] == 0
    assert time.process_time() - began_s < 15


def test_peaks_stay_in_a_thinned_curve():
    times_s, values = np.arange(100_003) * 0.02, np.zeros((100_003, 2))
    values[77_777], values[3, 1], values[100_002, 0] = (5.0, -7.0), np.nan, 9.0
    thin_s, thin = plot._thinned(times_s, values)
    assert len(thin) < 3 * plot.STRETCHES
    assert len(thin_s) == len(thin)
    assert (np.nanmax(thin), np.nanmin(thin)) == (9.0, -7.0)
    assert abs(thin_s[np.nanargmin(thin[:, 1])] - times_s[77_777]) < 0.02 * 100_003 / plot.STRETCHES
    assert np.all(np.diff(thin_s) >= 0)
