"""Runs tasks in processes of dask.distributed, started here for one command or running on a lab's machines.

A worker that dies costs its task another run, which gives the same answer; a task that takes four workers down with it
is given up.
"""

import logging
import pickle
import re
import signal
import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from multiprocessing import resource_tracker
from typing import Any

from distributed import Client, KilledWorker, LocalCluster, as_completed
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError

from ...util.console import write_note
from ...util.errors import NOT_ACHIEVED, UserError
from ...util.leave import leaving_later
from ...util.progress import write_step
from .remote import OtherVersionsError, run_task, told_versions
from .versions import differences, versions
from .work import Task

_CONNECT_S = 10.0
_LOOK_S = 0.02  # between two looks at what is ready: a trial takes longer
_BATCH = 200  # tasks of some kB that travel to the scheduler at once
_QUIET_S = 10.0  # without an answer, before checking whether there still is a worker


class Cluster:
    """Workers behind a scheduler. ``wanted``: versions that each must share with this process; None: they do."""

    def __init__(self, client: Client, wanted: Mapping[str, str] | None) -> None:
        self.client, self._wanted, self._runs = client, wanted, 0

    def run_all(self, tasks: Sequence[Task], done: Callable[[int], None]) -> list[Any]:
        """See Workers."""
        futures = self.queue(tasks)
        places = {future.key: place for place, future in enumerate(futures)}
        answers: list[Any] = [None] * len(futures)
        try:
            for ready, future in enumerate(self._ready(futures), 1):
                answers[places[future.key]] = _answer(future)
                future.release()  # else the cluster keeps every answer
                done(ready)
        except BaseException:
            self.client.cancel(futures)
            raise
        return answers

    def queue(self, tasks: Sequence[Task]) -> list[Any]:
        """Hand all tasks to the scheduler; return their futures in order."""
        self._runs += 1
        keys = [f"trial-{self.client.id}-{self._runs}-{place}" for place in range(len(tasks))]
        pickled = [pickle.dumps(task) for task in tasks]  # opened by run_task, once the worker has the right core
        futures: list[Any] = self.client.map(run_task, pickled, wanted=self._wanted, key=keys, pure=False,
                                              batch_size=_BATCH)
        return futures

    def _ready(self, futures: Sequence[Any]) -> Iterator[Any]:
        """Yield answers as they get ready; report if no worker is left."""
        completed, left, heard_s = as_completed(futures, loop=self.client.loop), len(futures), time.monotonic()
        while left:
            batch = completed.next_batch(block=False)
            yield from batch
            left -= len(batch)
            if batch:
                heard_s = time.monotonic()
            elif time.monotonic() > heard_s + _QUIET_S:
                self._look_for_workers()
                heard_s = time.monotonic()
            else:
                time.sleep(_LOOK_S)

    def _look_for_workers(self) -> None:
        try:
            found = self.client.nthreads()
        except (OSError, TimeoutError) as error:
            raise _lost(error) from error
        if not found:
            write_step("the cluster has no worker: waiting for one (Ctrl-C ends)")


def _answer(future: Any) -> Any:
    try:
        return future.result()
    except KilledWorker as error:
        raise UserError(f"a trial was given up: {error.allowed_failures + 1} workers died while running it, the last "
                        f"{error.last_worker.address}: check its memory", NOT_ACHIEVED) from error
    except (FutureCancelledError, CommClosedError) as error:
        raise _lost(error) from error
    except OtherVersionsError as error:
        raise _unlike("a worker that came later", str(error)) from error


def _lost(error: Exception) -> UserError:
    return UserError(f"the cluster's scheduler is gone: {error}", NOT_ACHIEVED)


def _unlike(who: str, difference: str) -> UserError:
    return UserError(f"--cluster: {who} has {difference}: its figures could differ; install the same versions there")


@contextmanager
def local_cluster(jobs: int) -> Iterator[Cluster]:
    """Yield ``jobs`` processes of this computer; they end with the block."""
    write_note(f"starting {jobs} processes")
    with _ctrl_c_for_this_process_only():
        logging.getLogger("distributed.process").disabled = True  # at exit it tells of those that did not start
        try:
            made = LocalCluster(
                n_workers=jobs, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0",
                memory_limit=0, silence_logs=logging.CRITICAL,
            )
        except RuntimeError as error:
            raise UserError(f"--jobs {jobs}: a process ended while it started: ask for fewer", NOT_ACHIEVED) from error
    with _unlogged(), made, made.get_client() as client:
        yield Cluster(client, None)


@contextmanager
def standing_cluster(address: str) -> Iterator[Cluster]:
    """Yield the workers of the scheduler at ``address``; UserError if their versions differ from this process's."""
    if not re.fullmatch(r"(tcp|tls)://.+:\d+", address):
        raise UserError(f"--cluster {address}: allowed: the scheduler's address, such as tcp://HOST:8786")
    with _unlogged(), warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of other versions: below, in one line
        try:
            client = Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as error:
            raise UserError(f"--cluster {address}: no scheduler answers ({error}): start one with dask scheduler"
                            ) from error
    with _unlogged(), client:
        yield Cluster(client, _checked(client, address))


def _checked(client: Client, address: str) -> Mapping[str, str]:
    """Return this process's versions, which every worker has too, or raise UserError."""
    threads = client.nthreads()
    if not threads:
        raise UserError(f"--cluster {address}: no worker is there: start some with dask worker {address} --nthreads 1")
    for worker, count in threads.items():
        if count != 1:
            raise UserError(f"--cluster {address}: worker {worker} runs {count} trials in one process: start it with "
                            "--nthreads 1, and --nworkers for more processes")
    mine = versions()
    for worker, told in client.run(told_versions, on_error="return").items():
        if isinstance(told, BaseException):
            raise _unlike(f"worker {worker}", f"no caramelo like this one ({told})")
        for difference in differences(mine, told):
            raise _unlike(f"worker {worker}", difference)
    return mine


@contextmanager
def _unlogged() -> Iterator[None]:
    """Keep dask's logs off the terminal: one line says why a command ends."""
    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        yield
    finally:
        logging.disable(before)


@contextmanager
def _ctrl_c_for_this_process_only() -> Iterator[None]:
    """Start the block's processes with Ctrl-C ignored, which a terminal sends to all: this process ends them.

    It hears nothing itself until they have started: dask can't end those that it is starting.
    """
    resource_tracker.ensure_running()  # started later, it would let Ctrl-C in again
    held = signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    try:
        with leaving_later():
            yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, held)
