"""The functions that a cluster's worker calls. Importing this imports no part of the core: `use_core` comes first."""

import pickle
from collections.abc import Mapping
from typing import Any

from ...boards.core import use_core
from .versions import differences, versions


class OtherVersionsError(Exception):
    """A worker that would give other figures."""


def told_versions() -> Mapping[str, str]:
    """Return the worker's versions."""
    return versions()


def run_task(task: bytes, wanted: Mapping[str, str] | None) -> Any:
    """Run a pickled task and return its answer; OtherVersionsError unless the versions are the ``wanted``."""
    use_core()
    if wanted is not None:
        found = list(differences(wanted, versions()))
        if found:
            raise OtherVersionsError(found[0])
    return pickle.loads(task).run()
