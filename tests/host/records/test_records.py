"""Records: written in time, read whole or cut, replayed to the bit."""

import csv
import json
import os
import resource
import shutil
import signal
import subprocess
import sys
import threading

import pytest

from host.records import recorder as recorder_module
from host.records.channels import CHANNELS, DRAWN, schema
from host.records.export import export_csv
from host.records.log import LoopLog, about
from host.records.reader import Record, messages, read_record
from host.records.recorder import SYNC_S, Recorder, record_path
from host.records.replay import replay
from host.robot.gait_names import BEFORE
from host.util.errors import UserError
from shared.gait.gaits import GAIT_NAMES
from tests.host.control.rig import AHEAD, PAGE, STOP, Rig
from tests.waiting import PATIENCE_S, wait_until

from .odd import mcap

TICKS = 360  # of the drive below


def everything(record):
    """Return all values of a record."""
    return {topic: list(rows) for topic, rows in record.rows.items()}


def csv_text(record, topic, folder):
    """Return a channel's CSV file."""
    export_csv(record, folder / "csv")
    return (folder / "csv" / f"{topic[1:]}.csv").read_text()


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    """Record a drive: up, ahead, sideways with a pose, a stop."""
    path = tmp_path_factory.mktemp("records") / "drive.mcap"
    rig = Rig()
    recorder = Recorder(path, about(rig.robot, rig.supervisor))
    log = LoopLog(recorder)
    rig.loop._after_tick = log.tick
    rig.stand()
    rig.run(1.5, AHEAD)
    rig.run(0.5, {**AHEAD, "vx_m_s": 0.0, "vy_m_s": 0.03, "pose": [0, 0, 0.01, 0.1, 0, 0]})
    rig.send(STOP, PAGE)
    rig.run(0.1)
    recorder.close()
    assert (recorder.trouble, recorder.dropped) == ("", 0)
    return path


def test_a_record_holds_every_tick(drive):
    record = read_record(drive)
    assert record.whole
    assert record.about["robot"] == "caramelo"
    counts = record.counts
    ticks = counts["/timing"]
    assert ticks == TICKS
    assert {counts[topic] for topic in ("/command", "/joints", "/load", "/attitude", "/planner")} == {ticks}
    assert [row.values["state"] for row in record.of("/state")][-1] == "disarmed"
    assert record.of("/state")[-1].values["reason"].startswith("emergency stop by web 1")
    assert record.of("/command")[-1].values["stop"] == "web 1"


def test_every_message_is_as_its_schema_says(drive):
    kinds = {"number": (int, float), "integer": int, "string": str, "boolean": bool, "array": list}
    record, seen = Record(drive), 0
    for channel, _, data in messages(record):
        seen += 1
        if channel.topic in DRAWN:  # test_scene.py
            continue
        values = json.loads(data)
        for name, rule in schema(channel.topic)["properties"].items():
            assert isinstance(values[name], kinds[rule["type"]]), (channel.topic, name)
            if rule["type"] == "array":
                assert len(values[name]) == rule["maxItems"]
        assert set(values) == set(CHANNELS[channel.topic])
    assert seen == record.counts.total() > 1500


def test_replay_is_the_same_to_the_bit(drive):
    result = replay(read_record(drive))
    assert (result.ok, result.ticks, result.same_core) == (True, TICKS, True)


CHANGED = TICKS - 65  # a tick in which it walks


@pytest.mark.parametrize(("block", "place", "change"), [("joints", 4, 40), ("command", 2, -40000), ("sensed", 1, 40)])
def test_one_changed_number_is_found(drive, block, place, change):
    record = read_record(drive)
    column = record.of("/planner").columns[block]
    column.all[CHANGED * column.width + place] += change
    result = replay(record)
    assert not result.ok
    assert CHANGED <= result.ticks <= CHANGED + 2


def by_former_names(drive, gait):
    """Return a record as one of former versions, whose registry had ``gait`` as its fourth; they did not say which."""
    record = read_record(drive)
    del record.about["gaits"]
    column = record.of("/planner").columns["command"]
    for at in range(1, len(column.all), column.width):
        assert column.all[at] == GAIT_NAMES.index("trot")
        column.all[at] = gait
    return record


def test_a_record_with_the_former_names_of_its_gaits_is_replayed(drive):
    assert replay(by_former_names(drive, BEFORE.index("adaptive"))).ok


