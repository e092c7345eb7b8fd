"""Tests that need a runtime which is not on this machine are skipped, with what is missing."""

import pytest

from host.boards.runtimes import Unix

NEEDS_UNIX = pytest.mark.skipif(Unix("viper").missing() is not None, reason=str(Unix("viper").missing()))


def skip_without(runtime):
    """Skip the test that calls if its runtime is missing: for fixtures, and for runtimes chosen by a parameter."""
    __tracebackhide__ = True  # the report names the test's line, not this one
    missing = runtime.missing()
    if missing is not None:
        pytest.skip(missing)
