"""The set-up on a fresh machine: locked versions and hashes of everything, make targets that fail when they should."""

import os
import re
import runpy
import signal
import subprocess
import sys
import threading
import tomllib
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, requires
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests import ROOT
from tests.waiting import PATIENCE_S, wait_until

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
LOCK = (ROOT / "constraints.txt").read_text()


def locked_names(text: str) -> set[str]:
    """Return the names of the packages with exactly one version each per environment, and the hashes of its files."""
    names = set()
    wanted = re.compile(r"[A-Za-z0-9._-]+==[A-Za-z0-9.!+-]+( ; [^#]+?)?( --hash=sha256:[0-9a-f]{64})+")
    for line in re.sub(r" \\\n +", " ", text).splitlines():
        if line.strip() and not line.lstrip().startswith("#"):
            assert wanted.fullmatch(line), line
            names.add(canonicalize_name(line.partition("==")[0]))
    return names


def wanted_packages(extras: Iterable[str] = PROJECT["optional-dependencies"]) -> list[Requirement]:
    """Return every requirement of pyproject.toml with these extras, all of them if none are named."""
    lists = [PROJECT["dependencies"], *(PROJECT["optional-dependencies"][extra] for extra in extras)]
    return [Requirement(line) for lines in lists for line in lines]


def test_every_direct_dependency_is_locked():
    assert {canonicalize_name(wanted.name) for wanted in wanted_packages()} <= locked_names(LOCK)


@pytest.mark.parametrize("line", ["numpy==2.0 --hash=md5:0", "numpy==2.0", "numpy>=2.0 --hash=sha256:" + 64 * "0"])
def test_a_package_without_version_or_hash_is_found(line):
    with pytest.raises(AssertionError):
        locked_names(f"{LOCK}\n{line}\n")


@pytest.fixture(scope="module")
def picked():
    """Return the function that picks from the lock what some extras need."""
    return runpy.run_path(str(ROOT / ".ci/requirements.py"))["requirements"]


@pytest.mark.parametrize(
    "extras",
    ["", "web,record,pi", "sim,space,lab,web,record,foxglove,firmware,docs,test", "compile", "emulator", "lock"],
)
def test_what_is_installed_has_all_that_it_needs_and_comes_with_hashes(picked, extras):
    extras = extras.split(",") if extras else []
    text = picked(LOCK, extras)
    names = locked_names(text)
    check_closed(wanted_packages(extras), names)
    assert canonicalize_name("setuptools") in names, "the project itself is built without asking a package index"
    assert set(text.splitlines()) <= set(LOCK.splitlines())


def test_a_pi_gets_nothing_for_simulator_and_tests(picked):
    names = locked_names(picked(LOCK, ["web", "record", "pi"]))
    tests = {"pytest", "hypothesis", "ruff", "mypy"}
    assert names.isdisjoint({"pymunk", "matplotlib", "scipy", "mujoco", "uv", "cma"} | tests)


def test_an_extra_that_does_not_exist_is_named(picked):
    with pytest.raises(SystemExit, match=r"EXTRAS: there is no wbe: there are compile, "):
        picked(LOCK, ["wbe"])


def test_whatever_is_built_is_built_with_the_locked_setuptools():
    (build,) = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]["requires"]
    assert f"\n{build} \\\n" in LOCK


def test_make_setup_takes_nothing_without_a_hash(tmp_path):
    done = make("--dry-run", "setup", f"STAMP={tmp_path / 'no-stamp'}")
    installs = [line for line in done.stdout.splitlines() if "pip install" in line]
    assert len(installs) == 2
    assert "--require-hashes" in installs[0]
    assert "--constraint" not in done.stdout
    assert installs[1].endswith("--no-deps --no-build-isolation --editable .")


def test_what_the_dependencies_need_is_locked_too():
    check_closed(wanted_packages(), locked_names(LOCK))


def check_closed(queue: list[Requirement], names: set[str]) -> None:
    """Check that what the packages need, as far as they are installed here, is among the names."""
    seen: set[tuple[str, frozenset[str]]] = set()
    while queue:
        wanted = queue.pop()
        name = canonicalize_name(wanted.name)
        extras = wanted.extras or {""}
        if wanted.marker and not any(wanted.marker.evaluate({"extra": extra}) for extra in extras):
            continue
        if (name, frozenset(extras)) in seen:
            continue
        seen.add((name, frozenset(extras)))
        assert name in names, name
        try:
            below = [Requirement(line) for line in requires(wanted.name) or []]
        except PackageNotFoundError:
            continue  # an extra that this environment was made without
        queue += [need for need in below if not need.marker or any(need.marker.evaluate({"extra": e}) for e in extras)]
    assert seen


