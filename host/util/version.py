"""The versions in use: this software, Python, and whether the core is machine code or its sources."""

import platform
from importlib.metadata import version

from shared.num import fixed


def software_version() -> str:
    """Return the distribution's version."""
    return version("caramelo-robot")


def versions() -> dict[str, str]:
    """Return the versions by name."""
    core = "sources" if str(fixed.__file__).endswith(".py") else "machine code"
    return {"caramelo": software_version(), "python": platform.python_version(), "core": core}
