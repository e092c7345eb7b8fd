"""Workers elsewhere: the same figures as here, one killed or not; others than this are found before they work."""

import logging
from pathlib import Path

import pytest

pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")

from host.lab.experiments.foot_in_air import AirTrial
from host.lab.experiments.trials import trial_conditions
from host.lab.workers import remote, versions
from host.lab.workers.cluster import local_cluster, standing_cluster
from host.lab.workers.work import Here
from host.robot.file import load_robot
from host.util.errors import UserError
from tests.host.lab.workers.standing import standing
from tests.waiting import wait_until

ROBOT = load_robot("caramelo")
NOTHING_LISTENS = "tcp://127.0.0.1:9"
MB = 2**20


def air_trials(count):
    return [AirTrial(ROBOT, (0.05, 0.0), trial_conditions(ROBOT, seed), in_space=False) for seed in range(count)]


def pickled_figures(answers):
    return [(answer.figures, answer.recording.wanted, answer.recording.done) for answer in answers]


def resident_bytes(pid):
    (line,) = [line for line in Path(f"/proc/{pid}/status").read_text().splitlines() if line.startswith("VmRSS")]
    return 1024 * int(line.split()[1])


def test_two_workers_elsewhere_one_killed_half_way_give_the_figures_of_one_process_here(tmp_path):
    tasks = air_trials(40)
    here = Here().run_all(tasks, lambda done: None)
    with standing(tmp_path) as cluster:
        first, _ = cluster.worker(), cluster.worker()

        def kill_half_way(ready):
            if ready == len(tasks) // 2:
                first.kill()

        with standing_cluster(cluster.address) as run_by:
            there = run_by.run_all(tasks, kill_half_way)
            wait_until(lambda: len(run_by.client.nthreads()) == 1, "one was killed")
    assert pickled_figures(there) == pickled_figures(here)


def test_a_thousand_trials_queue_in_little_memory_of_the_scheduler(tmp_path):
    with standing(tmp_path) as cluster:
        cluster.worker()
        with standing_cluster(cluster.address) as run_by:
            before = resident_bytes(cluster.scheduler.pid)
            futures = run_by.queue(air_trials(1000))
            count = lambda dask_scheduler: len(dask_scheduler.tasks)  # noqa: E731  pickled by value: no tests are there
            wait_until(lambda: run_by.client.run_on_scheduler(count) == len(futures), "all have come")
            assert resident_bytes(cluster.scheduler.pid) - before < 200 * MB
            run_by.client.cancel(futures)


@pytest.mark.slow
def test_a_thousand_trials_run_in_little_memory_of_the_scheduler(tmp_path):
    with standing(tmp_path) as cluster:
        cluster.worker(), cluster.worker()
        with standing_cluster(cluster.address) as run_by:
            before, most = resident_bytes(cluster.scheduler.pid), 0

            def look(ready):
                nonlocal most
                most = max(most, resident_bytes(cluster.scheduler.pid))

            assert len(run_by.run_all(air_trials(1000), look)) == 1000
            print(f"the scheduler grew by {(most - before) / MB:.0f} MB")
            assert most - before < 200 * MB


def test_a_cluster_that_can_not_be_used_is_told_in_one_line(tmp_path, refused, monkeypatch):
    def told(address):
        return refused("experiment", "table1", "--trials", "1", "--no-3d", "--cluster", address, "--json")

    monkeypatch.setattr("host.lab.workers.cluster._CONNECT_S", 0.5)
    assert "allowed: the scheduler's address, such as tcp://HOST:8786" in told("lab")
    assert "no scheduler answers" in told(NOTHING_LISTENS)
    with standing(tmp_path) as cluster:
        assert f"no worker is there: start some with dask worker {cluster.address}" in told(cluster.address)
        cluster.worker()
        other = dict(versions.versions()) | {"mujoco": "3.3.0"}
        monkeypatch.setattr("host.lab.workers.cluster.versions", lambda: other)
        difference = "where this has 3.3.0: its figures could differ; install the same versions there"
        assert difference in told(cluster.address)
        cluster.worker(threads=2)
        assert "runs 2 trials in one process: start it with --nthreads 1" in told(cluster.address)


def test_every_difference_is_told():
    mine = versions.versions()
    assert set(mine) == {"caramelo", "python", "processor", "mujoco", "pymunk", "numpy", "scipy",
                         "OPENBLAS_NUM_THREADS", "a short walk", "a short fit"}
    for name in mine:
        assert [line.partition(" ")[0] for line in versions.differences(mine, dict(mine) | {name: "x"})] == [
            name.partition(" ")[0]]
    assert list(versions.differences(mine, mine)) == []


def test_the_fingerprint_is_of_code_and_data(tmp_path, monkeypatch):
    for folder in versions.FOLDERS:
        (tmp_path / folder).mkdir()
    (tmp_path / "host/a.py").write_text("x = 1\n")
    (tmp_path / "host/a.toml").write_text("x = 1\n")
    monkeypatch.setattr(versions, "ROOT", tmp_path)
    found = {versions.fingerprint()}
    for path in ("host/a.py", "host/a.toml"):
        (tmp_path / path).write_text("x = 2\n")
        found.add(versions.fingerprint())
    assert len(found) == 3


def test_a_worker_that_came_later_is_asked_too():
    with pytest.raises(remote.OtherVersionsError, match=r"numpy .* where this has 1\.0"):
        remote.run_task(b"", dict(versions.versions()) | {"numpy": "1.0"})


def test_processes_that_do_not_start_are_one_line(monkeypatch):
    """At exit dask told of each that it ended then, behind the line that says why."""
    process = logging.getLogger("distributed.process")
    monkeypatch.setattr(process, "disabled", False)

    def none_starts(**_):
        raise RuntimeError("no memory")

    monkeypatch.setattr("host.lab.workers.cluster.LocalCluster", none_starts)
    with pytest.raises(UserError, match="--jobs 64: a process ended while it started"), local_cluster(64):
        pytest.fail("none has started")
    assert not process.isEnabledFor(logging.CRITICAL)
