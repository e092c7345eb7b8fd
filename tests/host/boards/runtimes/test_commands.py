"""caramelo firmware, parity and bench: exit codes, one JSON object, one line for wrong use."""

import pytest

from host.commands import parity as command
from host.lab.parity import sources as gathering


@pytest.fixture
def quick(few, monkeypatch):
    """The command asks for the vectors of one module."""
    monkeypatch.setattr(gathering, "gather", lambda work: few)


def test_parity_reports_each_runtime(run_json, quick):
    code, found, _ = run_json("parity", "--runtime", "wasi-bytecode", "--vectors", "8")
    assert code == 0
    assert found["identical"] is True
    assert found["vectors"] > 0
    assert [row["name"] for row in found["runtimes"]] == ["cpython", "wasi-bytecode"]
    for row in found["runtimes"]:
        assert {"name", "version", "emitter", "digest", "seconds", "skipped"} <= set(row)
    assert found["runtimes"][0]["digest"] == found["runtimes"][1]["digest"]


def test_parity_exits_1_if_a_runtime_fails(run_json, quick, monkeypatch):
    from host.boards.runtimes import Wasi

    monkeypatch.setattr(Wasi, "execute", lambda self, tree, script: "not an answer")
    code, found, _ = run_json("parity", "--runtime", "wasi-bytecode", "--vectors", "8")
    assert code == 1
    assert found["identical"] is False
    assert "no answer" in found["differences"][0]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--runtime", "pdp11"), "--runtime pdp11: allowed cpython, cpython-compiled, cpython-c, wasi-source"),
        (("--port", "/dev/none"), "/dev/none: no such port"),
        (("--memory", "--runtime", "cpython"), "--memory: goes without --runtime, --port and --coverage"),
    ],
)
def test_wrong_use_is_told_before_anything_runs(refused, arguments, words):
    assert words in refused("parity", *arguments)


def test_memory_tells_what_it_does_and_leaves_stdout_to_the_result(run, quick, monkeypatch):
    monkeypatch.setattr("host.lab.parity.table.measure_rows", lambda sources, work: [])
    told = "memory: 1 of 1: every function in two VMs\n"
    assert run("parity", "--memory", "--json") == (0, '{"functions": []}\n', told)


def test_the_board_comes_only_with_a_port():
    assert [r.name for r in command.choose(["wasi-source"], "/dev/null")] == ["cpython", "wasi-source", "board"]
    assert "board" not in [r.name for r in command.choose(None, None)]
