"""The core as a tree of ``.mpy`` files for a MicroPython VM. What a board gets is frozen into its image: frozen.py."""

from pathlib import Path

from .compiler import compile_text
from .lower import lowered_modules
from .rewrite import rewrite


def compile_tree(root: Path, emitter: str, arch: str, packages: tuple[str, ...]) -> dict[str, bytes]:
    """Return the compiled modules under ``root`` by path. BuildError names file, line and rule.

    The same sources give the same bytes: no times, no paths of this machine.
    """
    modules = lowered_modules(root, packages)
    files: dict[str, bytes] = {}
    for module in modules.values():
        text = rewrite(module, modules, emitter, arch)
        files[module.path.removesuffix(".py") + ".mpy"] = compile_text(text, module.path, emitter, arch)
    return files


def write_tree(files: dict[str, bytes], out: Path) -> None:
    """Write files below a folder by their paths."""
    for path, data in files.items():
        (out / path).parent.mkdir(parents=True, exist_ok=True)
        (out / path).write_bytes(data)
