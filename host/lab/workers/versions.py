"""The versions that two processes must share for a trial to give the same figures in both, to the bit."""

import hashlib
import os
import platform
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from ... import ROOT

FOLDERS = ("shared", "sim2d", "host")  # the code of a trial
LIBRARIES = ("mujoco", "pymunk", "numpy", "scipy")
THREADS = "OPENBLAS_NUM_THREADS"  # in how many parts long sums are made (host/__main__.py); dask's nanny says 1, too


@cache
def versions() -> Mapping[str, str]:
    """Return this process's: a fingerprint of the sources, Python and libraries, processor and threads, a walk and fit.

    Walk and fit show what no version can: two processors may round a sine, or the sum of a row, differently.
    """
    from ...boards.core import use_core

    use_core()
    found = {"caramelo": fingerprint(), "python": platform.python_version(), "processor": platform.machine()}
    found |= {name: _library(name) for name in LIBRARIES} | {THREADS: os.environ.get(THREADS, "unset")}
    return found | {"a short walk": _walked(), "a short fit": _fitted()}


def differences(mine: Mapping[str, str], other: Mapping[str, str]) -> Iterator[str]:
    """Yield what differs, in words."""
    for name, value in mine.items():
        theirs = other.get(name, "not told")
        if theirs != value:
            yield f"{name} {theirs} where this has {value}"


def fingerprint() -> str:
    """Return a fingerprint of all code and data."""
    digest = hashlib.sha256(__name__.encode())  # names differ between a checkout and a wheel
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*")):
        if path.suffix in (".py", ".toml"):
            digest.update(path.relative_to(ROOT).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _library(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"


def _walked() -> str:
    """Return a fingerprint of a short walk in each simulator there is."""
    from ...robot.file import load_robot
    from ...sim.walk import WalkSpec, run_walk
    from ..experiments.trials import space_is_there

    robot = load_robot("caramelo")
    spec = WalkSpec(robot, robot.gait.default, distance_m=0.05)
    digests = [run_walk(spec).digest()]
    if space_is_there():
        from ...sim.space.walk import walk_in_space

        digests.append(walk_in_space(spec).digest())
    return hashlib.sha256(" ".join(digests).encode()).hexdigest()[:16]


def _fitted() -> str:
    """Return a fingerprint of a short fit by least squares (host/identify/fit.py)."""
    import numpy as np
    from scipy.optimize import least_squares

    wanted = np.cos(np.arange(900.0))
    ways = np.sin(np.arange(9000.0)).reshape(900, 10)
    found = least_squares(lambda x: np.tanh(ways @ x) - wanted, np.zeros(10), loss="soft_l1", max_nfev=5)
    return hashlib.sha256(found.x.tobytes()).hexdigest()[:16]
