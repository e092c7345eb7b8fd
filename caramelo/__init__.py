"""Walking robots from Python: `from caramelo import Robot` (docs/python.md).

What is meant to be used from outside is named in names.py; what else is installed may change at any time. The names are
imported when they are asked for: the command line needs none of them.
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
