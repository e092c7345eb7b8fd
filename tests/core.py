"""The core compiled of this checkout's sources, kept for the next test runs. `python -m tests.core` prints its folder.

Where it can't be compiled that says so, and prints `source`: either way what CARAMELO_CORE is to be for the tests that
only use the core.
"""

import shutil
import sys
from importlib.metadata import version
from pathlib import Path

from host.boards.build.native_core import build_core, why_not
from host.boards.core import sources_id

from . import ROOT

CACHE = ROOT / ".pytest_cache/d"  # where pytest keeps things


def kept_core() -> Path:
    """Return the folder for CARAMELO_CORE that holds the core of these sources, made if it is not there."""
    home = CACHE / f"core-{version('mypy')}"
    if not (home / sources_id()).is_dir():
        shutil.rmtree(home, ignore_errors=True)  # of other sources
        build_core(home / sources_id())
    return home


if __name__ == "__main__":
    missing = why_not()
    if missing:
        sys.stderr.write(f"all tests run from the sources, which takes longer: {missing}\n")
    print("source" if missing else kept_core())
