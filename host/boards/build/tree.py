"""The core as a tree of ``.mpy`` files for a MicroPython VM. What a board gets is frozen into its image: frozen.py."""

import hashlib
import json
from pathlib import Path

from ...util.errors import UserError
from ...util.files import write_text
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


def replace_tree(files: dict[str, bytes], out: Path) -> None:
    """Write files below a folder in place of those that were written so before, which a file beside it remembers.

    UserError, and nothing is touched, if anything else is there: it is not ours to remove.
    """
    list_path = out.with_name(f"{out.name}.json")
    ours = _remembered(list_path)
    there = [path for path in sorted(out.rglob("*")) if not path.is_dir() or path.is_symlink()]
    for path in there:
        if path.is_symlink() or _hash(path.read_bytes()) not in ours.get(path.relative_to(out).as_posix(), []):
            raise UserError(f"{path}: is not as a build has left it: move {out} away, or name another folder")
    new = {path: [*ours.get(path, []), _hash(data)] for path, data in files.items()}
    write_text(list_path, json.dumps(ours | new, indent=1) + "\n")  # first: a build that is cut off stays ours
    for path in there:
        path.unlink()
    write_tree(files, out)
    write_text(list_path, json.dumps({path: [_hash(data)] for path, data in files.items()}, indent=1) + "\n")


def _remembered(path: Path) -> dict[str, list[str]]:
    """Return the hashes of the files of the last build by path; none if there was no build or it is no list."""
    try:
        ours = json.loads(path.read_bytes())
    except (OSError, ValueError):
        return {}
    return ours if isinstance(ours, dict) else {}


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()
