"""Tables 1 and 2 of paper A: means and deviations beside the paper's, and t-tests of which cases differ.

Student's t-test, two-sided, equal variances, from means and standard deviations, as paper A used it.
"""

import math
import statistics
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

from ...sim.grounds import GroundSpec
from ...sim.walk import WalkSpec
from . import plots
from .case import Case, Experiment, Found, Picture, Row, Table, by_simulator, rate
from .data import papers
from .foot_in_air import AirTrial
from .trials import PLANE, SPACE, Answer, Options, Trial, drawn, trial_conditions, trials


@dataclass(frozen=True)
class Sample:
    """A series of trials: their number, mean and sample standard deviation."""

    n: int
    mean: float
    sd: float

    def as_json(self) -> dict[str, float]:
        """Return mean and standard deviation, six significant digits."""
        return {"mean": float(f"{self.mean:.6g}"), "sd": float(f"{self.sd:.6g}")}


def sample(values: Sequence[float]) -> Sample:
    """Return the sample of some values; the deviation of a single one is 0."""
    sd = statistics.stdev(values) if len(values) > 1 else 0.0
    return Sample(len(values), statistics.fmean(values), sd)


def published(n: int, quantity: dict[str, float]) -> Sample:
    """Return a paper's figure as a sample."""
    return Sample(n, quantity["mean"], quantity["sd"])


def t_test(first: Sample, second: Sample) -> float | None:
    """Return the two-sided p-value for equal means; None if nothing varies or n is too small."""
    from scipy import stats

    if min(first.n, second.n) < 2 or first.sd + second.sd <= 1e-9 * (abs(first.mean) + abs(second.mean)):
        return None
    p = stats.ttest_ind_from_stats(first.mean, first.sd, first.n, second.mean, second.sd, second.n).pvalue
    return float(f"{float(p):.4g}") if math.isfinite(p) else None


@dataclass(frozen=True)
class Quantity:
    """A sampled quantity: its name in the papers' figures, in tables, and in a trial; scale and digits to show."""

    name: str
    label: str
    key: str = ""
    scale: float = 1.0
    digits: int = 4

    def sample(self, answers: Sequence[Answer]) -> Sample | None:
        """Return the sample of the trials that arrived, None if none did or this simulator has no such figure."""
        key = self.key or self.name
        values = [float(answer.figures[key]) for answer in answers if answer.ok and key in answer.figures]
        return sample(values) if values else None

    def text(self, part: dict[str, Any] | None) -> str:
        """Return its mean and deviation in what was counted, or in the paper's figures, for a table."""
        found = (part or {}).get(self.name)
        numbers = [f"{found[key] * self.scale:.{self.digits}f}" for key in ("mean", "sd")] if found else []
        return f"{numbers[0]} ({numbers[1]})" if found else "-"


AIR = (Quantity("time_s", "time, s"), Quantity("x_final_m", "final x, mm", "", 1000, 2),
       Quantity("y_final_m", "final y, mm", "", 1000, 2), Quantity("z_max_m", "highest, mm", "", 1000, 2))
WALK = (Quantity("speed_m_s", "speed, m/s", "mean_speed_m_s"),
        Quantity("steady_speed_m_s", "steady speed, m/s", "speed_m_s"),
        Quantity("roll_range_deg", "roll, deg", "whole_roll_range_deg", 1, 1),
        Quantity("pitch_range_deg", "pitch, deg", "whole_pitch_range_deg", 1, 1))


def air_cases(options: Options) -> list[Case]:
    """Return both targets of a foot in the air."""
    table = papers()["table1"]
    return [
        Case("to x {:g}, y {:g} m".format(*case["target_m"]),
             {where: [AirTrial(options.robot, tuple(case["target_m"]), trial_conditions(options.robot, seed),
                               where == SPACE) for seed in options.seeds(table["trials"])]
              for where in options.simulators},
             paper={**case, "n": table["trials"], "printed_p": table["printed_p"]})
        for case in table["case"]
    ]


def walk_cases(options: Options) -> list[Case]:
    """Return the four walks of table 2; the first of each is kept."""
    course = papers()["table2"]

    def series(case: dict[str, Any], where: str) -> list[Trial]:
        specs = [walk_spec(options, case["terrain"], where, seed) for seed in options.seeds(case["n"])]
        return trials(where, [replace(spec, balance=case["balance"]) for spec in specs], keep=True)

    return [
        Case(case["name"], {where: series(case, where) for where in options.simulators},
             paper={**case, "printed_p": {"roll_range_deg": course["printed_p"][case["terrain"]]}})
        for case in course["case"]
    ]


