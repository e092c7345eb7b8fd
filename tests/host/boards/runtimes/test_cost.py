"""What functions cost, against budgets; how exact they are, against their bars."""

import pytest

from host import ROOT
from host.boards.build.sizes import measure_sizes, over_budget, read_budget
from host.boards.runtimes import Unix
from host.lab.parity import budget
from host.lab.parity.accuracy import accuracies
from host.lab.parity.bench import Bench
from host.lab.parity.figures import float_microseconds, fuel, microseconds
from host.lab.parity.paths_fuel import path_fuel
from tests.marks import NEEDS_UNIX


def test_no_function_or_path_costs_more_than_its_budget(sources, tmp_path):
    burnt = fuel(sources, tmp_path) | path_fuel(tmp_path)
    assert budget.over_budget(burnt, budget.read_budget()) == [], "caramelo bench --update-budget takes the new costs"


def test_growth_beyond_5_percent_is_named():
    assert budget.over_budget({"a.f": 105}, {"a.f": 100}) == []
    assert budget.over_budget({"a.f": 106}, {"a.f": 100}) == ["a.f: costs 106, the budget is 100 (+6.0%)"]
    assert budget.over_budget({"a.f": 1, "a.g": 1}, {"a.f": 1}) == ["a.g: not in the fuel budget"]
    walk = "planner.tick:pace"  # a gait added as a table costs no more than the dearest there is
    assert budget.over_budget({"planner.tick:trot": 7, walk: 7}, {"planner.tick:trot": 7}) == []
    assert budget.over_budget({"planner.tick:trot": 7, walk: 8}, {"planner.tick:trot": 7}) == [
        f"{walk}: costs 8, the budget is 7 (+14.3%)"
    ]
    assert budget.over_budget({}, {"a.f": 1}) == ["a.f: in the fuel budget, but has no vectors"]


def test_no_module_weighs_more_than_its_budget():
    remedy = "python -m host.boards.build.sizes takes the new sizes"
    assert over_budget(measure_sizes(ROOT), read_budget()) == [], remedy


def test_growth_beyond_3_percent_is_named():
    allowed = {"shared/a.py": {"viper": 1000}}
    assert over_budget({"shared/a.py": {"viper": 1030}}, allowed) == []
    sentence = "shared/a.py: 1031 bytes as viper, the budget is 1000 (+3.1%)"
    assert over_budget({"shared/a.py": {"viper": 1031}}, allowed) == [sentence]
    assert over_budget({"shared/gait/gaits.py": {"viper": 9999}}, {"shared/gait/gaits.py": {"viper": 9}}) == []
    assert over_budget({"shared/b.py": {"viper": 1}}, {}) == ["shared/b.py: not in the size budget"]


def test_errors_stay_below_their_bars():
    figures = {figure.name: figure for figure in accuracies(4000)}
    assert [figure.name for figure in figures.values() if not figure.ok] == []
    assert figures["inverse kinematics, caramelo"].median <= 0.02
    assert figures["inverse kinematics, parallel"].median <= 0.02


def test_the_core_is_more_exact_than_cmsis_dsp():
    pytest.importorskip("cmsisdsp")
    figures = {figure.name: figure for figure in accuracies(100)}
    sine, arctangent = figures["sine"].cmsis, figures["arctangent"].cmsis
    assert sine is not None
    assert arctangent is not None
    assert sine > 4.5
    assert arctangent > 0.015


def test_a_missed_bar_is_told():
    bench = Bench(cost={"planner.tick:trot": {"cpython_us": 61.0, "float_ratio": 2.9}}, over=["a.f: costs 2"])
    assert bench.missed == ["planner.tick:trot: 2.9 x faster than floats, at least 3", "a.f: costs 2"]
    assert bench.ticks("cpython_us") == {"trot": 61.0}
    assert bench.ticks("compiled_us") == {}


@NEEDS_UNIX
def test_viper_beats_floats_in_the_same_vm(sources, tmp_path):
    viper = microseconds(Unix("viper"), sources, tmp_path / "viper", 20)
    floats = float_microseconds(Unix("viper"), sources, tmp_path / "floats", 20)
    for name in ("leg.leg_inverse", "joint.current_step", "planner.tick:paper-trot"):
        assert floats[name] > viper[name]


def test_the_bench_tells_what_it_measures_next(monkeypatch, tmp_path):
    from host.lab.parity import bench

    told = []
    for name in ("gather", "loop_microseconds", "microseconds", "_time", "_fuel", "_unix", "_instructions"):
        monkeypatch.setattr(bench, name, lambda *arguments: {})
    monkeypatch.setattr(bench, "accuracies", list)
    bench.run_bench(tmp_path, False, lambda number, total, name: told.append((number, total, name)))
    assert [number for number, _, _ in told] == list(range(1, told[0][1] + 1))
    assert [name for _, _, name in told][:2] == ["loop", "cpython"]
