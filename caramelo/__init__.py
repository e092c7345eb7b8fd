"""Walking robots from Python: `from caramelo import Robot` (docs/python.md).

names.py lists the public names; anything else that is installed may change at any time. The names are imported on first
use, because the command line needs none of them.
"""

import importlib
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .names import *  # noqa: F403
else:

    def __getattr__(name: str) -> Any:
        """Return one of the names, or raise AttributeError."""
        names = importlib.import_module(f"{__name__}.names")
        if name != "__all__" and name not in names.__all__:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        return getattr(names, name)
