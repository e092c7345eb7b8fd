"""What an experiment hands over: figures for JSON, tables for people, pictures, and walks worth watching."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from sim2d.recording import Recording

from ...control.gait_changes import change_lines
from .trials import Answer


@dataclass(frozen=True)
class Table:
    """A table for people: title, head, rows of text."""

    title: str
    head: tuple[str, ...]
    rows: Sequence[tuple[str, ...]]


@dataclass(frozen=True)
class Picture:
    """A PNG: its file's name, a caption, and who draws it into a path."""

    name: str
    caption: str
    draw: Callable[[Path], None]


@dataclass(frozen=True)
class Film:
    """A walk in the plane to be animated."""

    title: str
    recording: Recording
    facts: list[tuple[str, str]]


@dataclass(frozen=True)
class Outcome:
    """All of an experiment's results."""

    name: str
    title: str
    result: dict[str, Any]
    tables: list[Table]
    pictures: list[Picture] = field(default_factory=list)
    films: list[Film] = field(default_factory=list)


def figure(value: float | None, digits: int = 1, unit: str = "", scale: float = 1.0) -> str:
    """Return a number for a table, "-" if there is none."""
    return "-" if value is None else f"{value * scale:.{digits}f}{unit}"


def p_value(value: float | None) -> str:
    """Return a p-value for a table."""
    return "< 0.0001" if value is not None and value < 1e-4 else figure(value, 4)


def film(title: str, answer: Answer) -> list[Film]:
    """Return the film of an answer that kept a recording of the plane, or none."""
    recording, figures = answer.recording, answer.figures
    if not isinstance(recording, Recording):
        return []
    facts = [
        ("speed", f"{figures['mean_speed_m_s']:.4f} m/s"),
        ("pitch range", f"{figures['pitch_range_deg']:.1f} deg"),
        *change_lines(figures["gait_changes"]),
        ("outcome", str(figures["reason"])),
    ]
    return [Film(title, recording, facts)]


def rate(answers: Sequence[Answer]) -> str:
    """Return how many of some trials passed, as text."""
    return f"{sum(answer.ok for answer in answers)}/{len(answers)}" if answers else "-"
