"""Payload over 1.5 m of level ground, in each knee configuration: does it arrive, and how hard do the joints work."""

from functools import partial
from typing import Any

from ...robot.model import KNEE_CONFIGURATIONS
from ...sim.export.ground import Ground
from ...sim.walk import WalkSpec
from . import plots
from .data import assumptions
from .outcome import Film, Outcome, Picture, Table, figure, film
from .trials import Answer, Options, PlaneTrial, SpaceTrial, most_loaded, trial_conditions, with_knees

LOADS_KG = (0.0, 0.5, 1.0, 2.0)
TRIALS = 3
SPEED_M_S = 0.05
DISTANCE_M = 1.5


def tasks(options: Options) -> list[PlaneTrial | SpaceTrial]:
    """Return the trials of all knees and loads in the plane, then in space."""
    found: list[PlaneTrial | SpaceTrial] = []
    for in_space in (False, True) if options.in_space else (False,):
        for knees, load_kg in cases():
            for seed in range(options.count(TRIALS)):
                found.append(trial(options, knees, load_kg, seed, in_space))
    return found


def cases() -> list[tuple[str, float]]:
    """Return (knee configuration, load) of each case."""
    return [(knees, load_kg) for knees in KNEE_CONFIGURATIONS for load_kg in LOADS_KG]


def trial(options: Options, knees: str, load_kg: float, seed: int, in_space: bool) -> PlaneTrial | SpaceTrial:
    """Return one trial."""
    robot = with_knees(options.robot, knees)
    spec = WalkSpec(robot, options.gait, SPEED_M_S, distance_m=DISTANCE_M, payload_kg=load_kg,
                    **trial_conditions(robot, seed))  # type: ignore[arg-type]
    if in_space:
        return SpaceTrial(spec, Ground("flat"))
    return PlaneTrial(spec, keep=seed == 0 and load_kg == LOADS_KG[-1])


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return passes, speeds and the most loaded joint of every case."""
    count = options.count(TRIALS)
    series = [answers[i * count : (i + 1) * count] for i in range(len(answers) // count)]
    plane, space = series[: len(cases())], series[len(cases()) :]
    rows = [
        {"knees": knees, "payload_kg": load_kg, "gait": options.gait, **verdict(plane[i]),
         "three_d": verdict(space[i]) if space else None}
        for i, (knees, load_kg) in enumerate(cases())
    ]
    limit = assumptions()["payload"]["largest_torque_rms"]
    result = {"experiment": "payload", "gait": options.gait, "largest_torque_rms_fraction": limit,
              "paper": {"payload_kg": 2.0, "passed": False}, "results": rows}
    lines = {knees: [(row["payload_kg"], row["torque_rms_fraction"]) for row in rows if row["knees"] == knees]
             for knees in KNEE_CONFIGURATIONS}
    space_lines = {knees: [(row["payload_kg"], row["three_d"]["torque_rms_fraction"]) for row in rows
                           if row["knees"] == knees and row["three_d"]] for knees in KNEE_CONFIGURATIONS}
    draw = partial(plots.loads, lines, space_lines, limit)
    picture = Picture("payload.png", "Most loaded joint over payload", draw)
    films: list[Film] = []
    for (knees, load_kg), found in zip(cases(), plane, strict=True):
        films += film(f"{options.gait}: {load_kg:g} kg, {knees}", found[0])
    return Outcome("payload", "Payload in each knee configuration", result, [_table(rows)], [picture], films)


def verdict(answers: list[Answer]) -> dict[str, Any]:
    """Return a case's figures: the worst joint of all its trials, the mean speed of those that arrived."""
    worst = max((most_loaded(answer.figures) for answer in answers), key=lambda pair: pair[1])
    speeds = [float(answer.figures["mean_speed_m_s"]) for answer in answers if answer.ok]
    rolls = [float(answer.figures["roll_range_deg"]) for answer in answers if "roll_range_deg" in answer.figures]
    return {
        "passed": len(speeds),
        "trials": len(answers),
        "mean_speed_m_s": round(sum(speeds) / len(speeds), 5) if speeds else None,
        "most_loaded_joint": worst[0],
        "torque_rms_fraction": worst[1],
        "pitch_range_deg": max(float(answer.figures["pitch_range_deg"]) for answer in answers),
        "roll_range_deg": max(rolls) if rolls else None,
        "failures": [{"seed": seed, "reason": answer.figures["reason"]}
                     for seed, answer in enumerate(answers) if not answer.ok],
    }


def _table(rows: list[dict[str, Any]]) -> Table:
    text = [(row["knees"], f"{row['payload_kg']:g}", *_cells(row), *_cells(row["three_d"])) for row in rows]
    head = ("knees", "kg", "plane", "m/s", "worst joint", "3-D", "m/s", "worst joint")
    return Table("1.5 m on level ground; torque of the most loaded joint: rms, of stall", head, text)


def _cells(part: dict[str, Any] | None) -> tuple[str, ...]:
    if part is None:
        return "-", "-", "-"
    return (f"{part['passed']}/{part['trials']}", figure(part["mean_speed_m_s"], 4),
            f"{100 * part['torque_rms_fraction']:.0f} % {part['most_loaded_joint']}")
