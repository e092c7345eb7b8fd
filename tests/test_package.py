"""What is packed: a wheel and an sdist hold everything below one name, and run where there is nothing else."""

import ast
import os
import runpy
import shutil
import signal
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from importlib.metadata import version

import pytest
import setuptools

from tests import ROOT
from tests.host.lab.workers.standing import standing
from tests.waiting import PATIENCE_S

FOLDERS = ("host", "shared", "sim2d", "firmware")
PACKED = ("caramelo", *FOLDERS)
BESIDE = (".ci", "docs", "examples", "tests")  # in an sdist
BUILD = "from setuptools import build_meta as build; print(build.{what}({folder!r}))"


@pytest.fixture(scope="module")
def setup_file():
    """Return what setup.py defines, without building anything."""
    kept, setuptools.setup = setuptools.setup, lambda **arguments: None
    here = os.getcwd()
    try:
        os.chdir(ROOT)
        return runpy.run_path("setup.py")
    finally:
        setuptools.setup = kept
        os.chdir(here)


def build(what, source, folder):
    """Build a wheel or an sdist of a source folder and return its path."""
    done = subprocess.run([sys.executable, "-c", BUILD.format(what=what, folder=str(folder))], cwd=source,
                          capture_output=True, text=True, timeout=600)  # fmt: skip
    assert done.returncode == 0, done.stderr
    return folder / done.stdout.split()[-1]


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    """Return a copy of the checkout."""
    folder = tmp_path_factory.mktemp("source")
    for name in (*PACKED, *BESIDE):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__", "*.so"))
    for path in ROOT.iterdir():
        if path.is_file() and path.name not in (".git", ".gitignore"):
            shutil.copy(path, folder)
    return folder


@pytest.fixture(scope="module")
def wheel(source, tmp_path_factory):
    return build("build_wheel", source, tmp_path_factory.mktemp("wheel"))


def files(folder):
    """Return the files of a folder, but for what a build leaves there."""
    paths = (path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    return {str(path) for path in paths if path.parts[0] != "build" and not path.parts[0].endswith(".egg-info")}


def names(wheel):
    with zipfile.ZipFile(wheel) as held:
        return set(held.namelist())


def test_a_wheel_has_every_file_below_one_name(wheel, source):
    wanted = {path.relative_to(source).as_posix() for name in FOLDERS for path in (source / name).rglob("*")
              if path.is_file()}  # fmt: skip
    held = names(wheel)
    tops = {name.partition("/")[0] for name in held}
    assert tops == {"caramelo", f"caramelo_robot-{version('caramelo-robot')}.dist-info"}
    assert "host/teleop/service/caramelo.service" in wanted
    assert {f"caramelo/{name}" for name in wanted} - held == set()
    assert {"caramelo/__init__.py", "caramelo/names.py", "caramelo/py.typed"} <= held


def test_nothing_in_a_wheel_imports_a_name_that_is_not_its_own(wheel):
    wrong = []
    with zipfile.ZipFile(wheel) as held:
        for name in held.namelist():
            if name.endswith(".py") and "/parity/probe/" not in name:
                for node in ast.walk(ast.parse(held.read(name))):
                    if isinstance(node, ast.ImportFrom) and not node.level:
                        wrong += [name] * ((node.module or "").partition(".")[0] in FOLDERS)
    assert wrong == []


def test_an_sdist_makes_the_same_wheel(wheel, source, tmp_path):
    with tarfile.open(build("build_sdist", source, tmp_path)) as held:
        held.extractall(tmp_path / "unpacked", filter="data")
    (unpacked,) = (tmp_path / "unpacked").iterdir()
    assert files(source) - files(unpacked) == set(), "it is the checkout"
    assert names(build("build_wheel", unpacked, tmp_path)) == names(wheel)


@pytest.mark.parametrize(
    ("text", "becomes"),
    [
        ("from shared.num import fixed\n", "from caramelo.shared.num import fixed\n"),
        ("def f():\n    from host import NAME  # é\n", "def f():\n    from caramelo.host import NAME  # é\n"),
        ("from ..num import fixed\n", "from ..num import fixed\n"),
        ("from shareds import x\nimport host_only\n", "from shareds import x\nimport host_only\n"),
        ("X = '''\nfrom shared.num import fixed\n'''\n", "X = '''\nfrom shared.num import fixed\n'''\n"),
    ],
)
def test_imports_are_renamed_and_nothing_else(setup_file, text, becomes):
    assert setup_file["renamed"](text, "one.py") == becomes


def test_an_import_that_cannot_be_renamed_is_refused(setup_file):
    with pytest.raises(SystemExit, match=r"one.py:2: write `from ... import ...`"):
        setup_file["renamed"]("x = 1\nimport shared.num\n", "one.py")


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """Return an empty folder, but for one `shared` of its own, and a function that runs there what was installed.

    The libraries are those of the tests, the project's checkout is not to be seen.
    """
    home = tmp_path_factory.mktemp("installed")
    install(wheel, home)
    empty = home / "empty"
    (empty / "shared").mkdir(parents=True)
    (empty / "shared/__init__.py").write_text("MINE = 'my own'\n")

    def call(*command):
        kept = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "CARAMELO_CORE")}
        done = subprocess.run([home / "venv/bin" / command[0], *command[1:]], cwd=empty, env=kept, capture_output=True,
                              text=True, timeout=600)  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    call.programs = home / "venv/bin"
    return call


