"""caramelo firmware, parity and bench: exit codes, one JSON object, one line for wrong use."""

import json

import pytest

from host.cli import main
from host.commands import parity as command
from host.lab.parity import sources as gathering


def run_json(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict]:
    code = main([*arguments, "--json"])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 1
    return code, json.loads(lines[0])


@pytest.fixture
def quick(few, monkeypatch):
    """The command asks for the vectors of one module."""
    monkeypatch.setattr(gathering, "gather", lambda work: few)


def test_parity_reports_each_runtime(capsys, quick):
    code, found = run_json(capsys, "parity", "--runtime", "wasi-bytecode", "--vectors", "8")
    assert code == 0
    assert found["identical"] is True
    assert found["vectors"] > 0
    assert [row["name"] for row in found["runtimes"]] == ["cpython", "wasi-bytecode"]
    for row in found["runtimes"]:
        assert {"name", "version", "emitter", "digest", "seconds", "skipped"} <= set(row)
    assert found["runtimes"][0]["digest"] == found["runtimes"][1]["digest"]


def test_parity_exits_1_if_a_runtime_fails(capsys, quick, monkeypatch):
    from host.boards.runtimes import Wasi

    monkeypatch.setattr(Wasi, "execute", lambda self, tree, script: "not an answer")
    code, found = run_json(capsys, "parity", "--runtime", "wasi-bytecode", "--vectors", "8")
    assert code == 1
    assert found["identical"] is False
    assert "no answer" in found["differences"][0]


def test_an_unknown_runtime_is_wrong_use(capsys):
    assert main(["parity", "--runtime", "pdp11"]) == 2
    known = "--runtime pdp11: allowed cpython, cpython-compiled, cpython-c, wasi-source"
    assert known in capsys.readouterr().err


def test_the_board_comes_only_with_a_port():
    assert [r.name for r in command.choose(["wasi-source"], "/dev/ttyACM0")] == ["cpython", "wasi-source", "board"]
    assert "board" not in [r.name for r in command.choose(None, None)]
