"""Table 2 of paper A: 1.5 m at 0.05 m/s on flat and irregular ground, with and without balance."""

from functools import partial
from typing import Any

from ...sim.space.grounds import GroundSpec, make_ground
from ...sim.walk import WalkSpec
from . import compare, plots
from .data import papers
from .outcome import Film, Outcome, Picture, Table, film, p_value
from .trials import Answer, Options, PlaneTrial, SpaceTrial, trial_conditions

QUANTITIES = ("speed_m_s", "roll_range_deg", "pitch_range_deg")
_NAMES = {"speed_m_s": ("speed, m/s", 4), "roll_range_deg": ("roll, deg", 1),
          "pitch_range_deg": ("pitch, deg", 1)}


def tasks(options: Options) -> list[PlaneTrial | SpaceTrial]:
    """Return the four cases' trials in the plane, then in space; the first of each is kept."""
    found: list[PlaneTrial | SpaceTrial] = []
    for in_space in (False, True) if options.in_space else (False,):
        for case in papers()["table2"]["case"]:
            for seed in range(options.count(case["n"])):
                spec = _spec(options, case, seed)
                if in_space:
                    ground = make_ground(GroundSpec(case["terrain"], seed=seed, start_m=0.25, length_m=1.8))
                    found.append(SpaceTrial(spec, ground, keep=seed == 0))
                else:
                    found.append(PlaneTrial(spec, keep=seed == 0))
    return found


def _spec(options: Options, case: dict[str, Any], seed: int) -> WalkSpec:
    course = papers()["table2"]
    return WalkSpec(
        options.robot, options.gait, course["speed_m_s"], case["terrain"], distance_m=course["distance_m"],
        balance=case["balance"], **trial_conditions(options.robot, seed),  # type: ignore[arg-type]
    )


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return the four cases, the t-tests between them, the attitude's picture and the films."""
    cases, at, found = papers()["table2"]["case"], 0, []
    for _ in (0, 1) if options.in_space else (0,):
        for case in cases:
            count = options.count(case["n"])
            found.append(answers[at : at + count])
            at += count
    plane, space = found[: len(cases)], found[len(cases) :]
    result = {
        "experiment": "table2",
        "gait": options.gait,
        "cases": [_case(case, plane[i], space[i] if space else None) for i, case in enumerate(cases)],
        "t_tests": [row for i in (0, 2) for row in _t_tests(cases[i : i + 2], plane[i : i + 2], space[i : i + 2])],
    }
    named = [(case["name"], series[0]) for case, series in zip(cases, space or plane, strict=True)]
    picture = Picture("table2.png", "Attitude over time, first trial of each case", partial(plots.attitudes, named))
    films: list[Film] = []
    for case, series in zip(cases, plane, strict=True):
        films += film(f"{options.gait}: {case['name']}", series[0])
    title = "1.5 m at 0.05 m/s on flat and irregular ground"
    return Outcome("table2", title, result, _tables(result), [picture], films)


def _sample(answers: list[Answer], key: str) -> compare.Sample | None:
    """Return a figure's sample over the trials that arrived, None if none did."""
    values = [float(answer.figures[key]) for answer in answers if answer.ok]
    return compare.sample(values) if values else None


def _json(sample: compare.Sample | None) -> dict[str, float] | None:
    return None if sample is None else sample.as_json()


def _case(case: dict[str, Any], plane: list[Answer], space: list[Answer] | None) -> dict[str, Any]:
    """Return a case for JSON; figures are of the trials that arrived, roll is of the 3-D check."""
    three_d = None
    if space is not None:
        three_d = {
            "n": len(space),
            "passed": sum(answer.ok for answer in space),
            "speed_m_s": _json(_sample(space, "mean_speed_m_s")),
            "steady_speed_m_s": _json(_sample(space, "speed_m_s")),
            "roll_range_deg": _json(_sample(space, "whole_roll_range_deg")),
            "pitch_range_deg": _json(_sample(space, "whole_pitch_range_deg")),
        }
    return {
        "name": case["name"],
        "n": len(plane),
        "passed": sum(answer.ok for answer in plane),
        "speed_m_s": _json(_sample(plane, "mean_speed_m_s")),
        "steady_speed_m_s": _json(_sample(plane, "speed_m_s")),
        "pitch_range_deg": _json(_sample(plane, "pitch_range_deg")),
        "roll_range_deg": three_d and three_d["roll_range_deg"],
        "three_d": three_d,
        "paper": {"n": case["n"], **{quantity: case[quantity] for quantity in QUANTITIES}},
    }


def _t_tests(cases: list[dict[str, Any]], plane: list[list[Answer]], space: list[list[Answer]]) -> list[dict[str, Any]]:
    """Return whether balance changes speed, roll and pitch: here in both simulators, and in the paper."""
    rows = []
    for quantity in QUANTITIES:
        theirs = [compare.published(case["n"], case[quantity]) for case in cases]
        ours = {}
        for name, series in (("plane", [] if quantity == "roll_range_deg" else plane), ("three_d", space)):
            key = "mean_speed_m_s" if quantity == "speed_m_s" else "whole_" * (name == "three_d") + quantity
            samples = [_sample(answers, key) for answers in series]
            pair = (samples[0], samples[1]) if len(samples) == 2 else (None, None)
            ours[name] = None if pair[0] is None or pair[1] is None else compare.t_test(pair[0], pair[1])
        paper = compare.t_test(theirs[0], theirs[1])
        printed = papers()["table2"]["printed_p"][cases[0]["terrain"]] if quantity == "roll_range_deg" else None
        rows.append({"terrain": cases[0]["terrain"], "quantity": quantity, "p_two_sided": ours["plane"],
                     "three_d_p_two_sided": ours["three_d"], "paper_p_two_sided": paper, "paper_p_printed": printed})
    return rows


def _tables(result: dict[str, Any]) -> list[Table]:
    rows: list[tuple[str, ...]] = []
    for case in result["cases"]:
        space, paper = case["three_d"] or {}, case["paper"]
        passed = f"{space['passed']}/{space['n']}" if space else "-"
        rows.append((case["name"], "arrived", f"{case['passed']}/{case['n']}", passed, f"n = {paper['n']}"))
        for quantity, (name, digits) in _NAMES.items():
            plane = None if quantity == "roll_range_deg" else case[quantity]
            rows.append(("", name, *(_text(found, digits) for found in (plane, space.get(quantity), paper[quantity]))))
    tests = [(row["terrain"], _NAMES[row["quantity"]][0].partition(",")[0], *(p_value(row[key]) for key in (
        "p_two_sided", "three_d_p_two_sided", "paper_p_two_sided", "paper_p_printed"))) for row in result["t_tests"]]
    return [
        Table(f"1.5 m at 0.05 m/s, gait {result['gait']}: mean (sd) of those that arrived; ranges of roll and pitch",
              ("", "", "plane", "3-D", "paper"), rows),
        Table("Does balance change it? Two-sided p of Student's t-test",
              ("ground", "", "plane", "3-D", "paper, recomputed", "printed (one-sided)"), tests),
    ]


def _text(quantity: dict[str, float] | None, digits: int) -> str:
    return "-" if not quantity else f"{quantity['mean']:.{digits}f} ({quantity['sd']:.{digits}f})"
