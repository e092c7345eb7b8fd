"""The core compiled for CPython: the same numbers from machine code, used only where it is of these very sources."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from host.boards import core
from host.boards.build import native_core
from host.boards.build.source import BuildError, read_modules
from host.boards.build.typed import typed_modules
from host.boards.runtimes import Compiled, CPython
from host.lab.parity.check import examine, failures, first_difference
from host.util.errors import NOT_ACHIEVED, UserError

from .conftest import VECTORS
from .plant import plant
from .test_parity import report_of

pytestmark = pytest.mark.skipif(native_core.why_not() is not None, reason=str(native_core.why_not()))

WHERE = "import shared.body.leg, sys; sys.stdout.write(shared.body.leg.__file__)"


def run_caramelo(arguments: list[str], home: str) -> subprocess.CompletedProcess[str]:
    """Run the command in a process of its own and return what it printed, and behind it where the core comes from."""
    script = f"import sys\nfrom host import cli\nassert cli.main({arguments!r}) == 0\n{WHERE}"
    return subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=300, check=True,
                          env={**os.environ, core.SWITCH: home})


def test_the_compiled_core_agrees_over_the_whole_range(sources, reference, compiled_home, tmp_path, monkeypatch):
    monkeypatch.setenv(core.SWITCH, str(compiled_home))
    reports = examine([Compiled()], sources, tmp_path, VECTORS, lambda name: None, [reference])
    assert list(failures(reports)) == []
    assert reports[0].digest == reports[1].digest
    assert reports[1].vectors > 20_000


def test_it_is_machine_code_that_agrees(sources, compiled_home, tmp_path, monkeypatch):
    monkeypatch.setenv(core.SWITCH, str(compiled_home))
    tree = Compiled().prepare(sources, tmp_path)
    slow = ("__init__", "runtime", "record")
    compiled = {path.name.partition(".")[0] for path in (tree / "shared").rglob("*.so")}
    for path in (tree / "shared").rglob("*.py"):
        assert (path.stem in compiled) != (path.stem in slow or "wire" in path.parts)
    said = Compiled().execute(tree, "import shared.body.leg\nprint(shared.body.leg.__file__)\n")
    assert said.strip().endswith(".so")


def test_a_wrong_machine_code_is_found_with_its_vector(few, tmp_path, monkeypatch):
    wrong = plant(few, tmp_path / "wrong", "shared/num/fixed.py", "    at = angle_brad >> 5 & 2046\n",
                  "    at = (angle_brad >> 5) + (angle_brad >> 13 & 2) & 2046\n")
    monkeypatch.setenv(core.SWITCH, str(tmp_path / "none"))
    reference = report_of(CPython(), few, tmp_path / "a")
    other = report_of(Compiled(), wrong, tmp_path / "b")
    assert other.failure is None
    difference = first_difference(reference, other)
    assert difference is not None
    assert difference.function == "fixed.sin_q15"


def test_every_command_uses_it_and_says_the_same(compiled_home, tmp_path):
    walk = ["walk", "--distance", "0.3", "--json"]
    with_core = run_caramelo(walk, str(compiled_home)).stdout
    without = run_caramelo(walk, "source").stdout
    assert with_core.splitlines()[1].endswith(".so")
    assert without.splitlines()[1].endswith("leg.py")
    told = [json.loads(text.splitlines()[0]) for text in (with_core, without)]
    for figures in told:
        del figures["real_time_factor"]
    assert told[0] == told[1]


def test_it_is_not_used_after_a_source_changed(compiled_home, monkeypatch):
    monkeypatch.setenv(core.SWITCH, str(compiled_home))
    assert core.find_core() is not None
    monkeypatch.setattr(core, "sources_id", lambda root: "0123456789abcdef")
    assert core.find_core() is None


@pytest.fixture
def spoilt_home(tmp_path):
    """Return a folder for cores with one of these sources that can't be loaded."""
    shared = tmp_path / core.sources_id() / "shared"
    for name, text in (("__init__", ""), ("num/__init__", ""), ("planner/__init__", ""), ("planner/planner", ""),
                       ("num/fixed", "raise ImportError('on purpose')\n")):
        (shared / name).parent.mkdir(parents=True, exist_ok=True)
        (shared / f"{name}.py").write_text(text)
    return tmp_path


def test_one_that_cannot_be_loaded_is_told_and_left_out(spoilt_home):
    done = run_caramelo(["robots", "check", "caramelo"], str(spoilt_home))
    assert "the compiled core can't be loaded (on purpose); the sources run instead" in done.stderr
    assert done.stdout.endswith(str(Path("shared", "body", "leg.py")))
    assert str(spoilt_home) not in done.stdout


def test_one_that_cannot_be_loaded_is_shown_as_such_and_built_again(spoilt_home, compiled_home, monkeypatch, run):
    monkeypatch.setenv(core.SWITCH, str(spoilt_home))
    assert "the compiled one can't be loaded; build it again: caramelo core build" in run("core", "show")[1]
    assert json.loads(run("core", "show", "--json")[1]) == {"compiled": False, "folder": None}
    whole = compiled_home / core.sources_id()
    monkeypatch.setattr(native_core, "build_core", lambda target: shutil.copytree(whole, target))
    code, out, _ = run("core", "build")
    assert (code, out) == (0, f"the core runs as machine code, from {spoilt_home / whole.name}\n")


def test_another_source_is_another_core(sources, tmp_path):
    changed = plant(sources, tmp_path, "shared/num/pid.py", "@hot\ndef pid_step(", "\n@hot\ndef pid_step(")
    assert core.sources_id(changed) != core.sources_id(sources) == core.sources_id()


