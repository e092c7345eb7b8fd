"""One source, every runtime, one digest; and a difference is found, down to the vector."""

import ast
from pathlib import Path

import pytest

from host.boards.runtimes import CCore, CPython, Runtime, Unix, Wasi
from host.lab.parity.check import Report, collect, examine, failures, first_difference
from host.lab.parity.coverage import TracedNode, compare, cover
from host.lab.parity.figures import Promise
from tests.marks import skip_without

from .conftest import VECTORS
from .plant import plant


def public_functions(sources: Path, source: str) -> list[str]:
    """Return the public functions of a module of shared/, and the public methods of its public classes."""
    found = []
    tree = ast.parse((sources / "shared" / (source.replace(".", "/") + ".py")).read_bytes())
    for node in tree.body:
        inner = node.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_") else [node]
        found += [one.name for one in inner if isinstance(one, ast.FunctionDef) and not one.name.startswith("_")]
    return found


def unregistered(sources: Path, bound: dict[str, Promise]) -> list[str]:
    """Return the public functions of shared/ that have no vectors; marks and declarations need none."""
    known = {promise.name for promise in bound.values()}
    missing = []
    for path in sorted((sources / "shared").rglob("*.py")):
        source = path.relative_to(sources / "shared").as_posix().removesuffix(".py").replace("/", ".")
        if source not in ("runtime", "record", "sense.sensed"):
            missing += [f"{source}.{name}" for name in public_functions(sources, source)]
    return [name for name in missing if name not in known]


def test_every_public_function_has_vectors(sources, bound):
    assert unregistered(sources, bound) == []


def test_a_function_without_vectors_is_named(sources, bound, tmp_path):
    new = "def quite_new(a):\n    return a\n\n\n@hot\ndef pid_step("
    copy = plant(sources, tmp_path, "shared/num/pid.py", "@hot\ndef pid_step(", new)
    assert unregistered(copy, bound) == ["num.pid.quite_new"]


def agree(reports: list[Report]) -> None:
    assert list(failures(reports)) == []
    assert {report.digest for report in reports if not report.skipped} == {reports[0].digest}


def test_the_unchanged_source_agrees_in_a_32_bit_vm(sources, reference, tmp_path):
    reports = examine([Wasi("source")], sources, tmp_path, VECTORS, lambda name: None, [reference])
    agree(reports)
    assert reports[0].vectors > 20_000
    assert [report.word_bits for report in reports] == [64, 32]


def test_every_emitter_agrees(sources, tmp_path):
    built: list[Runtime] = [CCore(), *(Unix(emitter) for emitter in ("source", "bytecode", "native", "viper"))]
    agree(examine([CPython(), Wasi("bytecode"), *built], sources, tmp_path, 16, lambda name: None))


def report_of(runtime: Runtime, sources: Path, work: Path) -> Report:
    report = Report(runtime)
    collect(report, sources, work, 40)
    return report


def test_a_planted_difference_is_found_with_its_vector(few, tmp_path):
    reference = report_of(CPython(), few, tmp_path / "reference")
    line = "    at = angle_brad >> 5 & 2046\n"
    wrong = "    if lines[at] > 32000 << 7:\n        return 32767\n"
    copy = plant(few, tmp_path / "wrong", "shared/num/fixed.py", line, line + wrong)
    other = report_of(Wasi("source"), copy, tmp_path / "other")
    assert other.failure is None
    difference = first_difference(reference, other)
    assert difference is not None
    assert difference.function == "fixed.sin_q15"
    angle = difference.inputs[0]
    assert abs((angle & 0xFFFF) - 0x4000) < 2400
    assert 32000 < abs(difference.expected[0]) < 32767
    assert abs(difference.found[0]) == 32767
    other.difference = difference
    assert list(failures([reference, other])) == [f"wasi-source: {difference.sentence()}"]
    assert f"inputs [{angle}]" in difference.sentence()


def test_a_module_that_does_not_even_load_is_a_failure_not_a_pass(few, tmp_path):
    copy = plant(few, tmp_path / "wrong", "shared/num/fixed.py", "def saturate(", "def saturate(value, *, low")
    report = report_of(Wasi("source"), copy, tmp_path / "other")
    assert report.failure is not None
    assert report.digests == {}


def test_a_missing_runtime_says_why(few, tmp_path, monkeypatch):
    monkeypatch.setattr(Unix, "missing", lambda self: "the unix VM exists only for linux x86_64")
    reports = examine([CPython(), Unix("viper")], few, tmp_path, 8, lambda name: None)
    assert reports[1].skipped == "the unix VM exists only for linux x86_64"
    assert list(failures(reports)) == []


@pytest.mark.slow
def test_statements_of_the_core_run_in_a_traced_vm(sources, tmp_path):
    skip_without(TracedNode())
    covered = cover(sources, tmp_path / "traced")
    assert covered.share >= 0.95, covered.sentence()


def test_coverage_counts_what_did_not_run(tmp_path):
    (tmp_path / "shared").mkdir()
    text = 'def f(a):\n    """Text."""\n    if a:\n        return 1\n    return 2\n'
    (tmp_path / "shared" / "one.py").write_text(text)
    covered = compare(tmp_path, {"shared/one.py": {3, 5}})
    assert covered.statements == 3
    assert covered.missed == ("shared/one.py:4",)
    assert covered.sentence().splitlines() == [
        "coverage: 66.7% of 3 statements of shared/ ran in the traced VM, not these lines:",
        "  shared/one.py: 4",
    ]
    assert not covered.enough