def install(wheel, home):
    """Install the wheel into an environment of its own, ``home``/venv, with the libraries of the tests."""
    venv.create(home / "venv", with_pip=True)
    places = sysconfig.get_paths(vars={"base": str(home / "venv"), "platbase": str(home / "venv")})
    with open(f"{places['purelib']}/libraries.pth", "w") as file:
        file.write(sysconfig.get_path("purelib") + "\n")
    subprocess.run([home / "venv/bin/python", "-m", "pip", "install", "--quiet", "--no-deps", "--no-index", wheel],
                   check=True, timeout=600)  # fmt: skip


DECOY = """
import sys, caramelo, shared
from caramelo import Robot, robot_names
assert "site-packages" in caramelo.__file__, caramelo.__file__
print(shared.MINE, *robot_names(), *sorted({name.partition(".")[0] for name in sys.modules} & set(%r)))
"""


@pytest.mark.slow
def test_it_runs_beside_a_folder_of_the_same_name(installed):
    out = installed("python", "-c", DECOY % (FOLDERS,))
    assert out.startswith("my own caramelo ")
    assert out.split()[-1] == "shared", "of the four names only the user's own is taken"


@pytest.mark.slow
def test_the_command_walks_from_an_empty_folder(installed):
    assert installed("caramelo", "--version").strip() == version("caramelo-robot")
    assert '"ok": true' in installed("caramelo", "walk", "--distance", "0.2", "--json")
    assert '"failure": ""' in installed("caramelo", "teleop", "--sim", "--measure", "2", "--json")


@pytest.mark.slow
def test_an_example_runs_with_what_is_installed(installed):
    assert installed("python", str(ROOT / "examples/first_walk.py")).startswith("x 0.1")


@pytest.mark.slow
def test_workers_of_another_environment_give_the_figures_of_one_process(installed, wheel, tmp_path):
    """Workers of a second environment; one dies half-way. A checkout's workers are told apart from a wheel's."""
    pytest.importorskip("distributed", reason="dask.distributed is not installed (extra lab)")
    install(wheel, tmp_path)
    table = ("caramelo", "experiment", "table1", "--trials", "20", "--json")
    with standing(tmp_path / "cluster", python=str(tmp_path / "venv/bin/python")) as cluster:
        workers = [cluster.worker() for _ in range(2)]
        there = installed(*table, "--cluster", cluster.address)
        command = [installed.programs / table[0], *table[1:], "--cluster", cluster.address]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        with subprocess.Popen(command, cwd=tmp_path, **pipes) as client:
            for line in client.stderr:
                if ": 40 of 80" in line:
                    workers[0].kill()
            with_a_loss = client.stdout.read()
        assert workers[0].wait(PATIENCE_S) == -signal.SIGKILL
        here = subprocess.run([sys.executable, "-m", "host", *table[1:], "--cluster", cluster.address], cwd=ROOT,
                              capture_output=True, text=True, timeout=PATIENCE_S)
    assert there == with_a_loss == installed(*table)
    assert "no caramelo like this one" in here.stderr


BOARD = """
import hashlib, pathlib, tempfile
from {host}.boards.build.frozen import frozen_sources
with tempfile.TemporaryDirectory() as folder:
    out = pathlib.Path(folder, "out")
    frozen_sources("joint", "caramelo", out)
    files = [path for path in sorted(out.rglob("*")) if path.is_file()]
    print(len(files), hashlib.sha256(b"".join(path.read_bytes() for path in files)).hexdigest())
"""


@pytest.mark.slow
def test_boards_get_the_same_from_a_wheel_as_from_a_checkout(installed):
    ours = subprocess.run([sys.executable, "-c", BOARD.format(host="host")], cwd=ROOT, capture_output=True, text=True)
    assert int(ours.stdout.split()[0]) > 50
    assert installed("python", "-c", BOARD.format(host="caramelo.host")) == ours.stdout


@pytest.mark.slow
def test_a_wheel_for_this_machine_has_the_core_compiled(source, tmp_path, monkeypatch):
    """It is found by what it was made of, so it is used as long as it fits the sources beside it."""
    from host.boards.build.native_core import why_not

    if why_not():
        pytest.skip(str(why_not()))
    monkeypatch.setenv("CARAMELO_WHEEL", "compiled")
    made = build("build_wheel", source, tmp_path)
    assert f"cp{sys.version_info.major}{sys.version_info.minor}" in made.name
    with zipfile.ZipFile(made) as held:
        held.extractall(tmp_path / "unpacked")
    script = "from caramelo import Robot; import caramelo.shared.body.leg as leg; print(leg.__file__)"
    environment = {name: value for name, value in os.environ.items() if name != "CARAMELO_CORE"}
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path / "unpacked", env=environment,
                          capture_output=True, text=True, check=True)  # fmt: skip
    assert "/caramelo/cores/" in done.stdout
    assert done.stdout.strip().endswith(".so")


@pytest.mark.slow
def test_what_is_typed_is_seen_by_a_type_checker(installed):
    out = installed("python", "-m", "mypy", "--strict", "--cache-dir=/dev/null", "-c",
                    "from caramelo import Robot; x: float = Robot().odometry.x_m; Robot().turn(deg=1.0)")  # fmt: skip
    assert "Success" in out
