"""A tree of files ready to copy to a board, with a manifest that names every byte of it.

The same sources give the same bytes: no times, no paths of this machine, files in one order.
"""

import hashlib
import json
import os
import shutil
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from .compiler import compile_text, compiler_version
from .rewrite import rewrite
from .source import BuildError, Module, closure, read_modules

MANIFEST = "manifest.json"
PROTOCOL = "PROTOCOL_HASH"
# These lie at the board's root, outside the slots of firmware, as source: MicroPython starts the first two so only.
START_FILES = ("firmware/boot.py", "firmware/main.py", "firmware/slots.py")

# What each kind of board starts from; everything these import comes along.
ROLES: dict[str, tuple[str, ...]] = {
    "joint": ("firmware/joint", "firmware/start_joint", "firmware/selftest", "shared/joint/", "shared/wire/"),
    "gait": ("firmware/gait", "firmware/start_gait", "firmware/selftest", "shared/planner.py"),
}


@dataclass(frozen=True)
class Image:
    """The files of one build by path, and its manifest."""

    files: dict[str, bytes]
    manifest: dict[str, object]


def build_image(
    root: Path,
    role: str | None,
    emitter: str,
    arch: str,
    packages: tuple[str, ...],
    generated: Mapping[str, str] = MappingProxyType({}),
) -> Image:
    """Compile the modules of ``role`` (None: all) under ``root``. BuildError names file, line and rule.

    ``generated``: further modules that are no files, text by path (generated.py).
    """
    modules = read_modules(root, packages)
    files: dict[str, bytes] = {}
    for name in select(modules, role):
        module = modules[name]
        text = rewrite(module, modules, emitter, arch)
        if module.path in START_FILES:
            files[module.path.removeprefix("firmware/")] = text.replace(b"from firmware.slots ", b"from slots ")
        else:
            files[module.path.removesuffix(".py") + ".mpy"] = compile_text(text, module.path, emitter, arch)
    for path, own in generated.items():
        files[path.removesuffix(".py") + ".mpy"] = compile_text(own.encode(), path, "bytecode", arch)
    return Image(files, _manifest(files, role, emitter, arch, protocol_hash(modules)))


def select(modules: dict[str, Module], role: str | None) -> list[str]:
    """Return the dotted names of the modules that a role needs, in order."""
    if role is None:
        return sorted(modules)
    starts = ROLES[role]
    seeds = [m.name for m in modules.values() if m.path.startswith(starts) or m.path in START_FILES]
    if not seeds:
        raise BuildError(f"role {role}: none of {', '.join(starts)} exists")
    return closure(modules, seeds)


def protocol_hash(modules: dict[str, Module]) -> int | None:
    """Return the hash of the wire protocol that the sources speak; None without one."""
    found = [m.constants[PROTOCOL] for m in modules.values() if PROTOCOL in m.constants]
    return found[0] if found else None


def write_image(image: Image, out: Path) -> None:
    """Put the tree at ``out`` as a whole: a former build there is replaced, other files never are."""
    if out.exists() and any(out.iterdir()) and not (out / MANIFEST).exists():
        raise BuildError(f"{out}: holds files that are not a former build; name an empty or a new folder")
    out.parent.mkdir(parents=True, exist_ok=True)
    new = Path(tempfile.mkdtemp(prefix=f".{out.name}.", dir=out.parent))
    try:
        for path, data in image.files.items():
            (new / path).parent.mkdir(parents=True, exist_ok=True)
            (new / path).write_bytes(data)
        (new / MANIFEST).write_text(json.dumps(image.manifest, indent=1) + "\n")
        new.chmod(0o755)
        if out.exists():
            shutil.rmtree(out)
        os.replace(new, out)
    finally:
        shutil.rmtree(new, ignore_errors=True)


def _manifest(
    files: dict[str, bytes], role: str | None, emitter: str, arch: str, protocol: int | None
) -> dict[str, object]:
    rows = [
        {"file": path, "size": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        for path, data in sorted(files.items())
    ]
    identity = json.dumps([role, emitter, arch, protocol, rows])
    return {
        "build": hashlib.sha256(identity.encode()).hexdigest()[:16],
        "role": role or "all",
        "emitter": emitter,
        "arch": arch if emitter != "bytecode" else "any",
        "compiler": compiler_version(),
        "mpy": compiler_version().rpartition(" v")[2],
        "protocol": protocol,
        "files": rows,
    }
