"""A picture needs nothing but matplotlib itself."""

import os
import subprocess
import sys

import pytest

from tests import ROOT

pytest.importorskip("matplotlib", reason="matplotlib is not installed (extra sim)")

DRAW = """
from host.util.pictures import make_figure
axes = make_figure(2, 1).subplots(1, 1)
axes.plot([0, 1], [0, 1])
axes.figure.savefig("x.png")
"""


def test_a_picture_is_drawn_where_matplotlib_can_keep_no_settings_and_it_says_nothing(tmp_path):
    env = os.environ | {"HOME": os.devnull, "XDG_CONFIG_HOME": os.devnull, "PYTHONPATH": str(ROOT)}
    env.pop("MPLCONFIGDIR", None)
    done = subprocess.run([sys.executable, "-c", DRAW], cwd=tmp_path, env=env, capture_output=True, text=True)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")
