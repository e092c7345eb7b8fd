"""Slopes (paper A, section 4.1.3): 5.34, 10 and 15 degrees, up onto a plateau and down from one."""

import math
from functools import partial
from typing import Any

from sim2d.terrain import AHEAD_M, BEHIND_M, RUN_OUT_M, Terrain

from ...sim.export.ground import extrude
from ...sim.walk import WalkSpec
from . import plots
from .data import papers
from .outcome import Film, Outcome, Picture, Table, figure, film
from .trials import Answer, Options, PlaneTrial, SpaceTrial, trial_conditions

ANGLES_DEG = (5.34, 10.0, 15.0)
KINDS = ("up", "down")
SPEED_M_S = 0.05
LENGTH_M = 0.8
START_M = 0.35
TRIALS = 10


def slope(angle_deg: float, kind: str) -> Terrain:
    """Return level ground, LENGTH_M of slope up or down from START_M on, and level ground again."""
    run_m = LENGTH_M * math.cos(math.radians(angle_deg))
    rise_m = LENGTH_M * math.sin(math.radians(angle_deg)) * (1 if kind == "up" else -1)
    end_m = START_M + run_m
    points = ((-BEHIND_M, 0.0), (START_M, 0.0), (end_m, rise_m), (end_m + AHEAD_M, rise_m))
    return Terrain(f"ramp {kind}", points, finish_x_m=end_m + RUN_OUT_M)


def tasks(options: Options) -> list[PlaneTrial | SpaceTrial]:
    """Return all slopes' trials in the plane, then in space; the first of each is kept."""
    found: list[PlaneTrial | SpaceTrial] = []
    for in_space in (False, True) if options.in_space else (False,):
        for angle_deg in ANGLES_DEG:
            for kind in KINDS:
                ground = slope(angle_deg, kind)
                for seed in range(options.count(TRIALS)):
                    spec = WalkSpec(
                        options.robot, options.gait, SPEED_M_S, distance_m=ground.finish_x_m or 1.5,
                        **trial_conditions(options.robot, seed),  # type: ignore[arg-type]
                    )
                    keep = seed == 0
                    found.append(SpaceTrial(spec, extrude(ground), keep) if in_space
                                 else PlaneTrial(spec, ground, keep))
    return found


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return how many passed at each slope."""
    count, slopes = options.count(TRIALS), [(angle, kind) for angle in ANGLES_DEG for kind in KINDS]
    series = [answers[i * count : (i + 1) * count] for i in range(len(answers) // count)]
    plane, space = series[: len(slopes)], series[len(slopes) :]
    rows = [_row(angle, kind, options.gait, plane[i], space[i] if space else None)
            for i, (angle, kind) in enumerate(slopes)]
    result = {"experiment": "ramp", "gait": options.gait, "paper_passed_deg": papers()["ramp"]["passed_deg"],
              "results": rows}
    lines = {f"{where} {kind}": [(row["angle_deg"], _share(row if where == "plane" else row["three_d"]))
                                 for row in rows if row["kind"] == kind]
             for where in (("plane", "3-D") if space else ("plane",)) for kind in KINDS}
    picture = Picture("ramp.png", "Pass rate over the slope", partial(plots.pass_rates, "slope, deg", lines))
    named = [(f"{angle:g} deg {kind}", found[0])
             for (angle, kind), found in zip(slopes, space or plane, strict=True)]
    attitude = Picture("ramp_attitude.png", "Attitude over time, first trial of each", partial(plots.attitudes, named))
    films: list[Film] = []
    for (angle, kind), found in zip(slopes, plane, strict=True):
        if angle != ANGLES_DEG[0]:
            films += film(f"{options.gait}: {angle:g} deg {kind}", found[0])
    return Outcome("ramp", "Slopes up and down", result, [_table(rows)], [picture, attitude], films)


def _share(row: dict[str, Any]) -> float:
    return float(row["passed"] / row["trials"])


def _figures(answers: list[Answer]) -> dict[str, Any]:
    arrived = [answer.figures for answer in answers if answer.ok]
    speeds = [float(row["mean_speed_m_s"]) for row in arrived]
    return {
        "passed": len(arrived),
        "trials": len(answers),
        "mean_speed_m_s": round(sum(speeds) / len(speeds), 5) if speeds else None,
        "failures": [{"seed": seed, "reason": answer.figures["reason"]}
                     for seed, answer in enumerate(answers) if not answer.ok],
    }


def _row(angle_deg: float, kind: str, gait: str, plane: list[Answer], space: list[Answer] | None) -> dict[str, Any]:
    return {"angle_deg": angle_deg, "kind": kind, "gait": gait, **_figures(plane),
            "three_d": None if space is None else _figures(space)}


def _table(rows: list[dict[str, Any]]) -> Table:
    passed_deg = papers()["ramp"]["passed_deg"]
    text = []
    for row in rows:
        space = row["three_d"]
        text.append((f"{row['angle_deg']:g} deg {row['kind']}", f"{row['passed']}/{row['trials']}",
                     figure(row["mean_speed_m_s"], 4), f"{space['passed']}/{space['trials']}" if space else "-",
                     figure(space and space["mean_speed_m_s"], 4), "passed" if row["angle_deg"] < passed_deg + 0.1
                     else "not tried"))
    return Table("Slopes of 0.8 m: passed, mean speed of those", ("", "plane", "m/s", "3-D", "m/s", "paper"), text)
