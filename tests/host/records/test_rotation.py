"""A folder of records is kept within a size: the oldest finished ones go, and nothing else."""

import contextlib
import os
import subprocess
import sys
from itertools import pairwise

import pytest

from host.records.reader import Record, read_record
from host.records.recorder import CHUNK, Recorder
from host.records.replay import replay
from host.records.rotation import make_room, next_part
from host.util.errors import UserError
from tests.host.control.rig import Rig


def record(folder, day, size=1000):
    path = folder / f"caramelo-202601{day:02}-120000.mcap"
    path.write_bytes(bytes(size))
    os.utime(path, (day, day))
    return path


def test_the_oldest_go_first(tmp_path):
    records = [record(tmp_path, day) for day in (3, 1, 2, 4)]
    make_room(tmp_path, 2500, tmp_path / "running.mcap")
    assert [path.exists() for path in records] == [True, False, False, True]
    make_room(tmp_path, 2000, tmp_path / "running.mcap")
    assert [path.exists() for path in records] == [True, False, False, True]


def test_nothing_else_is_removed(tmp_path):
    names = ("walk.mcap", "caramelo-20260101-120000.mcap.bak", "caramelo-x-120000.mcap", "calibration.toml")
    for name in names:
        (tmp_path / name).write_bytes(bytes(5000))
    (tmp_path / "caramelo-20260101-120001.mcap").mkdir()
    (tmp_path / "caramelo-20260101-120002.mcap").symlink_to(tmp_path / "walk.mcap")
    make_room(tmp_path, 0, tmp_path / "running.mcap")
    assert len(list(tmp_path.iterdir())) == len(names) + 2


def test_a_running_record_stays_however_old(tmp_path):
    own, other = record(tmp_path, 1), record(tmp_path, 2)
    finished = record(tmp_path, 3)
    claims = (
        "import sys; from host.records.rotation import claim; file = open(sys.argv[1]); claim(file); print(); input()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", claims, other], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as writing:
        writing.stdout.readline()
        make_room(tmp_path, 0, own)
        assert (own.exists(), other.exists(), finished.exists()) == (True, True, False)
        writing.communicate(b"\n")
    make_room(tmp_path, 0, own)
    assert (own.exists(), other.exists()) == (True, False)


@pytest.mark.parametrize("time", ["120000", "120000123"])
def test_parts_have_names_of_one_drive(tmp_path, time):
    first = tmp_path / f"caramelo-20260101-{time}.mcap"
    second = next_part(first, 2)
    assert second.name == f"caramelo-20260101-{time}-2.mcap"
    assert next_part(second, 3).name == f"caramelo-20260101-{time}-3.mcap"


def taken(folder):
    """Return how many bytes a folder's files take; one of them may go meanwhile."""
    total = 0
    for path in folder.iterdir():
        with contextlib.suppress(FileNotFoundError):
            total += path.stat().st_size
    return total


def test_a_record_that_never_ends_stays_within_its_size(tmp_path):
    most = 1_000_000
    old = record(tmp_path, 1, 300_000)
    first = tmp_path / "caramelo-20260201-120000.mcap"
    recorder = Recorder(first, {"robot": "caramelo"}, sync=lambda file: None, most_bytes=most)
    assert old.exists()
    sizes, number = [], 0
    while recorder._part < 7:
        assert recorder.trouble == ""
        if recorder._queue.qsize() < 50:
            number += 1
            values = {"cause": "test", "action": "sit", "sentence": os.urandom(5000).hex()}
            recorder.put("/fault", number, values)
        sizes.append(taken(tmp_path))
    recorder.close()
    assert not old.exists()
    assert not first.exists()
    assert max(sizes) <= most + 2 * CHUNK
    kept = sorted(tmp_path.iterdir(), key=lambda path: int(path.stem.rpartition("-")[2]))
    times = [row.time_ns for path in kept for row in read_record(path).of("/fault")]
    assert len(times) > 50
    assert all(b - a == 10**9 for a, b in pairwise(times)), "nothing is lost between two parts"
    assert read_record(kept[-1]).about["part"] == kept[-1].stem.rpartition("-")[2]


def test_a_folder_that_can_not_be_kept_small_ends_the_record(tmp_path, monkeypatch):
    path = tmp_path / "caramelo-20260201-120000.mcap"
    recorder = Recorder(path, {}, sync=lambda file: None, most_bytes=4)

    def refuse(*arguments):
        raise PermissionError(1, "Operation not permitted", "old.mcap")

    monkeypatch.setattr("host.records.recorder.make_room", refuse)
    while not recorder.trouble:
        recorder.put("/fault", 0.0, {"cause": "test", "action": "sit", "sentence": ""})
    recorder.close()
    assert recorder.trouble.endswith("ends here: --keep: old.mcap: can't be removed: Operation not permitted")


def test_only_the_first_part_is_replayed(tmp_path):
    part = Record(tmp_path / "x-2.mcap", about={"params": "", "part": "2"})
    with pytest.raises(UserError, match="part 2 of a drive: only the first part can be replayed"):
        replay(part)


def test_a_record_of_one_part_is_replayed(tmp_path):
    from host.records.log import LoopLog, about

    rig = Rig()
    recorder = Recorder(tmp_path / "caramelo-20260101-120000.mcap", about(rig.robot, rig.supervisor), most_bytes=10**9)
    rig.loop._after_tick = LoopLog(recorder).tick
    rig.run(0.5)
    recorder.close()
    assert replay(read_record(recorder.path)).ok