def test_a_record_of_a_gait_that_is_gone_is_refused_in_one_line(drive):
    refusal = r"drive.mcap: tick 0: the gait 'blind trot' no longer exists; there are paper-trot,"
    with pytest.raises(UserError, match=refusal):
        replay(by_former_names(drive, BEFORE.index("blind trot")))


def test_a_gap_is_told(drive):
    record = read_record(drive)
    del record.of("/planner").columns["tick"].all[100], record.of("/planner").times_ns[100]
    assert replay(record).difference == "ticks 100 .. 100 are missing: the disk did not keep up"


def test_a_record_cut_anywhere_opens(drive, tmp_path):
    data, cut = drive.read_bytes(), tmp_path / "cut.mcap"
    before = 0
    for size in range(2500, len(data), len(data) // 23):
        cut.write_bytes(data[:size])
        record = read_record(cut)
        assert not record.whole
        rows = record.counts.total()
        assert rows >= before
        before = rows
        if len(record.of("/planner")):
            assert replay(record).ok


@pytest.mark.parametrize(
    ("content", "why"),
    [(b"", ""), (b"\x89MCAP0\r\n", r" \(the file is cut off\)"), (b"no record at all", ""), (os.urandom(300), "")],
)
def test_what_is_no_record_is_refused(tmp_path, content, why):
    path = tmp_path / "x.mcap"
    path.write_bytes(content)
    with pytest.raises(UserError, match=f"not a record{why}: allowed: an MCAP file"):
        read_record(path)


@pytest.mark.parametrize("share", [0.3, 0.45, 0.5, 0.7])
def test_a_flipped_byte_is_not_believed(drive, tmp_path, share):
    """It is told, or it hit an index beside the messages and changed none of them."""
    data = bytearray(drive.read_bytes())
    data[int(share * len(data))] ^= 0xFF
    path = tmp_path / "flipped.mcap"
    path.write_bytes(data)
    record = read_record(path)
    assert not record.whole or record.damage or everything(record) == everything(read_record(drive))
    assert replay(record).ok


def test_an_older_record_is_never_overwritten(drive, tmp_path):
    before = drive.read_bytes()
    with pytest.raises(UserError, match="the file exists"):
        Recorder(drive, {})
    assert drive.read_bytes() == before
    with pytest.raises(UserError, match=f"{drive.name} is a file: name a folder"):
        Recorder(drive / "x.mcap", {})
    assert record_path(tmp_path).parent == tmp_path
    assert record_path(tmp_path / "logs").parent == tmp_path / "logs", "a folder that is not there yet"
    assert record_path(tmp_path / "x.mcap") == tmp_path / "x.mcap"


def test_messages_are_on_the_disk_within_a_second(tmp_path):
    """What has been put is synced while nothing more comes and nobody closes the record, as before a power cut."""
    path, synced = tmp_path / "x.mcap", []
    recorder = Recorder(path, {}, lambda file: synced.append(os.fstat(file).st_size))
    for tick in range(30):
        recorder.put("/load", tick / 50, {"load": [tick / 10] * 12})
    wait_until(lambda: len(read_record(path).of("/load")) == 30, lambda: synced)
    wait_until(lambda: synced[-1] == path.stat().st_size, lambda: synced)
    assert SYNC_S <= 1.0
    recorder.close()


def test_a_disk_that_hangs_with_more_waiting_than_finds_room_holds_nobody_up(tmp_path, monkeypatch):
    """Neither ``put`` nor ``close`` waits for room; once the disk goes on, what was kept is written, and no more."""
    monkeypatch.setattr(recorder_module, "MOST_WAITING", 20)
    monkeypatch.setattr(recorder_module, "CLOSE_S", 0.1)
    hanging, goes_on = threading.Event(), threading.Event()
    goes_on.set()

    def sync(file):
        hanging.set()
        goes_on.wait(PATIENCE_S)

    recorder = Recorder(tmp_path / "x.mcap", {}, sync)
    goes_on.clear()
    hanging.clear()
    assert hanging.wait(PATIENCE_S)
    for tick in range(50):
        recorder.put("/load", tick / 50, {"load": [0.0] * 12})
    closing = threading.Thread(target=recorder.close, daemon=True)
    closing.start()
    closing.join(PATIENCE_S)
    assert not closing.is_alive()
    assert recorder.dropped == 30
    assert recorder.trouble.endswith("the disk hangs, so the end of the record is missing")
    goes_on.set()
    recorder._thread.join(PATIENCE_S)
    assert len(read_record(tmp_path / "x.mcap").of("/load")) == 20


def test_a_full_disk_ends_the_record_and_not_the_drive(tmp_path):
    calls = []

    def full(file):
        calls.append(file)
        if len(calls) > 1:
            raise OSError(28, "No space left on device")

    recorder = Recorder(tmp_path / "x.mcap", {}, full)
    recorder.put("/load", 0.0, {"load": [0.0] * 12})
    wait_until(lambda: recorder.trouble, "the disk is full")
    recorder.close()
    assert "the record ends here: No space left" in recorder.trouble


def test_a_disk_that_is_full_from_the_start_is_told_and_nothing_is_left(tmp_path):
    """What is written at the start has to go somewhere; a file may grow to 10 bytes here."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (10, hard))
    try:
        with pytest.raises(UserError, match=r"--log .*x\.mcap: can't be written: File too large"):
            Recorder(tmp_path / "x.mcap", {"robot": "caramelo"})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
    assert os.listdir(tmp_path) == []


def test_csv(drive, tmp_path):
    record = read_record(drive)
    rows = list(csv.reader(csv_text(record, "/joints", tmp_path).splitlines()))
    assert rows[0][:2] == ["time_s", "wanted_rad.FR_hip"]
    assert len(rows[0]) == 37
    assert len(rows) == TICKS + 1
    assert all(len(row) == 37 for row in rows)


def test_csv_quotes_what_needs_it(tmp_path):
    path = mcap(tmp_path / "x.mcap", [("/state", {"state": "walking", "reason": 'a, "b"'})])
    assert csv_text(read_record(path), "/state", tmp_path) == 'time_s,state,reason\n0.000000,walking,"a, ""b"""\n'


def test_commands(drive, tmp_path, run, run_json, refused):
    code, facts, _ = run_json("log", "info", str(drive))
    assert (code, facts["robot"], facts["whole"], facts["missed"]) == (0, "caramelo", True, 0)
    assert "walking" in run("log", "info", str(drive))[1]
    assert run_json("log", "replay", str(drive))[:2] == (0, {
        "ok": True, "ticks": TICKS, "difference": "", "same_core": True, "whole": True,
    })  # fmt: skip
    assert run("log", "export", "csv", str(drive), "--out", str(tmp_path / "csv"))[0] == 0
    assert (tmp_path / "csv" / "planner.csv").exists()
    assert run("log", "plot", str(drive), "--out", str(tmp_path / "x.png"))[0] == 0
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")
    refused("log", "info", str(tmp_path / "none.mcap"))


def test_a_command_says_if_a_part_of_the_record_is_missing(drive, tmp_path, run_json):
    data, path = drive.read_bytes(), tmp_path / "cut.mcap"
    path.write_bytes(data[: len(data) // 2])
    code, told, err = run_json("log", "replay", str(path))
    assert (code, told["whole"]) == (0, False)
    length_s = read_record(path).duration_s
    assert err == f"caramelo: {path}: cut off or damaged after {length_s:.1f} s: read up to there\n"


@pytest.mark.parametrize("seconds", [0.3, 1.1])
def test_killed_at_any_moment_the_record_opens(tmp_path, seconds):
    """kill -9 while it writes: what was on the disk by then is there and replays."""
    path = tmp_path / "x.mcap"
    command = [sys.executable, "-m", "host.cli", "teleop", "--sim", "--direct", "--measure", "20", "--log", str(path)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert any(line.startswith("ready") for line in process.stdout)
    seen_s = wait_until(lambda: (now_s := read_record(path).duration_s) > seconds and now_s, "it records")
    os.kill(process.pid, signal.SIGKILL)
    process.wait(PATIENCE_S)
    process.stdout.close()
    record = read_record(path)
    assert not record.whole
    assert record.duration_s >= seen_s
    assert replay(record).ok


def test_a_folder_stands_for_its_newest_record(drive, tmp_path):
    with pytest.raises(UserError, match="contains no record: make one with caramelo teleop --log"):
        read_record(tmp_path)
    for age, name in ((2, "b.mcap"), (1, "a.mcap")):
        shutil.copy(drive, tmp_path / name)
        os.utime(tmp_path / name, (1000 - age, 1000 - age))
    assert read_record(tmp_path).path == tmp_path / "a.mcap"
