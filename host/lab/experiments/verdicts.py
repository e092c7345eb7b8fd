"""Cases with a limit: their judges, and the table of met and unmet cases."""

import math
from collections.abc import Callable
from statistics import median
from typing import Any

from ...robot.model import KNEE_CONFIGURATIONS
from .case import Answers, Found, Judge, Row, Table, arrives, rate
from .trials import Answer, Options, most_loaded

# How a figure is told: its name and unit.
TOLD = {
    "speed_m_s": ("speed", ""), "roll_range_deg": ("roll", " deg"), "pitch_range_deg": ("pitch", " deg"),
    "yaw_drift_deg": ("yaw", " deg"), "side_drift_m": ("aside", " m"), "cost_of_transport": ("cost", ""),
    "crossing_s": ("median", " s"),
}
WORDS = {True: "met", False: "not met", None: "reported"}


def share(least: float | None, ok: Callable[[Answer], bool] = arrives,
          most_median: tuple[str, float] | None = None) -> Judge:
    """Return a judge: met if this share of the trials is ``ok``; None only reports.

    ``most_median``: a figure, and the most that its median of those that are ok may be; without a share it is told.
    """

    def judge(answers: Answers) -> tuple[bool | None, str]:
        walks = [answer for series in answers.values() for answer in series]
        good = [answer for answer in walks if ok(answer)]
        met, told = least is not None and len(good) >= least * len(walks), f"{len(good)}/{len(walks)}"
        if most_median:
            key, most = most_median
            middle = median([x for answer in good if (x := answer.figures[key]) is not None] or [math.inf])
            met = met and middle <= most
            name, unit = TOLD[key]
            told += f", {name} {middle:.3g}{unit}" if middle < math.inf else f", no {name}"
        return None if least is None else met, told

    return judge


def within(least: float = 1.0, judged: bool = True, **limits: tuple[float, float]) -> Judge:
    """Return a judge: met if this share of the trials arrived with every figure in its limits; else it reports."""

    def figure(answer: Answer, key: str) -> float:
        value = answer.figures[key]
        return math.inf if value is None else float(value)  # a robot that did not move has no figure per metre

    def good(answer: Answer) -> bool:
        return answer.ok and all(low <= figure(answer, key) <= high for key, (low, high) in limits.items())

    def judge(answers: Answers) -> tuple[bool | None, str]:
        walks = [answer for series in answers.values() for answer in series]
        parts = [f"{sum(map(good, walks))}/{len(walks)}"]
        for key in limits:
            known = [value for answer in walks if (value := figure(answer, key)) < math.inf]
            name, unit = TOLD[key]
            parts.append(f"{name} {min(known):.3g} .. {max(known):.3g}{unit}" if known else f"no {name}")
        return (sum(map(good, walks)) >= least * len(walks)) if judged else None, ", ".join(parts)

    return judge


def carries(most: float, judged: bool = True) -> Judge:
    """Return a judge of a walk in each knee configuration: met if one has no joint above ``most`` of stall anywhere."""

    def judge(answers: Answers) -> tuple[bool | None, str]:
        good, told = False, []
        for knees, walks in zip(KNEE_CONFIGURATIONS, zip(*answers.values(), strict=True), strict=True):
            worst = [most_loaded(answer.figures)[1] for answer in walks]
            good = good or all(answer.ok and part <= most for answer, part in zip(walks, worst, strict=True))
            parts = " and ".join(f"{'walks' if answer.ok else 'fails'} {100 * part:.0f} %"
                                 for answer, part in zip(walks, worst, strict=True))
            told.append(f"{knees} {parts}")
        return good if judged else None, ", ".join(told)

    return judge


def everywhere(answers: Answers) -> tuple[bool | None, str]:
    """Judge that every trial passed, counted by simulator."""
    told = ", ".join(f"{rate(series)} {where}" for where, series in answers.items())
    return all(answer.ok for series in answers.values() for answer in series), told


def sum_up(title: str, options: Options, rows: list[Row]) -> Found:
    """Return one row for each case: met or not, its figure, and why trials failed."""
    found: list[dict[str, Any]] = []
    text: list[tuple[str, ...]] = []
    for row in rows:
        met, told = row.case.judge(row.answers) if row.case.judge else (None, "")
        walks = [answer for series in row.answers.values() for answer in series]
        failures = [answer.figures["reason"] for answer in walks if not row.case.passes(answer)]
        found.append({
            "case": row.case.name, **row.case.facts, "in": list(row.answers), "met": met, "figure": told,
            "wanted": row.case.wanted, "walks": len(walks), "paper": row.case.paper,
            "failures": failures,
        })
        why = f"; {failures[0]}" if met is False and failures else ""
        text.append((row.case.name, " ".join(row.answers), WORDS[met], told + why, row.case.wanted, str(len(walks)),
                     str(row.case.paper or "")))
    return Found({"rows": found}, [_table(f"{title}, gait {options.gait}", text)])


def _table(title: str, text: list[tuple[str, ...]]) -> Table:
    """Return the table without the columns that are empty."""
    head = ("", "in", "", "figure", "wanted", "walks", "paper")
    full = [i for i in range(len(head)) if any(row[i] for row in text)]
    return Table(title, tuple(head[i] for i in full), [tuple(row[i] for i in full) for row in text])


