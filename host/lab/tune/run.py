"""Tunes a robot file: the search with its store, the best so far at any time, the score on other grounds."""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...util.errors import NOT_ACHIEVED, UserError
from ...util.files import write_text
from ..workers.versions import fingerprint
from ..workers.work import Workers
from .goals import FINAL_SEEDS, GOALS, OTHER_SEEDS, SEARCHED_SEEDS, walks
from .search import SEED, search
from .store import Store, Values
from .values import RobotFile

FINALISTS = 6  # candidates that walk on the final seeds, too

# Called with the number of finished trials, and the best score so far, if there is one.
Told = Callable[[int, float | None], None]


@dataclass(frozen=True)
class Wanted:
    """A tuning task: the robot file, the goal, the gait, the simulator, and the largest number of trials."""

    file: RobotFile
    goal: str
    gait: str
    where: str
    trials: int


class Tuning:
    """One search, from the beginning or from the end of its store."""

    def __init__(self, wanted: Wanted, store: Path, workers: Workers, told: Told) -> None:
        self.wanted, self._workers, self._told = wanted, workers, told
        self.searched = wanted.file.searched(wanted.gait, wanted.goal == "speed")
        self.store = Store(store, {
            "robot file": hashlib.sha256(wanted.file.text.encode()).hexdigest()[:16], "goal": wanted.goal,
            "gait": wanted.gait, "world": wanted.where, "seed": SEED, "walks": len(SEARCHED_SEEDS),
            "values": {each.key: [each.low, each.high] for each in self.searched}, "caramelo": fingerprint(),
        })
        self._chosen: tuple[Values, float] | None = None

    def search(self) -> None:
        """Try candidates until there are as many as wanted."""
        search(self.searched, self._evaluate, self.wanted.trials, self.store)

    def _evaluate(self, candidates: Sequence[Values]) -> list[float]:
        done = len(self.store.trials)
        return self.scores(candidates, SEARCHED_SEEDS, lambda ready: self._told(done + ready, self._best_score()))

    def _best_score(self) -> float | None:
        return self.store.best[1] if self.store.trials else None

    def scores(self, candidates: Sequence[Values], seeds: range, told: Callable[[int], None]) -> list[float]:
        """Return the mean score of each candidate's walks; one that can't be built has none.

        ``told`` gets the number of finished candidates.
        """
        wanted, robots = self.wanted, [self.wanted.file.like(values) for values in candidates]
        tasks = [walk for robot in robots if robot is not None
                 for walk in walks(wanted.goal, robot, wanted.gait, wanted.where, seeds, wanted.file.spreads)]
        each, unbuilt = len(seeds), robots.count(None)

        def heard(ready: int) -> None:
            if ready % each == 0:
                told(unbuilt + ready // each)

        answers = iter(self._workers.run_all(tasks, heard))
        return [0.0 if robot is None else sum(next(answers) for _ in seeds) / each for robot in robots]

    @property
    def now(self) -> Values:
        """The file's own values."""
        return {each.key: each.now for each in self.searched}

    @property
    def best(self) -> tuple[Values, float]:
        """The best values, and their score on searched grounds: of the final walks if there were any, else so far."""
        return self._chosen or self.store.best

    def final(self) -> None:
        """Choose among the best by more walks than in the search."""
        ranked = sorted(self.store.trials, key=lambda trial: -trial[1])
        few = [trial for place, trial in enumerate(ranked) if trial not in ranked[:place]][:FINALISTS]
        more = self.scores([values for values, _ in few], FINAL_SEEDS, lambda done: None)
        walked = [len(SEARCHED_SEEDS) * score + len(FINAL_SEEDS) * other
                  for (_, score), other in zip(few, more, strict=True)]
        self._chosen = few[walked.index(max(walked))]

    def on_other_grounds(self) -> tuple[float, float]:
        """Return the scores of the file's own and the best values, on grounds that the search did not use."""
        before, after = self.scores([self.now, self.best[0]], OTHER_SEEDS, lambda done: None)
        return before, after

    def write(self, out: Path) -> None:
        """Write a copy of the robot file with the best values; UserError if nothing is better than the file's own."""
        if self.best[0] == self.now:
            raise UserError(f"{len(self.store.trials)} trials found nothing better than {self.wanted.file.path} "
                            "as it is: no file written", NOT_ACHIEVED)
        write_text(out, self.wanted.file.rewritten(self.searched, self.best[0]))

    def result(self, other: tuple[float, float]) -> dict[str, Any]:
        """Return the results, for JSON."""
        best, score = self.best
        return {
            "robot": self.wanted.file.robot.name, "for": self.wanted.goal, "gait": self.wanted.gait,
            "in": self.wanted.where, "trials": len(self.store.trials), "unit": GOALS[self.wanted.goal].unit,
            "searched": {"before": self.store.trials[0][1], "after": score},
            "other_grounds": {"before": other[0], "after": other[1]},
            "values": {each.key: {"before": each.now, "after": best[each.key]} for each in self.searched},
        }
