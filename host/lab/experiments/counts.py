"""Slopes, steps and payload (paper A, sections 4.1.3 and 4.1.4): how many trials pass, and how well."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from sim2d.terrain import RUN_OUT_M

from ...robot.model import KNEE_CONFIGURATIONS
from ...sim.grounds import GroundSpec, make_terrain
from ...sim.walk import WalkSpec
from . import plots
from .case import Case, Experiment, Found, Picture, Row, Table, by_simulator
from .data import assumptions, papers
from .trials import PLANE, SPACE, Answer, Options, drawn, most_loaded, trials, with_knees

ANGLES_DEG = (5.34, 10.0, 15.0)
HEIGHTS_M = (0.02, 0.03, 0.04, 0.05, 0.06)
LOADS_KG = (0.0, 0.5, 1.0, 2.0)
SLOPES, OFFSETS, WALKS = 10, 10, 3  # trials of a slope, start offsets of a step at each friction, trials of a payload
SPEED_M_S = 0.05
STEP_START_M = 0.30
PLATEAU_M = 0.45
# A gait that crosses an obstacle one leg at a time may take this long. After backing off 0.17 m from an edge it crawls
# 20 s until it is back; with its tries at the edge that can be more than 30 s without progress.
LIMIT_S = 240.0
# Steps by the name of their ground, in each simulator; an up-and-down step in space is an up step in the plane.
STEPS = {"up": "step-up", "down": "step-down", "box": "box", "over": "step", "angled": "angled", "left": "left"}
SPACE_STEPS = ("over", "angled", "left")


def slope_specs(options: Options, kind: str, angle_deg: float, usual: int = SLOPES,
                speed_m_s: float = SPEED_M_S) -> list[WalkSpec]:
    """Return walks over a slope up onto a plateau, or down from one."""
    ground = GroundSpec(f"slope-{kind}", angle_deg=angle_deg)
    spec = WalkSpec(options.robot, options.gait, speed_m_s, ground, distance_m=make_terrain(ground).finish_x_m or 1.5)
    return [drawn(spec, seed) for seed in options.seeds(usual)]


def step_specs(options: Options, kind: str, height_m: float, speed_m_s: float = SPEED_M_S, usual: int = OFFSETS,
               start_m: float = STEP_START_M, length_m: float | None = None) -> list[WalkSpec]:
    """Return walks over an obstacle from start offsets across a stride, at both frictions.

    A verdict near a limit depends on where the feet happen to be when they meet the edge, so one start proves nothing.
    """
    long_m = length_m or (PLATEAU_M if kind in SPACE_STEPS else None)
    specs = []
    for offset_m, friction, seed in options.starts(usual):
        ground = GroundSpec(STEPS[kind], height_m, start_m=start_m + offset_m, length_m=long_m)
        distance_m = make_terrain(ground).finish_x_m or ground.start_m + RUN_OUT_M
        specs.append(WalkSpec(options.robot, options.gait, speed_m_s, ground, distance_m=distance_m, friction=friction,
                              seed=seed, limit_s=LIMIT_S))
    return specs


def load_specs(options: Options, knees: str, load_kg: float) -> list[WalkSpec]:
    """Return walks of 1.5 m of level ground with a payload, the knees turned as named."""
    robot = with_knees(options.robot, knees)
    spec = WalkSpec(robot, options.gait, SPEED_M_S, distance_m=1.5, payload_kg=load_kg)
    return [drawn(spec, seed) for seed in options.seeds(WALKS)]


def slope_cases(options: Options) -> list[Case]:
    """Return all slopes; the first trial of each keeps its recording."""
    said = {True: "passed", False: "not tried"}
    return [
        Case(f"{angle:g} deg {kind}", {where: trials(where, slope_specs(options, kind, angle), True)
                                       for where in options.simulators},
             paper=said[angle < papers()["ramp"]["passed_deg"] + 0.1], facts={"kind": kind, "angle_deg": angle})
        for angle in ANGLES_DEG for kind in ("up", "down")
    ]


def step_cases(options: Options) -> list[Case]:
    """Return all steps; the first trial of each in the plane keeps its recording. Some are only in space."""
    paper = papers()["steps"]
    said = {**dict.fromkeys(paper["passed_m"], "passed"), **dict.fromkeys(paper["hard_m"], "hard")}
    cases = []
    for kind in STEPS:
        places = [where for where in options.simulators if where == SPACE or kind not in SPACE_STEPS]
        for height_m in HEIGHTS_M if places else ():
            specs = step_specs(options, kind, height_m)
            cases.append(Case(f"{kind} {1000 * height_m:.0f} mm",
                              {where: trials(where, specs, where == PLANE) for where in places},
                              paper=said.get(height_m, "not tried") if kind in ("up", "down") else "not tried",
                              facts={"kind": kind, "height_m": height_m}))
    return cases


def load_cases(options: Options) -> list[Case]:
    """Return all knee configurations with all payloads; the first of each in the plane with the most is kept."""
    return [
        Case(f"{knees}, {load_kg:g} kg",
             {where: trials(where, load_specs(options, knees, load_kg), where == PLANE and load_kg == LOADS_KG[-1])
              for where in options.simulators},
             paper="not passed" if load_kg == LOADS_KG[-1] else "not tried",
             facts={"kind": knees, "payload_kg": load_kg})
        for knees in KNEE_CONFIGURATIONS for load_kg in LOADS_KG
    ]


def counted(answers: list[Answer]) -> dict[str, Any]:
    """Return a case's figures: passes, mean speed of those that arrived, the worst joint of all, and the failures."""
    speeds = [float(answer.figures["mean_speed_m_s"]) for answer in answers if answer.ok]
    joint, share = max((most_loaded(answer.figures) for answer in answers), key=lambda pair: pair[1])
    told = ("seed", "start_m", "friction")
    return {
        "passed": len(speeds), "trials": len(answers),
        "mean_speed_m_s": round(sum(speeds) / len(speeds), 5) if speeds else None,
        "most_loaded_joint": joint, "torque_rms_fraction": share,
        **{f"{axis}_range_deg": max((float(answer.figures[f"{axis}_range_deg"]) for answer in answers
                                     if f"{axis}_range_deg" in answer.figures), default=None)
           for axis in ("pitch", "roll")},
        "failures": [{**{key: answer.figures[key] for key in told}, "reason": answer.figures["reason"]}
                     for answer in answers if not answer.ok],
    }


