"""The float twin runs on MicroPython too, so that a board can be asked what the real numbers are."""

import shutil

import pytest

from host.boards.runtimes.unix import Unix
from tests import ROOT
from tests.float_twin import sample
from tests.marks import skip_without

USED = (
    "attitude", "balance", "body", "fixed", "gait", "goals", "leg", "pid", "planner", "reach", "sample", "si", "swing",
)  # fmt: skip
SCRIPT = "import json\nfrom float_twin.sample import numbers\nprint('@@' + json.dumps({'numbers': numbers()}))\n"


def test_every_number_of_the_sample_is_the_same(tmp_path):
    runtime = Unix("source")
    skip_without(runtime)
    shutil.copytree(ROOT / "shared", tmp_path / "shared", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "float_twin").mkdir()
    for name in USED:
        shutil.copy(ROOT / "tests/float_twin" / f"{name}.py", tmp_path / "float_twin")
    there = runtime.ask(tmp_path, SCRIPT)["numbers"]
    here = sample.numbers()
    assert len(there) == len(here) > 1000
    assert there == pytest.approx(here, abs=1e-9)
    assert {float(state) for state in (1, 3, 4, 5)} <= set(here)
