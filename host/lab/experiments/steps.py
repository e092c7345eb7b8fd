"""Steps up, steps down and boxes to step over (paper A, section 4.1.4), from start offsets across one stride.

A verdict near a limit flips with where the feet happen to be when they meet the edge, so one start proves nothing.
In space three more go up and, 0.45 m later, down again: a step met squarely, one at 20 degrees, one under the left
legs only.
"""

from functools import partial
from typing import Any

from sim2d import terrain
from sim2d.terrain import Terrain

from ...sim.export.ground import Ground, extrude
from ...sim.space.grounds import GroundSpec, make_ground
from ...sim.walk import WalkSpec
from . import plots
from .data import papers
from .outcome import Film, Outcome, Picture, Table, film
from .trials import Answer, Options, PlaneTrial, SpaceTrial

HEIGHTS_M = (0.02, 0.03, 0.04, 0.05, 0.06)
KINDS = ("up", "down", "box")
SPACE_KINDS = ("over", "angled", "left")
FRICTIONS = (0.6, 0.9)
OFFSETS = 10
STRIDE_M = 0.10  # paper A: 0.05 m/s in cycles of 2 s
START_M = 0.30
BOX_M = 0.06
SPEED_M_S = 0.05
# A gait that takes an obstacle one leg at a time may take this long. Having backed off 0.17 m from an edge it crawls
# 20 s until it is where it was; with its tries at the edge that may be more than 30 s without a gain.
LIMIT_S = 240.0
STUCK_S = 45.0
RUN_OUT_M = terrain.RUN_OUT_M


def course(kind: str, height_m: float, start_m: float) -> Terrain:
    """Return a step up, a step down, or a box in the plane."""
    if kind == "box":
        return terrain.box(height_m, start_m, BOX_M)
    return terrain.step(height_m if kind == "up" else -height_m, start_m, None)


def conditions(options: Options) -> list[tuple[float, float]]:
    """Return (offset, friction) of each trial of a height: offsets across one stride at each friction."""
    count = options.count(OFFSETS)
    return [(round(STRIDE_M * i / count, 5), friction) for friction in FRICTIONS for i in range(count)]


def groups(options: Options) -> list[tuple[str, str, float]]:
    """Return (where, kind, height) of each group of trials, in order."""
    found = [("plane", kind, height) for kind in KINDS for height in HEIGHTS_M]
    if options.in_space:
        found += [("3-D", kind, height) for kind in (*KINDS, *SPACE_KINDS) for height in HEIGHTS_M]
    return found


def tasks(options: Options) -> list[PlaneTrial | SpaceTrial]:
    """Return the trials of all groups; the first of each is kept."""
    return [trial(options, group, i, offset_m, friction)
            for group in groups(options) for i, (offset_m, friction) in enumerate(conditions(options))]


def trial(
    options: Options, group: tuple[str, str, float], index: int, offset_m: float, friction: float
) -> PlaneTrial | SpaceTrial:
    """Return one trial of a group."""
    where, kind, height_m = group
    start_m = START_M + offset_m
    ground = space_ground(kind, height_m, start_m) if where == "3-D" else None
    plane = course("up" if kind in SPACE_KINDS else kind, height_m, start_m)
    longer_m = 0.45 if kind in SPACE_KINDS else 0.0
    spec = WalkSpec(
        options.robot, options.gait, SPEED_M_S, distance_m=(plane.finish_x_m or 1.0) + longer_m, friction=friction,
        seed=index, limit_s=LIMIT_S, stuck_after_s=STUCK_S,
    )
    if ground is not None:
        return SpaceTrial(spec, ground)
    return PlaneTrial(spec, plane, keep=index == 0)


def space_ground(kind: str, height_m: float, start_m: float) -> Ground:
    """Return the ground of a kind in space."""
    if kind in SPACE_KINDS:
        return make_ground(GroundSpec("step" if kind == "over" else kind, height_m, start_m=start_m))
    return extrude(course(kind, height_m, start_m))


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return how many passed of each height and kind, and where the others failed."""
    tried, found = conditions(options), {}
    for i, group in enumerate(groups(options)):
        found[group] = answers[i * len(tried) : (i + 1) * len(tried)]
    counted = {group: verdict(tried, series) for group, series in found.items()}
    rows = [
        {"height_m": height_m, "kind": kind, "gait": options.gait, **counted["plane", kind, height_m],
         "three_d": counted.get(("3-D", kind, height_m))}
        for kind in KINDS for height_m in HEIGHTS_M
    ]
    only_space = [
        {"height_m": height_m, "kind": kind, "gait": options.gait, **counted["3-D", kind, height_m]}
        for kind in SPACE_KINDS for height_m in HEIGHTS_M if ("3-D", kind, height_m) in counted
    ]
    result = {"experiment": "steps", "gait": options.gait, "paper": papers()["steps"], "results": rows,
              "three_d_only": only_space}
    lines: dict[str, list[tuple[float, float]]] = {}
    for (where, kind, height_m), row in counted.items():
        lines.setdefault(f"{where} {kind}", []).append((1000 * height_m, row["passed"] / row["trials"]))
    picture = Picture("steps.png", "Pass rate over height", partial(plots.pass_rates, "height, mm", lines))
    films: list[Film] = []
    for (where, kind, height_m), series in found.items():
        if where == "plane" and height_m in (0.04, 0.05):
            films += film(f"{options.gait}: {kind}, {1000 * height_m:.0f} mm", series[0])
    title = "Steps up and down, boxes to step over"
    return Outcome("steps", title, result, [_table(rows, only_space)], [picture], films)


def verdict(tried: list[tuple[float, float]], answers: list[Answer]) -> dict[str, Any]:
    """Return a group's count and its failures, each with where it started and why it ended."""
    return {
        "passed": sum(answer.ok for answer in answers),
        "trials": len(answers),
        "failures": [
            {"offset_m": offset_m, "friction": friction, "reason": answer.figures["reason"]}
            for (offset_m, friction), answer in zip(tried, answers, strict=True) if not answer.ok
        ],
    }


def _table(rows: list[dict[str, Any]], only_space: list[dict[str, Any]]) -> Table:
    paper, text = papers()["steps"], []
    said = {**dict.fromkeys(paper["passed_m"], "passed"), **dict.fromkeys(paper["hard_m"], "hard")}
    for row in rows:
        space = row["three_d"]
        text.append((f"{row['kind']} {1000 * row['height_m']:.0f} mm", f"{row['passed']}/{row['trials']}",
                     f"{space['passed']}/{space['trials']}" if space else "-",
                     said.get(row["height_m"], "not tried") if row["kind"] != "box" else "not tried",
                     _why(row if row["failures"] or not space else space)))
    for row in only_space:
        text.append((f"{row['kind']} {1000 * row['height_m']:.0f} mm", "-", f"{row['passed']}/{row['trials']}",
                     "not tried", _why(row)))
    return Table("Passed, over all start offsets and both frictions", ("", "plane", "3-D", "paper", "first failure"),
                 text)


def _why(row: dict[str, Any]) -> str:
    return row["failures"][0]["reason"] if row["failures"] else ""
