"""What tests that only use the core go by: `make test` gives them machine code, which takes half as long."""

import os

import pytest

import shared.planner.planner
from host.boards.build.native_core import why_not
from host.boards.core import SWITCH


def test_what_only_uses_the_core_goes_by_machine_code():
    if os.environ[SWITCH] == "source":
        pytest.skip(f"all tests run from the sources: {why_not() or 'make test gives them the compiled core'}")
    assert shared.planner.planner.__file__.endswith(".so")
