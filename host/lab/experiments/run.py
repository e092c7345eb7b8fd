"""Experiments by name: their trials run, their figures gathered, their files written."""

import json
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from ...util.errors import UserError
from ...util.files import atomic_path, write_text
from ...util.progress import Tell
from .outcome import Outcome
from .pool import run_all
from .report import report_html
from .trials import Options

# The papers' experiments, which `all` runs, and this project's own list of figures to reach.
PAPERS = ("table1", "table2", "ramp", "steps", "payload", "requirements")
NAMES = (*PAPERS, "goals")


def names_of(what: str) -> tuple[str, ...]:
    """Return the experiments asked for, or raise UserError."""
    if what != "all" and what not in NAMES:
        raise UserError(f"experiment {what}: no such experiment; there are {', '.join(NAMES)} and all")
    return PAPERS if what == "all" else (what,)


def run_experiment(name: str, options: Options, tell: Tell) -> Outcome:
    """Run one experiment; ``tell`` hears how many trials of how many are ready. The outcome depends on no timing."""
    module = import_module(f"{__package__}.{name}")
    tasks = module.tasks(options)
    answers = run_all(tasks, options.jobs, lambda ready: tell(ready, len(tasks), ""))
    outcome: Outcome = module.evaluate(options, answers)
    return outcome


def write_outcomes(options: Options, outcomes: Sequence[Outcome], folder: Path) -> list[Path]:
    """Write figures, pictures and the report, each file whole; return them."""
    written = []
    for outcome in outcomes:
        figures = folder / f"{outcome.name}.json"
        write_text(figures, json.dumps(outcome.result, indent=1, allow_nan=False) + "\n")
        written.append(figures)
        for picture in outcome.pictures:
            with atomic_path(folder / picture.name) as draft:
                picture.draw(draft)
            written.append(folder / picture.name)
    page = folder / "report.html"
    write_text(page, report_html(options.robot, options.gait, outcomes, folder))
    return [*written, page]
