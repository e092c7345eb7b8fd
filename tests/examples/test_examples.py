"""Every example runs in simulation and prints what it should."""

import re
import runpy
import sys

import pytest

from tests import ROOT

FOLDER = ROOT / "examples"
# What each prints. Numbers are what follows from the example's own: 3 s at 0.05 m/s, sides of 0.2 m, a goal, ...
PRINTS = {
    "first_walk": r"x 0\.1\d+ m, y -?0\.0\d+ m, yaw (2[6-9]|3[0-4])\.\d deg",
    "square": r"corner 4: x -?0\.0\d m, y -?0\.0\d m\nclosed within 0\.0\d m",
    "poses": r"back in its stance: standing",
    "push_ups": r"10 push-ups, the calf bent by up to 0\.[4-6]\d rad",
    "paw": r"paw up: calf at -(1\.[5-9]\d|2\.[01]\d) rad, state standing",
    "go_to": r"at x 0\.(2[6-9]|3[0-4]) m, y 0\.1[1-9] m, heading \d+ deg",
    "load": r"FL_calf +\d+ % #+\n(.+\n){10}RR_thigh +\d+ % #+",
    "record": r"wrote walk\.mcap, \d{2,} kB",
    "gaits": r"(\S+ +(not advised: .+|\d+ mm/s of 50)\n){3,}",
    "own_robot": r"mine walked 0\.1\d m\nrefused: mine\.toml: links\.trunk\.mass_kg: value -1: allowed: .*",
}


def test_every_example_is_looked_at():
    assert sorted(path.stem for path in FOLDER.glob("*.py")) == sorted(PRINTS)


def test_every_example_is_short():
    """Requirement: short enough to be read at once."""
    assert max(len(path.read_text().splitlines()) for path in FOLDER.glob("*.py")) <= 30


def printed(name, capsys, monkeypatch, folder, *places):
    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", [f"{name}.py", *places])
    runpy.run_path(str(FOLDER / f"{name}.py"), run_name="__main__")
    return capsys.readouterr().out


@pytest.mark.parametrize("name", PRINTS)
def test_an_example_prints_what_it_should(name, capsys, monkeypatch, tmp_path):
    out = printed(name, capsys, monkeypatch, tmp_path)
    assert re.search(rf"{PRINTS[name]}\s*\Z", out), out


@pytest.mark.parametrize("name", ["first_walk", "paw", "go_to"])
def test_it_prints_so_in_space_too(name, capsys, monkeypatch, tmp_path):
    pytest.importorskip("mujoco")
    assert re.search(PRINTS[name], printed(name, capsys, monkeypatch, tmp_path, "space"))
