"""A scheduler and workers as on other machines: processes with an environment and a folder of their own."""

import os
import re
import subprocess
import sys
from contextlib import contextmanager

from tests.waiting import PATIENCE_S, wait_until


class Standing:
    """A scheduler, and workers that can be killed."""

    def __init__(self, folder, python=sys.executable):
        self.folder, self.python, self.processes = folder, python, []
        self.folder.mkdir(parents=True, exist_ok=True)
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        self.address = wait_until(self._address, "the scheduler tells its address")

    def _start(self, what, *arguments):
        """Start a process that knows of this one's environment no more than where programs lie."""
        home = self.folder / f"home{len(self.processes)}"
        home.mkdir()
        environment = {"PATH": os.defpath, "HOME": str(home), "TMPDIR": str(home)}
        kept = ("CARAMELO_CORE", "OPENBLAS_NUM_THREADS")  # which core, and what a worker's nanny would set
        environment |= {name: os.environ[name] for name in kept if name in os.environ}
        log = (home / "log").open("w")
        process = subprocess.Popen([self.python, "-m", f"distributed.cli.dask_{what}", *arguments],
                                   cwd=home, env=environment, stdout=log, stderr=log)
        self.processes.append((process, log))
        return process

    def _address(self):
        assert self.scheduler.poll() is None
        found = re.search(r"Scheduler at: +(tcp://127\.0\.0\.1:\d+)", (self.folder / "home0/log").read_text())
        return found and found.group(1)

    def worker(self, threads=1):
        """Start a worker of one process that nobody starts again; return it."""
        process = self._start("worker", self.address, "--no-nanny", "--nthreads", str(threads), "--no-dashboard")
        log = self.folder / f"home{len(self.processes) - 1}/log"
        wait_until(lambda: "Registered to" in log.read_text(), log.read_text)
        return process

    def end(self):
        for process, log in reversed(self.processes):
            process.kill()
            process.wait(PATIENCE_S)
            log.close()


@contextmanager
def standing(folder, **more):
    """Yield a scheduler without workers."""
    cluster = Standing(folder, **more)
    try:
        yield cluster
    finally:
        cluster.end()
