"""Figures of the host's side: codec, load, what a cycle costs, speed over CAN beside direct control."""

import pytest

from host.bus.can.host_loops import SETPOINTS
from host.commands.joints.table import Curves, spark
from host.lab.joints import figures
from host.robot.file import load_robot


@pytest.mark.slow
def test_walks_a_metre_and_a_half_over_can_as_fast_as_with_direct_control():
    assert figures.speed_figure(load_robot("parallel"), 1.5).reached


def test_the_codec_is_compared_with_cantools(monkeypatch):
    figure = figures.codec_figure(30)
    assert (figure.reached, figure.found.split(" of ")[0]) == (True, "0")
    monkeypatch.setattr(figures.frames, "decode", lambda identifier, data: ([0], 0))
    assert not figures.codec_figure(30).reached


@pytest.mark.parametrize("kind", SETPOINTS)
def test_a_cycle_of_twelve_joints_costs_about_a_millisecond(kind):
    """The figure is 1.0 ms on one core; the bar is ten times that, for a machine with other work."""
    assert figures.cycle_s(load_robot("parallel"), kind) < 10e-3


def test_the_command_prints_every_figure(run, run_json, monkeypatch):
    made = figures.Figure("what", "at most 1", "0.5", True)
    for name in ("codec_figure", "speed_figure"):
        monkeypatch.setattr(figures, name, lambda *given: made)
    for name in ("load_figures", "cycle_figures"):
        monkeypatch.setattr(figures, name, lambda *given: [made, made])
    code, found, _ = run_json("joints", "figures")
    assert (code, len(found["figures"])) == (0, 6)
    monkeypatch.setattr(figures, "speed_figure", lambda *given: figures.Figure("what", "within 5 %", "8 %", False))
    code, out, _ = run("joints", "figures")
    assert code == 1
    assert "NO" in out


def test_curves_show_what_changes():
    assert spark([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0], 1.0) == "▁▂▃▄▅▆▇█"
    assert spark([5.0, 5.1, 5.0], 100.0) == "▁▁▁"
    assert spark([None, 1.0, None], 1.0) == " ▁ "
    assert spark([None, None], 1.0) == ""
    curves = Curves(1.0)
    for value in range(100):
        line = curves.add("FR hip", float(value))
    assert (len(line), line[0], line[-1]) == (40, "▁", "█")