def addresses(text: str) -> list[str]:
    """Return what a lock file must not hold: addresses, index options, paths."""
    return re.findall(r"\S*://\S*|(?<!\S)--?[a-z][a-z-]*(?= )|@ \S+|/\S+/\S+", text)


def test_the_lock_names_no_host():
    assert addresses(LOCK) == []


@pytest.mark.parametrize(
    "line",
    ["--index-url https://mirror.example/simple", "numpy @ file:///wheels/numpy.whl", "--find-links wheels"],
)
def test_an_address_in_the_lock_is_found(line):
    assert addresses(LOCK + line)


def make(*arguments: str) -> subprocess.CompletedProcess[str]:
    """Run make in the project's folder."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS"))}
    return subprocess.run(["make", *arguments], cwd=ROOT, capture_output=True, text=True, check=False, env=kept)


# A fake tool that is the environment's Python: it runs what runs the others.
FAKE = f'#!/bin/sh\ncase $1 in .ci/test.py) exec {sys.executable} "$@";; esac\n'


def fake_tools(folder: Path, **exit_codes: int) -> list[str]:
    """Write ruff, mypy and pytest that only leave with a code; return make's arguments to use them.

    Once there is an environment, no other Python is used: the machine's may be too old.
    """
    for name, code in exit_codes.items():
        (folder / name).write_text(f"{FAKE}echo ran {name}\nexit {code}\n")
        (folder / name).chmod(0o755)
    (folder / "stamp").write_text("")
    return [f"BIN={folder}", f"STAMP={folder / 'stamp'}", "PYTHON=false"]


PARTS = {"ruff": "ruff", "mypy": "mypy", "pytest": "sources others", "python": "core"}  # as make test names them


@pytest.mark.parametrize("fails", [None, *PARTS])
def test_make_test_fails_if_any_of_its_parts_does(tmp_path, fails):
    done = make("test", *fake_tools(tmp_path, **{name: int(name == fails) for name in PARTS}))
    assert [done.stdout.count(f"ran {name}") for name in ("ruff", "mypy", "pytest")] == [1, 1, 2]
    assert (done.returncode == 0) == (fails is None)
    assert (f"make test: failed: {PARTS.get(fails)}\n" in done.stderr) == (fails is not None)


@pytest.mark.parametrize("fails_in", ["source", "cores"])
def test_the_tests_of_the_sources_run_from_them_and_all_others_by_the_compiled_core(tmp_path, fails_in):
    tools = fake_tools(tmp_path, ruff=0, mypy=0, pytest=0, python=0)
    (tmp_path / "python").write_text(f"{FAKE}echo cores\n")
    (tmp_path / "pytest").write_text(f'#!/bin/sh\necho "$CARAMELO_CORE: $@"\ntest "$CARAMELO_CORE" != {fails_in}\n')
    done = make("test", *tools, "JOBS=2")
    of_sources, others = (line for line in done.stdout.splitlines() if ": -n 2" in line)
    assert of_sources.startswith("source: ")
    assert others.startswith("cores: ")
    ignored = {word.removeprefix("--ignore=") for word in others.split() if word.startswith("--ignore=")}
    assert ignored == {word for word in of_sources.split() if word.startswith("tests/")}
    assert not [word for word in others.split() if word.startswith("tests/")], "all the rest"
    assert all((ROOT / path).exists() for path in ignored)
    assert f"make test: failed: {'sources' if fails_in == 'source' else 'others'}\n" in done.stderr


def test_make_test_ended_half_way_leaves_nothing_running(tmp_path):
    runs = tmp_path / "runs"
    runs.mkdir()
    fake_tools(tmp_path, ruff=0, mypy=0, pytest=0, python=0)
    (tmp_path / "pytest").write_text(f"#!/bin/sh\n: >{runs}/$$\nexec sleep 600\n")
    with subprocess.Popen([sys.executable, ROOT / ".ci/test.py", tmp_path, "2"], stdout=subprocess.DEVNULL) as running:
        wait_until(lambda: len(list(runs.iterdir())) == 2, "both runs of tests go on")
        running.terminate()
        assert running.wait(PATIENCE_S) == 130
    for run in runs.iterdir():
        with pytest.raises(ProcessLookupError):
            os.kill(int(run.name), 0)


def test_make_test_ended_while_it_starts_a_run_ends_that_run_too(monkeypatch):
    started = runpy.run_path(str(ROOT / ".ci/test.py"))["started"]
    begun, popen = [], subprocess.Popen

    def ended_meanwhile(*arguments, **options):
        begun.append(popen(*arguments, **options))
        # To this thread, the only one of `make test`. Another that runs beside a test takes what this one holds back.
        signal.pthread_kill(threading.get_ident(), signal.SIGTERM)
        return begun[-1]

    monkeypatch.setattr(subprocess, "Popen", ended_meanwhile)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), started(("sleep", "600")):
            pass
        assert begun[0].poll() == -signal.SIGTERM
    finally:
        signal.signal(signal.SIGTERM, before)
        begun[0].kill()


@pytest.mark.parametrize(("has_mujoco", "world"), [(True, "space"), (False, "plane")])
def test_make_demo_walks_up_stairs_where_it_can(tmp_path, has_mujoco, world):
    tools = fake_tools(tmp_path, caramelo=0, python=0)
    (tmp_path / "caramelo").write_text('#!/bin/sh\necho "$@"\n')
    (tmp_path / "python").write_text(f"#!/bin/sh\nexit {0 if has_mujoco else 1}\n")
    done = make("demo", *tools)
    shown = done.stdout.splitlines()[-1]
    assert shown.startswith(f"walk --in {world} --speed 0.15 --terrain stairs-up")
    assert shown.endswith("--out out/demo")


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("case $1 in -V) echo Python 3.9.2;; *) exit 1;; esac", "Python 3.9.2 is too old: 3.11 or newer is needed"),
        ('case "$2" in *ensurepip*) exit 1;; esac', "comes without its venv module: on Debian, apt-get install"),
        (None, "not found: install Python 3.11 or newer"),
    ],
)
def test_make_setup_says_in_one_line_what_is_missing(tmp_path, answer, words):
    python = tmp_path / "python"
    if answer is not None:
        python.write_text(f"#!/bin/sh\n{answer}\n")
        python.chmod(0o755)
    done = make("setup", f"PYTHON={python}", f"STAMP={tmp_path / 'no-stamp'}")
    assert done.returncode != 0
    ours = [line for line in done.stderr.splitlines() if line.startswith("make setup: ")]
    assert len(ours) == 1
    assert words in ours[0]
    assert not (tmp_path / "no-stamp").exists()


def test_ci_runs_the_tests():
    path = ROOT / ".ci/run"
    assert os.access(path, os.X_OK)
    assert path.read_text().rstrip().endswith("\nmake test")


@pytest.mark.parametrize(
    ("changed", "tests"),
    [
        ("host/bus/can/adapter.py", ["tests/host/bus/can/test_adapter.py"]),
        ("shared/joint/encoder.py", ["tests/shared/joint/test_encoder.py"]),
        ("shared/gait/swing.py", ["tests/shared/test_swing.py"]),
        ("tests/sim2d/test_run.py", ["tests/sim2d/test_run.py"]),
        ("docs/gaits.md", ["tests/test_docs.py"]),
        ("Makefile", ["tests/test_setup.py"]),
    ],
)
def test_make_check_runs_what_lies_beside_a_change(changed, tests):
    beside = runpy.run_path(str(ROOT / ".ci/touched.py"))["beside"]
    assert beside(changed) == tests


def test_make_check_runs_a_folders_tests_for_a_file_without_its_own():
    beside = runpy.run_path(str(ROOT / ".ci/touched.py"))["beside"]
    own = sorted(path.relative_to(ROOT).as_posix() for path in (ROOT / "tests/host/teleop").glob("test_*.py"))
    assert beside("host/teleop/session.py") == beside("tests/host/teleop/hanging.py") == own
    assert beside("host/commands/walk.py") == [
        path.relative_to(ROOT).as_posix() for path in sorted((ROOT / "tests/host").glob("test_*.py"))
    ]


def test_make_renew_writes_all_that_is_generated(tmp_path):
    done = make("--dry-run", "renew", *fake_tools(tmp_path))
    for what in ("boards.build.tables", "host.protocol.generate", "boards.build.sizes", "bench --update-budget"):
        assert what in done.stdout
