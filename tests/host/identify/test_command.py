"""The whole command: it sweeps, keeps, fits in this process or others, judges and draws."""

import pytest

from host.identify import sweeping
from host.identify.plan import plan

pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
pytest.importorskip("mcap", reason="mcap is not installed (extra record)")

FEW = ("run +0.11", "run -0.11", "run +0.18", "run -0.18", "steps")


def test_what_is_kept_is_fitted_in_other_processes_as_in_this_to_the_bit(run_json, tmp_path, monkeypatch):
    monkeypatch.setattr(sweeping, "plan", lambda *args: [sweep for sweep in plan(*args) if sweep.name in FEW])
    folder = str(tmp_path)
    code, there, _ = run_json("identify", "--sim", "--seed", "3", "--joint", "FR calf", "--out", folder, "--jobs", "2")
    assert code == 1  # one joint is too few for a copy of the robot file
    assert there["joints"]["FR calf"]["verdict"] == "FR calf: like the other joints"
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["FR-calf.mcap", "FR-calf.png"]
    assert run_json("identify", "--fit", folder)[:2] == (1, there)


def test_a_cluster_is_for_what_was_measured_and_not_beside_processes(refused, tmp_path):
    on_it = ("--cluster", "tcp://127.0.0.1:9")
    assert "only with --fit RECORDS: measure first" in refused("identify", "--sim", "--out", str(tmp_path), *on_it)
    assert list(tmp_path.iterdir()) == []
    assert "--jobs 2: not with --cluster" in refused("identify", "--fit", str(tmp_path), "--jobs", "2", *on_it)
