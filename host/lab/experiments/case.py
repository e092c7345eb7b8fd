"""The records of an experiment: its cases before it runs, a row for each afterwards, and its results."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..workers.work import Task
from .trials import PLANE, Answer, Options

# From a case's answers by simulator: whether it is met, not met, or only reported (None), and its figure in words.
Answers = Mapping[str, list[Answer]]
Judge = Callable[[Answers], tuple[bool | None, str]]


def arrives(answer: Answer) -> bool:
    """Return whether a walk got to its end."""
    return answer.ok


def stays_up(answer: Answer) -> bool:
    """Return whether a walk ended without a fall."""
    return not answer.figures["falls"]


@dataclass(frozen=True)
class Case:
    """One row: its trials by simulator, its limit in words and who judges it, the papers' figures, and more for JSON.

    A trial that is in several cases of an experiment, as the same object, runs once. ``passes``: whether a trial is not
    among the failures that are told, whatever more the judge asks of it.
    """

    name: str
    trials: Mapping[str, Sequence[Task]]
    wanted: str = ""
    judge: Judge | None = None
    paper: Any = None
    facts: Mapping[str, Any] = field(default_factory=dict)
    passes: Callable[[Answer], bool] = arrives


@dataclass(frozen=True)
class Row:
    """A case and its answers, by simulator."""

    case: Case
    answers: Answers


@dataclass(frozen=True)
class Table:
    """A table to print: title, head, rows of text."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class Picture:
    """A PNG: its file's name, a caption, and a function that draws it to a path."""

    name: str
    caption: str
    draw: Callable[[Path], None]


@dataclass(frozen=True)
class Found:
    """An experiment's results from its rows: figures for JSON, tables to print, pictures."""

    result: dict[str, Any]
    tables: list[Table]
    pictures: list[Picture] = field(default_factory=list)


@dataclass(frozen=True)
class Experiment:
    """An experiment: its cases, and the evaluation of their answers."""

    title: str
    cases: Callable[[Options], list[Case]]
    sum_up: Callable[[Options, list[Row]], Found]


@dataclass(frozen=True)
class Outcome:
    """An experiment that has run; ``films``: the walks in the plane to be animated, each with its case's name."""

    name: str
    title: str
    found: Found
    films: list[tuple[str, Answer]]


def rate(answers: Sequence[Answer]) -> str:
    """Return how many of some trials passed, as text."""
    return f"{sum(answer.ok for answer in answers)}/{len(answers)}" if answers else "-"


def by_simulator(row: Row, counted: Callable[[list[Answer]], dict[str, Any]]) -> dict[str, Any]:
    """Return a row for JSON: its name and facts, what is counted in each simulator, and the papers' figures."""
    parts = {key: counted(row.answers[where]) if row.answers.get(where) else None
             for key, where in (("plane", PLANE), ("three_d", "3-D"))}
    return {"case": row.case.name, **row.case.facts, **parts, "paper": row.case.paper}
