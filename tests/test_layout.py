"""Which folder may import which: parsed from every file, so that an import inside a function counts too."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests import ROOT

FOLDERS = ("shared", "firmware", "sim2d", "host", "caramelo", "tests")
# A folder may import itself and these.
MAY_IMPORT = {
    "shared": (),
    "firmware": ("shared",),
    "sim2d": ("shared",),
    "host": ("shared", "sim2d", "firmware"),
    "caramelo": ("host", "shared"),
    "tests": ("shared", "firmware", "sim2d", "host", "caramelo"),
}
# What a MicroPython board has; the core needs one of them.
BOARD_MODULES = {
    "array", "binascii", "collections", "errno", "gc", "hashlib", "io", "json", "machine", "math", "micropython",
    "os", "pyb", "random", "select", "stm", "struct", "sys", "time", "uctypes", "vfs",
}  # fmt: skip
OUTSIDE = {"shared": {"array", "sys", "_core"}, "firmware": BOARD_MODULES}  # _core: hot functions in C


def imports(path: Path, root: Path) -> Iterator[str]:
    """Yield the dotted names that a file imports, relative ones made absolute; ``?`` for a computed one."""
    package = path.relative_to(root).parent.parts
    for node in ast.walk(ast.parse(path.read_text(), path.name)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package[: len(package) - node.level + 1] if node.level else ()
            base = ".".join((*above, *filter(None, [node.module])))
            yield from (f"{base}.{alias.name}" if base else alias.name for alias in node.names)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "__import__":
            yield "?"


def forbidden_imports(root: Path) -> list[str]:
    """Return ``file: import`` for every import that a folder may not make."""
    wrong = []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            for name in imports(path, root):
                top = name.partition(".")[0]
                inside = top in FOLDERS
                allowed = top == folder or top in MAY_IMPORT[folder] if inside else top in OUTSIDE.get(folder, {top})
                if not allowed:
                    wrong.append(f"{path.relative_to(root)}: {name}")
    return wrong


def test_imports_run_one_way():
    assert forbidden_imports(ROOT) == []


# The packages of the core, in the order of their imports: each imports itself and those above it.
CORE = ("runtime", "record", "num", "body", "sense", "gait", "trot", "crawl", "planner", "wire", "joint")
_ROBOT = ("body", "sense", "gait", "trot", "crawl", "planner")  # what a joint and the wire know nothing of
BESIDE = {
    "trot": ("crawl",),
    "crawl": ("trot",),
    "wire": _ROBOT,
    "joint": _ROBOT,
}


# The folders of the host, in the order of their imports. What drives a robot (all up to identify, and teleop) imports
# neither what stands in for hardware nor what measures: a robot needs neither.
HOST = ("util", "robot", "protocol", "bus", "imu", "control", "records", "identify", "boards", "sim", "teleop", "lab")
HOST = (*HOST, "library", "commands", "cli", "__main__")
ORDERS = {"shared": (CORE, BESIDE), "host": (HOST, {"teleop": ("sim",)})}
DRIVES = (*HOST[: HOST.index("boards")], "teleop", "library")


def against_the_order(root: Path, folder: str) -> list[str]:
    """Return ``file: import`` for every import in a folder that runs against the order of what is in it."""
    wrong = []
    order, beside = ORDERS[folder]
    for path in sorted((root / folder).rglob("*.py")):
        own = path.relative_to(root / folder).parts[0].removesuffix(".py")
        if own == "__init__":
            continue
        for name in imports(path, root):
            parts = name.split(".")
            if parts[0] != folder or parts[1:] in ([], ["ROOT"], ["NAME"]) or parts[1] == own:
                continue
            if parts[1] not in order[: order.index(own)] or parts[1] in beside.get(own, ()):
                wrong.append(f"{path.relative_to(root)}: {name}")
    return wrong


@pytest.mark.parametrize("folder", ORDERS)
def test_the_packages_of_a_folder_import_in_one_direction(folder):
    assert against_the_order(ROOT, folder) == []


@pytest.mark.parametrize(
    ("file", "line"),
    [
        ("shared/num/fixed.py", "from ..body.leg import leg_inverse"),
        ("shared/trot/sway.py", "from ..crawl.map import Map"),
        ("shared/crawl/map.py", "def f():\n    from shared.planner import planner"),
        ("shared/record.py", "from .num import fixed"),
        ("host/control/loop.py", "from ..records.log import LoopLog"),
        ("host/teleop/session.py", "def f():\n    from ..sim.bus import SimulatedBus"),
        ("host/util/files.py", "import host.robot.file"),
        ("host/sim/walk.py", "from ..lab import parity"),
    ],
)
def test_an_import_against_the_order_is_found(tmp_path, file, line):
    write(tmp_path, file, line)
    assert len(against_the_order(tmp_path, file.partition("/")[0])) == 1


IMPORT_ALL = """
import importlib, pathlib, sys

