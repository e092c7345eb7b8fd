"""What each module weighs on the board, per emitter, against a budget kept beside this file."""

import json
from pathlib import Path

from ... import ROOT
from ...util.files import write_text
from .compiler import compile_text
from .frozen import ARCH
from .lower import lowered_modules
from .rewrite import EMITTERS, rewrite

BUDGET = Path(__file__).with_name("size_budget.json")
GROWTH = 0.03  # a module may grow by this much before the budget has to be changed on purpose
GROWS = ("shared/gait/gaits.py",)  # a table for each gait: it may grow by any gait that is added

Sizes = dict[str, dict[str, int]]


def measure_sizes(root: Path) -> Sizes:
    """Return the bytes of every module as bytecode, native and viper."""
    modules = lowered_modules(root)
    return {
        module.path: {
            emitter: len(compile_text(rewrite(module, modules, emitter, ARCH), module.path, emitter, ARCH))
            for emitter in EMITTERS
        }
        for module in modules.values()
    }


def read_budget() -> Sizes:
    return dict(json.loads(BUDGET.read_text())) if BUDGET.exists() else {}


def write_budget(sizes: Sizes) -> None:
    write_text(BUDGET, json.dumps(sizes, indent=1, sort_keys=True) + "\n")


def over_budget(sizes: Sizes, budget: Sizes) -> list[str]:
    """Return one sentence for each module that is too large, or that the budget does not know."""
    sentences = []
    for path, row in sizes.items():
        if path not in budget:
            sentences.append(f"{path}: not in the size budget")
            continue
        for emitter, size in row.items():
            allowed = budget[path][emitter]
            if path not in GROWS and size > allowed * (1 + GROWTH):
                sentences.append(
                    f"{path}: {size} bytes as {emitter}, the budget is {allowed} (+{size / allowed - 1:.1%})"
                )
    sentences += [f"{path}: in the size budget, but not in the sources" for path in budget if path not in sizes]
    return sentences


if __name__ == "__main__":  # python -m host.boards.build.sizes: today's sizes become the budget, on purpose
    write_budget(measure_sizes(ROOT))
