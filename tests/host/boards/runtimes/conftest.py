"""What the tests of the runtimes share: the gathered sources, and measurements that all workers make only once."""

import os
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from host.boards.build.native_core import why_not
from host.boards.runtimes import CPython, Unix, Wasi, base
from host.lab.parity.check import Report, collect
from host.lab.parity.figures import allocations, largest_values, promises
from host.lab.parity.sources import gather
from tests.core import kept_core
from tests.firmware.gait_vm import copy_modules
from tests.waiting import wait_until

VECTORS = 32  # over 20 000 vectors, and 800 ticks of each gait
MAKING_S = 1100.0  # compiling takes a minute, ten on a busy machine; pytest ends a test after 1200 (pyproject)


@pytest.fixture(scope="session")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with shared/ and the vectors; not to be changed."""
    return gather(tmp_path_factory.mktemp("gathered"))


@pytest.fixture
def few(sources: Path, tmp_path: Path) -> Path:
    """A folder with shared/num/fixed.py and its vectors alone, which are quick; swing, so that it is two modules."""
    names = ("probe.answer", "probe.fixed", "shared.gait.swing")
    copy_modules(tmp_path / "few", *names, root=sources, packages=("shared", "probe"))
    with (tmp_path / "few/probe/__init__.py").open("a") as probes:
        probes.write("\nMODULES = ('fixed',)\n")
    return tmp_path / "few"


@pytest.fixture(scope="session")
def once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[Path], Any]], Any]:
    """Return a function that measures something once for all workers of a test run."""
    base = tmp_path_factory.getbasetemp()
    common = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def measure(name: str, make: Callable[[Path], Any]) -> Any:
        kept, lock = common / f"{name}.pickle", common / f"{name}.lock"
        try:
            lock.mkdir()
        except FileExistsError:
            return _wait_for(kept)
        work = tmp_path_factory.mktemp(name)
        new = kept.with_suffix(".new")
        try:
            new.write_bytes(pickle.dumps((True, make(work))))
        except Exception as error:  # the others must not wait for what will not come
            new.write_bytes(pickle.dumps((False, str(error))))
        new.rename(kept)
        return _wait_for(kept)

    return measure


def _wait_for(kept: Path) -> Any:
    wait_until(kept.exists, f"{kept.name} is made", MAKING_S)
    good, result = pickle.loads(kept.read_bytes())
    assert good, result
    return result


@pytest.fixture(autouse=True)
def _compiled_once(sources, once, monkeypatch):
    """All tests and workers run on the same compiled tree of the sources; nobody changes it."""

    really = base.compile_sources

    def compiled(of: Path, work: Path, emitter: str, arch: str) -> Path:
        if of != sources:
            return really(of, work, emitter, arch)
        return once(f"{emitter}-{arch}", lambda folder: really(of, folder, emitter, arch))

    monkeypatch.setattr(base, "compile_sources", compiled)


@pytest.fixture(scope="session")
def reference(sources, once) -> Report:
    """What CPython answers to the vectors."""

    def ask(work: Path) -> Report:
        report = Report(CPython())
        collect(report, sources, work, VECTORS)
        return report

    return once("reference", ask)


@pytest.fixture(scope="session")
def bound(sources, once):
    """What the registry promises of each function."""
    return once("promises", lambda work: promises(sources, work))


@pytest.fixture(scope="session")
def largest(sources, once):
    """The largest intermediate of each function."""
    return once("largest", lambda work: largest_values(sources, work))


@pytest.fixture(scope="session")
def bytecode(sources, once):
    """What each function takes from the heap in bytecode."""
    return once("bytecode", lambda work: allocations(Wasi(), sources, work))


@pytest.fixture(scope="session")
def viper(sources, once):
    """What each function takes from the heap as viper code."""
    return once("viper", lambda work: allocations(Unix("viper"), sources, work))


@pytest.fixture(scope="session")
def compiled_home(once):
    """A folder that holds the core compiled of this checkout's sources, for the next runs too; not to be changed."""
    if why_not():
        pytest.skip(str(why_not()))

    return once("compiled", lambda work: kept_core())
