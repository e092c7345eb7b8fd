"""Table 1 of paper A: a foot in the air, both targets, beside the paper's figures and t-tests."""

from functools import partial
from typing import Any

from . import compare, plots
from .data import papers
from .foot_in_air import AirTrial, Swing
from .outcome import Outcome, Picture, Table, p_value
from .trials import Options, trial_conditions

QUANTITIES = ("time_s", "x_final_m", "y_final_m", "z_max_m")
NAMES = {"time_s": "time, s", "x_final_m": "final x, mm", "y_final_m": "final y, mm", "z_max_m": "highest, mm"}
# The plane has no hips.
_PLANE_LACKS = ("y_final_m",)


def tasks(options: Options) -> list[AirTrial]:
    """Return both cases' trials in the plane, then in space."""
    count = options.count(papers()["table1"]["trials"])
    return [
        AirTrial(options.robot, tuple(case["target_m"]), trial_conditions(options.robot, seed), in_space)
        for in_space in ((False, True) if options.in_space else (False,))
        for case in papers()["table1"]["case"]
        for seed in range(count)
    ]


def evaluate(options: Options, answers: list[Swing]) -> Outcome:
    """Return the table, the t-tests and the picture."""
    cases = papers()["table1"]["case"]
    count = len(answers) // (len(cases) * (2 if options.in_space else 1))
    series = [answers[i * count : (i + 1) * count] for i in range(len(answers) // count)]
    plane = [_samples(swings) for swings in series[: len(cases)]]
    space = [_samples(swings) for swings in series[len(cases) :]]
    result = {
        "experiment": "table1",
        "cases": [_case(case, plane[i], space[i] if space else None, count) for i, case in enumerate(cases)],
        "t_tests": [_t_test(quantity, space or plane, cases) for quantity in ("time_s", "z_max_m")],
    }
    shown = series[len(cases) if space else 0 :]
    title = "Foot in the air, 0.05 m high in 0.5 s"
    draw = partial(plots.swings, [(f"to x {c['target_m'][0]:g}, y {c['target_m'][1]:g} m", s[0])
                                  for c, s in zip(cases, shown, strict=True)])
    picture = Picture("table1.png", "Wanted and done, first trial of each target", draw)
    return Outcome("table1", title, result, _tables(result), [picture])


def _samples(swings: list[Swing]) -> dict[str, compare.Sample]:
    rows = [swing.figures() for swing in swings]
    return {quantity: compare.sample([row[quantity] for row in rows]) for quantity in QUANTITIES}


def _case(case: dict[str, Any], plane: dict[str, compare.Sample], space: dict[str, compare.Sample] | None,
          count: int) -> dict[str, Any]:
    return {
        "target_m": case["target_m"],
        "n": count,
        **{q: None if q in _PLANE_LACKS else plane[q].as_json() for q in QUANTITIES},
        "three_d": None if space is None else {q: space[q].as_json() for q in QUANTITIES},
        "paper": {q: case[q] for q in QUANTITIES},
    }


def _t_test(quantity: str, samples: list[dict[str, compare.Sample]], cases: list[dict[str, Any]]) -> dict[str, Any]:
    trials, printed = papers()["table1"]["trials"], papers()["table1"]["printed_p"]
    theirs = [compare.published(trials, case[quantity]) for case in cases]
    row = compare.comparison(quantity, (samples[0][quantity], samples[1][quantity]), (theirs[0], theirs[1]))
    return {**row, "paper_p_printed": printed[quantity]}


def _tables(result: dict[str, Any]) -> list[Table]:
    rows = []
    for case in result["cases"]:
        x, y = case["target_m"]
        for quantity in QUANTITIES:
            scale, digits = (1.0, 4) if quantity == "time_s" else (1000.0, 2)
            columns = [_text(part and part[quantity], scale, digits)
                       for part in (case, case["three_d"], case["paper"])]
            rows.append((f"{x:g}, {y:g}", NAMES[quantity], *columns))
    tests = [(NAMES[row["quantity"]].partition(",")[0], p_value(row["p_two_sided"]),
              p_value(row["paper_p_two_sided"]), p_value(row["paper_p_printed"])) for row in result["t_tests"]]
    count = result["cases"][0]["n"]
    return [
        Table(f"Foot in the air, {count} trials each: mean (sd)", ("target, m", "", "plane", "3-D", "paper"), rows),
        Table("Do the targets differ? Two-sided p of Student's t-test", ("", "here", "paper, recomputed", "printed"),
              tests),
    ]


def _text(quantity: dict[str, float] | None, scale: float, digits: int) -> str:
    if not quantity:
        return "-"
    return f"{quantity['mean'] * scale:.{digits}f} ({quantity['sd'] * scale:.{digits}f})"
