"""Prints the tests of what has been changed: since the last commit, or by it if nothing has been changed since.

Tests lie as what they test: those of host/bus/can/link.py are tests/host/bus/can/test_link.py, or one of that name in
a folder above, or else all in that folder.
"""

import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
ALWAYS = ("tests/test_layout.py", "tests/test_waiting.py")
OF_A_DOC, OF_THE_REST = "tests/test_docs.py", "tests/test_setup.py"
CODE = ("host", "shared", "firmware", "sim2d", "caramelo", "examples")


def changed() -> list[str]:
    """Return the changed files, from the project's folder."""
    git = ["git", "-C", str(ROOT)]
    status = subprocess.run([*git, "status", "--porcelain", "-uall"], capture_output=True, text=True, check=True).stdout
    if status:
        return [line[3:].split(" -> ")[-1] for line in status.splitlines()]
    command = [*git, "show", "--name-only", "--format=", "HEAD"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()


def beside(name: str, root: Path = ROOT) -> list[str]:
    """Return the test files of a file: its own, or those of the nearest folder that has some."""
    path = Path(name)
    if path.parts[0] not in (*CODE, "tests"):
        return [OF_A_DOC if path.suffix == ".md" else OF_THE_REST]
    inside = path.parent if path.parts[0] == "tests" else Path("tests", path.parent)
    own = path.name if path.name.startswith("test_") else f"test_{path.stem}.py"
    for folder in (inside, *inside.parents[:-2]):  # those of tests/ itself are of the whole project
        if (root / folder / own).exists():
            return [str(folder / own)]
    while not list((root / inside).glob("test_*.py")):
        inside = inside.parent
    return [str(inside / each.name) for each in sorted((root / inside).glob("test_*.py"))]


def touched(names: list[str], root: Path = ROOT) -> list[str]:
    """Return the tests of the files, each once."""
    return sorted({*ALWAYS, *(each for name in names for each in beside(name, root))})


if __name__ == "__main__":
    print(" ".join(touched(changed())))
