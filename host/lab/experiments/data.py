"""The papers' figures, the assumptions and the goals of the experiments, from the data files."""

import tomllib
from functools import cache
from pathlib import Path
from typing import Any

_HERE = Path(__file__).parent


@cache
def papers() -> dict[str, Any]:
    """Return the papers' measurements (papers.toml)."""
    return tomllib.loads((_HERE / "papers.toml").read_text(encoding="utf-8"))


@cache
def assumptions() -> dict[str, Any]:
    """Return the assumptions of the figures (assumptions.toml)."""
    return tomllib.loads((_HERE / "assumptions.toml").read_text(encoding="utf-8"))


@cache
def goal_tables() -> dict[str, Any]:
    """Return the figures that robots should reach (goals.toml)."""
    return tomllib.loads((_HERE / "goals.toml").read_text(encoding="utf-8"))
