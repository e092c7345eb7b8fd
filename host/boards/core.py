"""The control core as machine code for this Python: where it is, and when it replaces the sources.

`caramelo core build` makes it (boards/build/native_core.py). It is beside this Python's packages, in a folder named
after the sources it was made from; after any change to them it is not used until it is built again.
"""

import hashlib
import importlib
import os
import re
import subprocess
import sys
import sysconfig
from pathlib import Path

from shared import __name__ as PACKAGE  # "shared" in a checkout, "caramelo.shared" when installed

from .. import ROOT
from ..util.console import write_error

SWITCH = "CARAMELO_CORE"  # environment variable: another folder for cores, or "source" for no machine code
PACKED = ROOT / "cores"  # in a wheel that was built with one
_RULES = ("typed.py", "native_core.py")  # of host/boards/build: part of the core's identity, as they compile it
_NAME = re.compile("[0-9a-f]{16}")
_INSIDE = Path(*PACKAGE.split("."), "planner", "planner.py")


def sources_id(root: Path = ROOT) -> str:
    """Return the name of the core made from ``root``/shared by this Python."""
    total = hashlib.sha256(f"{sysconfig.get_config_var('SOABI') or sys.version} {PACKAGE}".encode())
    files = [(root, path) for path in sorted((root / "shared").rglob("*.py*")) if path.suffix in (".py", ".pyi")]
    for top, path in files + [(ROOT, ROOT / "host/boards/build" / name) for name in _RULES]:
        total.update(path.relative_to(top).as_posix().encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]


def home() -> Path:
    """Return the folder of cores: beside this Python's packages, unless CARAMELO_CORE names another."""
    named = os.environ.get(SWITCH)
    return Path(named) if named and not turned_off() else Path(sysconfig.get_path("platlib")) / "caramelo_core"


def turned_off() -> bool:
    """Return True if CARAMELO_CORE asks for the sources."""
    return os.environ.get(SWITCH) == "source"


def kept_cores() -> list[Path]:
    """Return the folders of all cores at home, from any sources, and nothing else that may be there."""
    if not home().is_dir():
        return []
    return sorted(path for path in home().iterdir() if _NAME.fullmatch(path.name) and (path / _INSIDE).is_file())


def find_core(root: Path = ROOT) -> Path | None:
    """Return the folder of the compiled core of ``root``; None if there is none from these sources.

    None also if CARAMELO_CORE is "source".
    """
    if turned_off() or not (PACKED.is_dir() or kept_cores()):
        return None
    name = sources_id(root)
    return next((core for core in (home() / name, PACKED / name) if (core / _INSIDE).is_file()), None)


def use_core() -> bool:
    """Let this process use the core's machine code instead of its sources; return whether it does.

    It does not if a part of shared/ is already imported: half of each would not fit.
    """
    if any(name.startswith(f"{PACKAGE}.") for name in sys.modules):
        return False
    core = find_core()
    if core is None:
        return False
    places = sys.modules[PACKAGE].__path__
    sources = list(places)
    places[:] = [str(core.joinpath(*PACKAGE.split(".")))]
    sys.path.append(str(core))  # the modules' common part is beside the package
    try:
        importlib.import_module(f"{PACKAGE}.num.fixed")
    except ImportError as error:
        for name in [name for name in sys.modules if name.startswith(f"{PACKAGE}.")]:
            del sys.modules[name]
        places[:] = sources
        sys.path.remove(str(core))
        write_error(f"the compiled core can't be loaded ({error}); the sources run instead. To rebuild it: "
                    "caramelo core build")
        return False
    return True


def usable_core() -> Path | None:
    """Return the folder of the compiled core that a new process uses: None also if it is there and can't be loaded."""
    use = f"from {__name__} import use_core; raise SystemExit(not use_core())"
    core = find_core()
    return core if core and subprocess.run((sys.executable, "-c", use), capture_output=True).returncode == 0 else None
