"""Tasks in this process and in others of this computer: same answers, errors told, nothing left running."""

import builtins
import os
import sys

import pytest

from host.lab.workers.work import Here, workers
from host.util.errors import UserError
from tests.processes import children_of
from tests.waiting import wait_until

ADDRESS = "tcp://127.0.0.1:8786"


class Squared:
    """A task of a few instructions."""

    def __init__(self, number):
        self.number = number

    def run(self):
        return self.number**2


class Broken:
    def run(self):
        raise ArithmeticError("this trial is broken")


class Deadly:
    def run(self):
        os._exit(1)


def test_one_job_runs_here_and_needs_no_dask(monkeypatch):
    real = builtins.__import__

    def without_dask(name, *rest):
        if name.partition(".")[0] in ("distributed", "dask"):
            raise ModuleNotFoundError(name, name=name)
        return real(name, *rest)

    monkeypatch.setattr(builtins, "__import__", without_dask)
    heard = []
    with workers(1) as run_by:
        assert run_by.run_all([Squared(2), Squared(3)], heard.append) == [4, 9]
    assert heard == [1, 2]


def test_without_dask_a_line_says_what_to_install(refused, monkeypatch):
    for name in [name for name in sys.modules if name.partition(".")[0] == "distributed"]:
        monkeypatch.setitem(sys.modules, name, None)
    monkeypatch.setitem(sys.modules, "distributed", None)
    monkeypatch.delitem(sys.modules, "host.lab.workers.cluster", raising=False)
    line = refused("experiment", "table1", "--trials", "1", "--no-3d", "--jobs", "2", "--json")
    assert line.startswith("caramelo: this needs distributed, which is not installed: run make setup EXTRAS=lab in ")


def test_an_error_here_is_told():
    with pytest.raises(ArithmeticError, match="this trial is broken"):
        Here().run_all([Squared(1), Broken()], lambda done: None)


def test_jobs_and_a_cluster_are_not_both_asked_for():
    with pytest.raises(UserError, match=r"--jobs 2: not with --cluster, .* do the work"), workers(2, ADDRESS):
        pass


def test_processes_of_this_computer_answer_in_order_tell_errors_and_end():
    """Fifty answers in the order of the tasks, an error of a task as its own, and then more work still."""
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    before, heard = children_of(os.getpid()), []
    with workers(2) as run_by:
        started = children_of(os.getpid()) - before
        assert len(started) >= 2
        assert run_by.run_all([Squared(n) for n in range(50)], heard.append) == [n**2 for n in range(50)]
        with pytest.raises(ArithmeticError, match="this trial is broken"):
            run_by.run_all([Squared(1), Broken(), Squared(2)], lambda done: None)
        assert run_by.run_all([Squared(7)], lambda done: None) == [49]
    assert heard == list(range(1, 51))
    tracker = 1  # Python's own, of multiprocessing: it stays
    wait_until(lambda: len(children_of(os.getpid()) & started) <= tracker, "the processes end")


@pytest.mark.slow
def test_a_task_that_kills_who_runs_it_is_given_up():
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    with (pytest.raises(UserError, match=r"a trial was given up: 4 workers died while running it, the last tcp://"),
          workers(2) as run_by):
        run_by.run_all([Squared(1), Deadly()], lambda done: None)
