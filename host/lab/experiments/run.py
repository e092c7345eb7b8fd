"""Experiments by name: their trials run, their figures gathered, their files written."""

import json
from collections.abc import Sequence
from pathlib import Path

from sim2d.recording import Recording

from ...util.errors import UserError
from ...util.files import atomic_path, write_text
from ...util.progress import Tell
from ..workers.work import Workers
from . import counts, drawn, goals, requirements, samples
from .case import Answers, Case, Experiment, Found, Outcome, Row
from .report import report_html
from .trials import PLANE, Options

PAPERS = {**samples.EXPERIMENTS, **counts.EXPERIMENTS, "requirements": requirements.EXPERIMENT}
EXPERIMENTS: dict[str, Experiment] = {**PAPERS, "goals": goals.EXPERIMENT, "drawn": drawn.EXPERIMENT}


def names_of(what: str) -> tuple[str, ...]:
    """Return the experiments asked for, or raise UserError; all are those of the papers."""
    if what != "all" and what not in EXPERIMENTS:
        raise UserError(f"experiment {what}: no such experiment; there are {', '.join(EXPERIMENTS)} and all")
    return tuple(PAPERS) if what == "all" else (what,)


def run_experiment(name: str, options: Options, workers: Workers, tell: Tell) -> Outcome:
    """Run one experiment; ``tell`` gets the number of finished trials and of all. The outcome depends on no timing."""
    experiment = EXPERIMENTS[name]
    cases = experiment.cases(options)
    trials = {id(trial): trial for case in cases for series in case.trials.values() for trial in series}
    answers = workers.run_all(list(trials.values()), lambda ready: tell(ready, len(trials), ""))
    by_trial = dict(zip(trials, answers, strict=True))
    rows = [Row(case, _answers(case, by_trial)) for case in cases]
    found = experiment.sum_up(options, rows)
    head = {"experiment": name, "robot": options.robot.name, "gait": options.gait,
            "honest": options.robot.simulation.honest}
    films = [(row.case.name, answer) for row in rows for answer in row.answers.get(PLANE, [])
             if isinstance(answer.recording, Recording)]
    return Outcome(name, experiment.title, Found(head | found.result, found.tables, found.pictures), films)


def _answers(case: Case, by_trial: dict[int, object]) -> Answers:
    return {where: [by_trial[id(trial)] for trial in series] for where, series in case.trials.items()}  # type: ignore[misc]


def write_outcomes(options: Options, outcomes: Sequence[Outcome], folder: Path) -> list[Path]:
    """Write figures, pictures and the report, each file whole; return them."""
    written = []
    for outcome in outcomes:
        figures = folder / f"{outcome.name}.json"
        write_text(figures, json.dumps(outcome.found.result, indent=1, allow_nan=False) + "\n")
        written.append(figures)
        for picture in outcome.found.pictures:
            with atomic_path(folder / picture.name) as draft:
                picture.draw(draft)
            written.append(folder / picture.name)
    page = folder / "report.html"
    write_text(page, report_html(options.robot, outcomes, folder))
    return [*written, page]