def walk_spec(options: Options, terrain: str, where: str, seed: int) -> WalkSpec:
    """Return a walk of table 2's course."""
    course = papers()["table2"]
    start_m, length_m = {PLANE: (0.35, course["distance_m"]), SPACE: (0.25, 1.8)}[where]  # of the stones
    ground = GroundSpec(terrain, start_m=start_m, length_m=length_m, seed=seed)
    spec = WalkSpec(options.robot, options.gait, course["speed_m_s"], ground, distance_m=course["distance_m"])
    return drawn(spec, seed)


def sum_up(quantities: Sequence[Quantity], tested: Sequence[str], title: str, options: Options,
           rows: list[Row]) -> tuple[dict[str, Any], list[Table]]:
    """Return figures and tables: every quantity of every case; what differs between cases 1 and 2, 3 and 4."""
    found = [by_simulator(row, partial(_counted, quantities)) for row in rows]
    text: list[tuple[str, ...]] = []
    for row, case in zip(rows, found, strict=True):
        places = [rate(row.answers.get(where, [])) for where in (PLANE, SPACE)]
        text.append((row.case.name, "arrived", *places, f"n = {case['paper']['n']}"))
        text += [("", q.label, *(q.text(case[part]) for part in ("plane", "three_d", "paper"))) for q in quantities]
    tests = [_t_test(q, rows[i : i + 2]) for i in range(0, len(rows), 2) for q in quantities if q.name in tested]
    labels = {q.name: q.label.partition(",")[0] for q in quantities}
    tested_text = [(test["cases"], labels[test["quantity"]],
                    *(_p(test[key]) for key in ("plane_p", "three_d_p", "paper_p", "paper_p_printed")))
                   for test in tests]
    return {"cases": found, "t_tests": tests}, [
        Table(f"{title}: mean (sd)", ("", "", "plane", "3-D", "paper"), text),
        Table("Do the two differ? Two-sided p of Student's t-test",
              ("", "", "plane", "3-D", "paper, recomputed", "printed (table 2: one-sided)"), tested_text),
    ]


def _counted(quantities: Sequence[Quantity], answers: list[Answer]) -> dict[str, Any]:
    samples = {q.name: q.sample(answers) for q in quantities}
    return {"n": len(answers), "passed": sum(answer.ok for answer in answers),
            **{name: sample and sample.as_json() for name, sample in samples.items()}}


def _t_test(quantity: Quantity, pair: list[Row]) -> dict[str, Any]:
    """Return whether a quantity differs between two cases: here in both simulators, and in the paper."""
    ours = {}
    for where in (PLANE, SPACE):
        first, second = (quantity.sample(row.answers.get(where, [])) for row in pair)
        ours[where] = t_test(first, second) if first and second else None
    theirs = [published(row.case.paper["n"], row.case.paper[quantity.name]) for row in pair]
    return {"cases": " / ".join(row.case.name for row in pair), "quantity": quantity.name, "plane_p": ours[PLANE],
            "three_d_p": ours[SPACE], "paper_p": t_test(*theirs),
            "paper_p_printed": pair[0].case.paper.get("printed_p", {}).get(quantity.name)}


def _p(value: float | None) -> str:
    if value is None:
        return "-"
    return "< 0.0001" if value < 1e-4 else f"{value:.4f}"


def _air(options: Options, rows: list[Row]) -> Found:
    result, tables = sum_up(AIR, ("time_s", "z_max_m"), "Foot in the air", options, rows)
    swings = [(row.case.name, row.answers[options.simulators[-1]][0].recording) for row in rows]
    return Found(result, tables, [Picture("table1.png", "Wanted and done, first trial of each target",
                                          partial(plots.swings, swings))])


def _walks(options: Options, rows: list[Row]) -> Found:
    title = f"1.5 m at 0.05 m/s, gait {options.gait}, those that arrived, ranges of roll and pitch"
    result, tables = sum_up(WALK, ("speed_m_s", "roll_range_deg", "pitch_range_deg"), title, options, rows)
    first = [(row.case.name, row.answers[options.simulators[-1]][0]) for row in rows]
    return Found(result, tables, [Picture("table2.png", "Attitude over time, first trial of each case",
                                          partial(plots.attitudes, first))])


EXPERIMENTS = {
    "table1": Experiment("Foot in the air, 0.05 m high in 0.5 s", air_cases, _air),
    "table2": Experiment("1.5 m at 0.05 m/s on flat and irregular ground", walk_cases, _walks),
}
