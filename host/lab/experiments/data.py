"""The numbers the experiments are compared with, and those they rest on, from the data files."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

_HERE = Path(__file__).parent


@cache
def papers() -> dict[str, Any]:
    """Return what the papers measured (papers.toml)."""
    return tomllib.loads((_HERE / "papers.toml").read_text(encoding="utf-8"))


@cache
def assumptions() -> dict[str, Any]:
    """Return what the figures rest on (assumptions.toml)."""
    return tomllib.loads((_HERE / "assumptions.toml").read_text(encoding="utf-8"))


@cache
def goal_tables() -> dict[str, Any]:
    """Return what robots are to reach (goals.toml)."""
    return tomllib.loads((_HERE / "goals.toml").read_text(encoding="utf-8"))
