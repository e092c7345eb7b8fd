"""What is packed: a wheel has everything below the one name `caramelo`, and what it imports is renamed on the way.

In a checkout the folders are packages of their own, as on a board, and so they are after `pip install --editable`.
With CARAMELO_WHEEL=compiled in the environment the wheel also has the core compiled, for this Python and machine alone.
"""

import ast
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

from setuptools import Distribution, find_packages, setup
from setuptools.command.build_py import build_py

NAME = "caramelo"
FOLDERS = ("host", "shared", "sim2d", "firmware")
DATA = {
    "caramelo": ["py.typed"],
    "host": [f"**/*.{ending}" for ending in ("toml", "dbc", "html", "json", "js", "css", "svg", "service", "h")],
    "firmware": [f"**/*.{ending}" for ending in ("h", "c", "ld", "mk", "csv")],
    "shared": ["*.pyi"],
    "sim2d": ["**/*.html"],
}
ONLY_FOR_VMS = "host/lab/parity/probe/"  # is copied to where the folders are packages of their own
EDITABLE = "editable_wheel" in sys.argv
COMPILED = os.environ.get("CARAMELO_WHEEL") == "compiled" and "bdist_wheel" in sys.argv
COMPILE = """
from caramelo.host.boards.build.native_core import build_core
from caramelo.host.boards.core import PACKED, sources_id
build_core(PACKED / sources_id())
"""


def renamed(text: str, file: str) -> str:
    """Return a module's source with what it imports from the four folders named below ``caramelo``."""
    lines = text.encode().splitlines(keepends=True)
    for node in ast.walk(ast.parse(text, file)):
        if isinstance(node, ast.Import) and any(alias.name.partition(".")[0] in FOLDERS for alias in node.names):
            raise SystemExit(f"{file}:{node.lineno}: write `from ... import ...`: setup.py renames only those")
        if isinstance(node, ast.ImportFrom) and not node.level and (node.module or "").partition(".")[0] in FOLDERS:
            at, line = node.col_offset + len("from "), lines[node.lineno - 1]
            lines[node.lineno - 1] = line[:at] + f"{NAME}.".encode() + line[at:]
    return b"".join(lines).decode()


class ForThisMachine(Distribution):
    """Says whether the wheel has machine code."""

    def has_ext_modules(self) -> bool:
        """See setuptools."""
        return COMPILED


class Below(build_py):
    """Builds as usual, but for the imports, and compiles the core if that was asked for."""

    def run(self) -> None:
        """See setuptools."""
        if not self.editable_mode:
            shutil.rmtree(self.build_lib, ignore_errors=True)  # else a wheel has what an earlier one had, too
        super().run()
        if COMPILED:
            subprocess.run([sys.executable, "-c", COMPILE], cwd=self.build_lib, check=True)

    def build_module(self, module: Any, module_file: Any, package: Any) -> Any:
        """See setuptools."""
        done = super().build_module(module, module_file, package)
        if not self.editable_mode and not str(module_file).startswith(ONLY_FOR_VMS):
            built = Path(self.get_module_outfile(self.build_lib, package.split("."), module))
            built.write_text(renamed(built.read_text(), str(module_file)))
        return done


folders = find_packages(include=[pattern for folder in FOLDERS for pattern in (folder, f"{folder}.*")])
above = "" if EDITABLE else f"{NAME}."
setup(
    packages=[NAME, *(above + folder for folder in folders)],
    package_dir={} if EDITABLE else {above + folder: folder for folder in FOLDERS},
    package_data={key if key == NAME else above + key: patterns for key, patterns in DATA.items()},
    cmdclass={"build_py": Below},
    distclass=ForThisMachine,
)
