"""What an image may take of a board's memories: image_budget.json beside this file, and the table that tells it."""

import json
from dataclasses import dataclass
from pathlib import Path

BUDGET = Path(__file__).with_name("image_budget.json")
AT_LEAST = ("heap",)  # the budget of these is what there has to be; of all others, what there may be
# What is measured, in the table's order, and in which memory it lies
ROWS = {
    "interpreter": ("flash", "interpreter and drivers"),
    "frozen": ("flash", "frozen code"),
    "flash": ("flash", "image, a slot's"),
    "loader": ("flash", "loader, sector 0"),
    "data": ("RAM", "data set at start"),
    "heap": ("RAM", "heap"),
    "bss": ("CCM", "static data"),
    "stack": ("CCM", "stack"),
}


@dataclass(frozen=True)
class Row:
    """One line of the table, in bytes."""

    memory: str
    what: str
    bytes: int
    budget: int
    least: bool

    @property
    def room(self) -> int:
        """Return what is left of the budget; negative when it is over."""
        return self.bytes - self.budget if self.least else self.budget - self.bytes


def rows(role: str, measured: dict[str, int]) -> list[Row]:
    """Return the table of one role's image."""
    budget = json.loads(BUDGET.read_text())[role]
    return [
        Row(memory, what, measured[name], budget[name], name in AT_LEAST) for name, (memory, what) in ROWS.items()
    ]


def over_budget(role: str, table: list[Row]) -> list[str]:
    """Return a sentence for each line that does not keep to its budget."""
    return [
        f"{role}: {row.what}: {row.bytes} bytes, the budget is {'at least' if row.least else 'at most'} {row.budget}"
        for row in table
        if row.room < 0
    ]
