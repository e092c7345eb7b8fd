"""The cost in fuel that each function may have, kept beside this file: growth has to be decided, not to happen."""

import json
from pathlib import Path

BUDGET = Path(__file__).with_name("fuel_budget.json")
GROWTH = 0.05


def read_budget() -> dict[str, int]:
    return dict(json.loads(BUDGET.read_text())) if BUDGET.exists() else {}


def write_budget(fuel: dict[str, int]) -> None:
    new = BUDGET.with_suffix(".new")
    new.write_text(json.dumps(fuel, indent=1) + "\n")
    new.replace(BUDGET)


def over_budget(fuel: dict[str, int], budget: dict[str, int]) -> list[str]:
    """Return one sentence for each function that costs too much, or that the budget does not know."""
    sentences = []
    for name, cost in fuel.items():
        if name not in budget:
            sentences.append(f"{name}: not in the fuel budget")
        elif cost > budget[name] * (1 + GROWTH):
            sentences.append(f"{name}: costs {cost}, the budget is {budget[name]} (+{cost / budget[name] - 1:.1%})")
    return sentences + [f"{name}: in the fuel budget, but has no vectors" for name in budget if name not in fuel]
