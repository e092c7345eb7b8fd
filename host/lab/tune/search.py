"""The search: CMA-ES (pycma) over shares of each value's range, one generation of trials at a time.

A generation's size follows from the number of values alone, and its trials from those before: the same for any number
of workers, and for a search that went on from its store.
"""

import warnings
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...util.errors import UserError
from .store import Store, Values
from .values import Searched

SEED = 1
WIDTH = 0.15  # of each range: the first generation's standard deviation around the file's own values

# Scores of candidates, in order.
Evaluate = Callable[[Sequence[Values]], list[float]]


def search(searched: Sequence[Searched], evaluate: Evaluate, trials: int, store: Store) -> None:
    """Try ``trials`` candidates in all, the file's own values first; the store has them and their scores."""
    strategy = _strategy(searched)
    _tried([{each.key: each.now for each in searched}], evaluate, store, 0)
    done = 1
    while done < trials and not strategy.stop():
        asked = strategy.ask()
        values = [{each.key: each.at(share) for each, share in zip(searched, shares, strict=True)} for shares in asked]
        scores = _tried(values[: trials - done], evaluate, store, done)
        done += len(scores)
        if len(scores) == len(asked):
            strategy.tell(asked, [-score for score in scores])


def _tried(values: list[Values], evaluate: Evaluate, store: Store, done: int) -> list[float]:
    """Return the scores of the candidates; those that the store has are not tried again."""
    known = [kept for kept, _ in store.trials[done : done + len(values)]]
    if known != values[: len(known)]:
        raise UserError(f"{store.path}: its trials from {done + 1} on differ from those that this numpy and cma would "
                        "make: remove it, or name another with --store")
    new = values[len(known) :]
    for one, score in zip(new, evaluate(new) if new else [], strict=True):
        store.add(one, score)
    return [score for _, score in store.trials[done : done + len(values)]]


def _strategy(searched: Sequence[Searched]) -> Any:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of drawing without matplotlib
        import cma

    dice = np.random.default_rng(SEED)
    options = {
        "bounds": [0, 1], "seed": np.nan, "randn": lambda *shape: dice.standard_normal(shape), "verbose": -9,
        "verb_log": 0, "verb_disp": 0,
    }
    return cma.CMAEvolutionStrategy([each.share for each in searched], WIDTH, options)