class Missing:
    def find_spec(self, name, *_):
        if name.split(".")[0] in LIBRARIES or name.split(".")[:2] in (["host", "sim"], ["host", "lab"]):
            raise ModuleNotFoundError(name + " is not on a robot", name=name)

LIBRARIES = ("pymunk", "matplotlib", "scipy", "msgpack", "mujoco")
sys.meta_path.insert(0, Missing())
for folder in sys.argv[1:]:
    for path in sorted(pathlib.Path("host", folder).rglob("*.py")):
        if path.stem not in ("__init__", "__main__"):
            importlib.import_module(".".join(path.with_suffix("").parts))
            print(path)
"""


def test_what_drives_a_robot_is_imported_without_the_simulators():
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL, *DRIVES], capture_output=True, text=True, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.split()) > 80
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL, "sim"], capture_output=True, text=True, cwd=ROOT)
    assert "is not on a robot" in done.stderr


def test_all_folders_are_looked_at():
    for folder in FOLDERS:
        assert list((ROOT / folder).rglob("*.py")), folder


def write(root: Path, file: str, text: str) -> None:
    """Write a file of a folder that looks like the project."""
    (root / file).parent.mkdir(parents=True)
    (root / file).write_text(text + "\n")


@pytest.mark.parametrize(
    ("file", "line", "name"),
    [
        ("shared/body/leg.py", "import math", "math"),
        ("shared/body/leg.py", "def f():\n    import time", "time"),
        ("shared/body/leg.py", "from host.robot.scale import brad", "host.robot.scale.brad"),
        ("shared/joint/svpwm.py", "from ... import host", "host"),
        ("shared/body/leg.py", "m = __import__('math')", "?"),
        ("firmware/main.py", "import numpy", "numpy"),
        ("firmware/main.py", "from host import cli", "host.cli"),
        ("firmware/boards/real.py", "from ...sim2d.world import World", "sim2d.world.World"),
        ("sim2d/run.py", "from host.robot.file import load_robot", "host.robot.file.load_robot"),
        ("sim2d/run.py", "import firmware.joint", "firmware.joint"),
        ("host/cli.py", "from tests import conftest", "tests.conftest"),
        ("host/cli.py", "from caramelo import Robot", "caramelo.Robot"),
        ("shared/body/leg.py", "from array import array\nfrom .fixed import isqrt", None),
        ("shared/joint/svpwm.py", "from ..fixed import isqrt", None),
        ("firmware/main.py", "import machine\nfrom shared.num.fixed import isqrt", None),
        ("sim2d/run.py", "import pymunk\nfrom shared.num.fixed import isqrt\nfrom .world import World", None),
        ("host/cli.py", "import numpy\nfrom sim2d import run\nfrom shared.body import leg", None),
        ("host/cli.py", "from firmware import joint", None),
        ("tests/test_x.py", "import host.cli\nimport hypothesis", None),
    ],
)
def test_an_import_the_wrong_way_is_found_and_no_other(tmp_path, file, line, name):
    write(tmp_path, file, line)
    assert forbidden_imports(tmp_path) == ([f"{file}: {name}"] if name else [])


def files_without_a_first_sentence(root: Path) -> list[str]:
    """Return the files with code whose first line does not say what they hold."""
    wrong = []
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*.py")):
            tree = ast.parse(path.read_text())
            if tree.body and not (ast.get_docstring(tree) or "").strip():
                wrong.append(str(path.relative_to(root)))
    return wrong


def test_every_file_says_first_what_it_holds():
    assert files_without_a_first_sentence(ROOT) == []


def test_a_file_that_says_nothing_is_found(tmp_path):
    write(tmp_path, "host/silent.py", "x = 1")
    assert files_without_a_first_sentence(tmp_path) == ["host/silent.py"]