@dataclass(frozen=True)
class View:
    """How to show counts: the x axis (a fact of the cases and its scale), the figure over it, and a limit."""

    name: str
    title: str
    x_label: str
    fact: str
    scale: float = 1.0
    y_label: str = "passed, %"
    height: Callable[[dict[str, Any]], float] = lambda part: 100 * part["passed"] / part["trials"]
    limit: float | None = None


def sum_up(view: View, options: Options, rows: list[Row]) -> Found:
    """Return passes, speeds and the most loaded joint of every case, and the figure over the x axis."""
    found = [by_simulator(row, counted) for row in rows]
    text = []
    for row, case in zip(rows, found, strict=True):
        failures = [failure for part in (case["plane"], case["three_d"]) if part for failure in part["failures"]]
        text.append((row.case.name, *_cells(case["plane"]), *_cells(case["three_d"]), str(row.case.paper),
                     failures[0]["reason"] if failures else ""))
    head = ("", "plane", "m/s", "worst joint", "3-D", "m/s", "worst joint", "paper", "first failure")
    lines: dict[str, plots.Lines] = {where: {} for where in options.simulators}
    for case in found:
        for where, part in ((PLANE, case["plane"]), (SPACE, case["three_d"])):
            if part:
                point = (view.scale * case[view.fact], view.height(part))
                lines[where].setdefault(case["kind"], []).append(point)
    pictures = [Picture(f"{view.name}.png", view.title,
                        partial(plots.lines, lines, view.x_label, view.y_label, view.limit))]
    kept = [(row.case.name, row.answers[options.simulators[-1]][0]) for row in rows
            if row.answers[options.simulators[-1]][0].recording is not None]
    if kept:
        pictures.append(Picture(f"{view.name}_attitude.png", "Attitude over time, first trial of each",
                                partial(plots.attitudes, kept)))
    return Found({"results": found}, [Table(f"{view.title}: passed, mean speed of those; torque rms, of stall", head,
                                            text)], pictures)


def _cells(part: dict[str, Any] | None) -> Sequence[str]:
    if part is None:
        return "-", "-", "-"
    speed = part["mean_speed_m_s"]
    return (f"{part['passed']}/{part['trials']}", "-" if speed is None else f"{speed:.4f}",
            f"{100 * part['torque_rms_fraction']:.0f} % {part['most_loaded_joint']}")


RAMP = View("ramp", "Slopes of 0.8 m", "slope, deg", "angle_deg")
STEP = View("steps", "Steps from start offsets across a stride", "height, mm", "height_m", 1000.0)
LOAD = View("payload", "Payload over 1.5 m", "payload, kg", "payload_kg", 1.0,
            "most loaded joint, torque rms, % of stall", lambda part: 100 * part["torque_rms_fraction"],
            100 * assumptions()["payload"]["largest_torque_rms"])
EXPERIMENTS = {
    "ramp": Experiment("Slopes up and down", slope_cases, partial(sum_up, RAMP)),
    "steps": Experiment("Steps up and down, boxes to step over", step_cases, partial(sum_up, STEP)),
    "payload": Experiment("Payload in each knee configuration", load_cases, partial(sum_up, LOAD)),
}
