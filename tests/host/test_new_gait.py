"""A gait is one entry in shared/gait/gaits.py: with that the command walks it, and says that nobody has tried it."""

import json
import re
import subprocess
import sys

import pytest

pytest.importorskip("pymunk", reason="pymunk is not installed (extra sim)")

from host.robot.gait_advice import UNTRIED
from tests import ROOT

LAST = '    ("crawl", MOVER_CRAWL, None),\n'
# Both legs of a side at once: in the plane it arrives, in three dimensions it may fall over sideways.
(PACE,) = re.findall(r'^    \("pace", .*\n', (ROOT / "CONTRIBUTING.md").read_text(), re.M)
NO_TIME = '    ("pace", MOVER_TABLE, ((30, 100, 100, 0), ((0, _FR | _RR, 1), (240, _FL | _RL, 1)))),\n'
# Runs the command with another text of shared/gait/gaits.py.
WITH_GAITS = """
import sys, types
import shared.gait
gaits = types.ModuleType("shared.gait.gaits")
gaits.__package__ = "shared.gait"
sys.modules["shared.gait.gaits"] = shared.gait.gaits = gaits
exec(sys.stdin.read(), gaits.__dict__)
from host.cli import main
sys.exit(main(sys.argv[1:]))
"""


def with_entry(entry, *arguments):
    """Run the command of a core that has one entry more; return exit code, stdout and stderr."""
    text = (ROOT / "shared" / "gait" / "gaits.py").read_text()
    assert text.count(LAST) == 1
    done = subprocess.run(
        [sys.executable, "-c", WITH_GAITS, *arguments], input=text.replace(LAST, LAST + entry),
        capture_output=True, text=True, cwd=ROOT, timeout=300,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


def test_a_gait_of_one_entry_walks_and_is_said_to_be_untried():
    code, out, err = with_entry(PACE, "walk", "--robot", "parallel", "--gait", "pace", "--distance", "0.2", "--json")
    assert err == ""
    told = json.loads(out)
    assert (code, told["ok"]) == (0, True)
    assert told["reason"].startswith("arrived")
    assert told["advice"] == UNTRIED
    shown = with_entry(PACE, "robots", "show", "caramelo")[1]
    assert "gait pace" in shown


def test_an_entry_without_a_duration_is_told_in_one_line():
    for command in (["walk", "--gait", "pace"], ["robots", "check", "caramelo"]):
        code, out, err = with_entry(NO_TIME, *command)
        assert (code, out) == (2, "")
        assert err.count("\n") == 1
        assert "gait pace (shared/gait/gaits.py): segment 0: duration >= 1 ms" in err