def test_it_is_not_mixed_with_sources_that_run_already(compiled_home, monkeypatch):
    monkeypatch.setenv(core.SWITCH, str(compiled_home))
    before = list(sys.path)
    assert "shared.body.leg" in sys.modules or __import__("shared.body.leg")
    assert core.use_core() is False
    assert sys.path == before


def test_show_and_remove_touch_cores_only(compiled_home, tmp_path, monkeypatch, run):
    home = tmp_path / "home"
    shutil.copytree(next(compiled_home.iterdir()), home / next(compiled_home.iterdir()).name)
    (home / "letters").mkdir()
    (home / "0123456789abcdef").mkdir()  # named like a core, but none
    monkeypatch.setenv(core.SWITCH, str(home))
    code, out, _ = run("core", "show", "--json")
    assert (code, json.loads(out)["compiled"]) == (0, True)
    with monkeypatch.context() as aside:
        aside.setenv(core.SWITCH, "source")
        assert "CARAMELO_CORE=source turns the compiled one off" in run("core", "show")[1]
    assert run("core", "remove", "--json")[:2] == (0, '{"compiled": false, "folder": null}\n')
    assert sorted(path.name for path in home.iterdir()) == ["0123456789abcdef", "letters"]


def test_build_finds_what_is_there_and_drops_what_is_old(compiled_home, tmp_path, monkeypatch, run):
    home = tmp_path / "home"
    name = next(compiled_home.iterdir()).name
    for kept in (name, "fedcba9876543210"):
        shutil.copytree(compiled_home / name, home / kept)
    monkeypatch.setenv(core.SWITCH, str(home))
    code, out, _ = run("core", "build")
    assert code == 0
    assert f"the core runs as machine code, from {home / name}" in out
    assert [path.name for path in home.iterdir()] == [name]


def test_source_only_is_wrong_use_of_build_and_remove(monkeypatch, run):
    monkeypatch.setenv(core.SWITCH, "source")
    for command in ("build", "remove"):
        code, _, err = run("core", command)
        assert code == 2
        assert "CARAMELO_CORE=source turns the compiled core off" in err


def test_what_is_missing_says_what_to_install(tmp_path, monkeypatch, run):
    monkeypatch.setenv(core.SWITCH, str(tmp_path))
    monkeypatch.setenv("CC", "no-such-compiler -O2")
    code, _, err = run("core", "build")
    assert code == 2
    assert "there is no C compiler no-such-compiler: install one, on Debian apt-get install gcc python3-dev" in err
    assert list(tmp_path.iterdir()) == []


def test_a_compiler_that_fails_leaves_nothing_behind(tmp_path, monkeypatch):
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\necho 'error: on purpose' >&2\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    monkeypatch.setattr(native_core, "_is_compiled", lambda module: module.name == "shared.num.fixed")
    with pytest.raises(UserError, match=r"compiling the core failed: .*error") as told:
        native_core.build_core(tmp_path / "home" / "core")
    assert told.value.exit_code == NOT_ACHIEVED
    assert list((tmp_path / "home").iterdir()) == []


def test_it_is_on_the_disk_before_it_has_its_name(tmp_path, monkeypatch):
    """A process that loads machine code which a power cut has cut off dies of a bus error."""
    target, there = tmp_path / "core", []
    monkeypatch.setattr(native_core, "_write_typed", lambda *_: [])
    monkeypatch.setattr(native_core, "_run_mypyc", lambda *_: None)
    monkeypatch.setattr(os, "sync", lambda: there.append(target.exists()))
    native_core.build_core(target)
    assert there == [False]
    assert target.is_dir()


def typed_text(root: Path, text: str) -> str:
    """Return what becomes of a module that holds ``text``."""
    (root / "shared").mkdir(parents=True)
    head = '"""One."""\n\nfrom .runtime import const, hot, ptr16, ptr32, table\n\n'
    (root / "shared" / "one.py").write_text(head + text)
    modules = read_modules(root, ("shared",))
    return typed_modules(modules)["shared.one"].decode()


def test_marks_become_types_and_no_line_moves(tmp_path):
    text = (
        "_TWO = const(2)\nT = table((1, 2))\n\n\n@hot\ndef one(params, frame, other, n: int) -> int:\n"
        '    """Return it."""\n    p = ptr32(params)\n    f = ptr16(frame)\n    t = ptr16(T)\n'
        "    x = p[0] + f[0] + t[_TWO]\n    two(other, x)\n    return x\n\n\n"
        "@hot\ndef two(block, n: int) -> None:\n    for i in range(n):\n        n += i\n"
    )
    with pytest.raises(BuildError, match=r"shared/one.py:22: .*needs a docstring"):
        typed_text(tmp_path / "a", text)
    text = text.replace("    for i", '    """Add up."""\n    for i')
    found = typed_text(tmp_path / "b", text).splitlines()
    assert found[0] == '"""One."""; from typing import Any; from mypy_extensions import i64'
    assert found[8:11] == [
        "",
        "def one(params: Any, frame: Any, other: Any, n: i64) -> i64:",
        '    """Return it."""; f: Any; p: Any; t: Any; x: i64',
    ]
    assert found[14] == "    x = p[0] + f[0] + t[2]"
    assert found[20:22] == ["def two(block: Any, n: i64) -> None:", '    """Add up."""; i: i64']
    assert len(found) == len(text.splitlines()) + 4
