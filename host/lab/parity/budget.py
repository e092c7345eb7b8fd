"""The cost in fuel that each function may have, kept beside this file: growth has to be decided, not to happen."""

import json
from pathlib import Path

from ...util.files import write_text

BUDGET = Path(__file__).with_name("fuel_budget.json")
GROWTH = 0.05
WALK = "planner.tick:"  # a whole tick of a walk; one in a gait added as a table may cost what the dearest does


def read_budget() -> dict[str, int]:
    return dict(json.loads(BUDGET.read_text())) if BUDGET.exists() else {}


def write_budget(fuel: dict[str, int]) -> None:
    write_text(BUDGET, json.dumps(fuel, indent=1) + "\n")


def is_added(name: str, budget: dict[str, int]) -> bool:
    """Return whether this is a walk in a gait that was added since the budget was written: a table, no new code."""
    return name.startswith(WALK) and name not in budget


def allowance(name: str, budget: dict[str, int]) -> int:
    """Return what a function may cost, 0 if the budget does not know it."""
    if is_added(name, budget):
        return max((cost for walk, cost in budget.items() if walk.startswith(WALK)), default=0)
    return budget.get(name, 0)


def over_budget(fuel: dict[str, int], budget: dict[str, int]) -> list[str]:
    """Return one sentence for each function that costs too much, or that the budget does not know."""
    sentences = []
    for name, cost in fuel.items():
        allowed = allowance(name, budget)
        if allowed == 0:
            sentences.append(f"{name}: not in the fuel budget")
        elif cost > allowed * (1 + GROWTH):
            sentences.append(f"{name}: costs {cost}, the budget is {allowed} (+{cost / allowed - 1:.1%})")
    return sentences + [f"{name}: in the fuel budget, but has no vectors" for name in budget if name not in fuel]
