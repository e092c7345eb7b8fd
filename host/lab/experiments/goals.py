"""The figures this project wants to reach, each beside what the papers' robot did, in the plane and in space.

Not an experiment of the papers: it gathers the same trials to say of each goal whether it is met.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from ...robot.model import KNEE_CONFIGURATIONS
from ...sim.export.ground import Ground, extrude
from ...sim.walk import WalkSpec
from . import payload, ramp, steps
from .data import assumptions
from .outcome import Outcome, Table, rate
from .trials import Answer, Options, PlaneTrial, SpaceTrial, trial_conditions

Trial = PlaneTrial | SpaceTrial
# What a goal says of its answers: met, not met, or None where it is only reported; and a figure.
Verdict = tuple[bool | None, str]

SEEDS = 10
FLAT_SEEDS = 3


@dataclass(frozen=True)
class Goal:
    """One figure to reach, the trials it takes, and how they are judged."""

    where: str
    name: str
    paper: str
    trials: list[Trial]
    judge: Callable[[list[Answer]], Verdict]


def every(answers: list[Answer]) -> Verdict:
    """Met if all trials passed."""
    return all(answer.ok for answer in answers), rate(answers)


def nearly(answers: list[Answer]) -> Verdict:
    """Met if 95 % passed."""
    return sum(answer.ok for answer in answers) >= 0.95 * len(answers), rate(answers)


def reported(answers: list[Answer]) -> Verdict:
    """Only told."""
    return None, rate(answers)


def within(**limits: tuple[float, float]) -> Callable[[list[Answer]], Verdict]:
    """Return a judge: met if all trials passed and every figure of theirs lies in its limits."""

    def judge(answers: list[Answer]) -> Verdict:
        met, parts = all(answer.ok for answer in answers), []
        for key, (low, high) in limits.items():
            values = [float(answer.figures[key]) for answer in answers]
            met = met and all(low <= value <= high for value in values)
            told = f"{min(values):.4g}" if len(values) == 1 else f"{min(values):.4g} .. {max(values):.4g}"
            parts.append(f"{key} {told}")
        return met, f"{rate(answers)}, {', '.join(parts)}"

    return judge


def carries(most: float) -> Callable[[list[Answer]], Verdict]:
    """Return a judge: met if one knee configuration at least walks with no joint above ``most`` of stall."""
    return partial(_carries, most)


def _carries(most: float, answers: list[Answer]) -> Verdict:
    worst = [payload.verdict([answer]) for answer in answers]
    good = [case["passed"] == 1 and case["torque_rms_fraction"] <= most for case in worst]
    told = [f"{knees} {'walks' if case['passed'] else 'fails'} {100 * case['torque_rms_fraction']:.0f} %"
            for knees, case in zip(KNEE_CONFIGURATIONS, worst, strict=True)]
    return any(good), ", ".join(told)


def plane_goals(options: Options) -> list[Goal]:
    """Return what is wanted in the plane."""

    def flat(speed: float) -> list[Trial]:
        return [PlaneTrial(WalkSpec(options.robot, options.gait, speed, seed=seed))
                for seed in range(options.count(FLAT_SEEDS))]

    stones: list[Trial] = [PlaneTrial(WalkSpec(options.robot, options.gait, terrain="stones", seed=seed))
                           for seed in range(options.count(SEEDS))]
    goals = [
        Goal("plane", "flat at 0.05 m/s: 0.0485 .. 0.0515 m/s", "0.033 m/s", flat(0.05),
             within(speed_m_s=(0.0485, 0.0515))),
        Goal("plane", "flat at 0.10 m/s: at least 0.09 m/s", "-", flat(0.10), within(speed_m_s=(0.09, 0.11))),
        Goal("plane", "pitch range on fixed stones of 12 mm: at most 5 deg", "13 deg", stones,
             within(pitch_range_deg=(0.0, 5.0))),
    ]
    goals += [Goal("plane", f"{angle:g} deg {kind}", "5.34 deg", _ramp(options, angle, kind, "plane"), judge)
              for angle, judge in ((10.0, every), (15.0, reported)) for kind in ramp.KINDS]
    goals += _steps(options, "plane", "up", {0.02: every, 0.03: every, 0.04: every, 0.05: nearly, 0.06: reported})
    goals += _steps(options, "plane", "box", {0.04: every})
    loads = [payload.trial(options, knees, 2.0, 0, False) for knees in KNEE_CONFIGURATIONS]
    goals.append(Goal("plane", "2 kg over 1.5 m, no joint above 40 % of stall rms", "failed", loads,
                      carries(assumptions()["payload"]["largest_torque_rms"])))
    return goals


def _ramp(options: Options, angle_deg: float, kind: str, where: str) -> list[Trial]:
    ground = ramp.slope(angle_deg, kind)
    specs = [WalkSpec(options.robot, options.gait, distance_m=ground.finish_x_m or 1.5,
                      **trial_conditions(options.robot, seed))  # type: ignore[arg-type]
             for seed in range(options.count(SEEDS))]
    if where == "plane":
        return [PlaneTrial(spec, ground) for spec in specs]
    return [SpaceTrial(spec, extrude(ground)) for spec in specs]


def _steps(
    options: Options, where: str, kind: str, judges: dict[float, Callable[[list[Answer]], Verdict]]
) -> list[Goal]:
    paper = {0.02: "passed", 0.04: "sometimes", 0.05: "hard"} if kind in ("up", "down") else {}
    return [
        Goal(where, f"{kind} {1000 * height_m:.0f} mm, all starts and frictions", paper.get(height_m, "-"),
             [steps.trial(options, (where, kind, height_m), i, offset_m, friction)
              for i, (offset_m, friction) in enumerate(steps.conditions(options))], judge)
        for height_m, judge in judges.items()
    ]


def space_goals(options: Options) -> list[Goal]:
    """Return what is wanted in three dimensions."""
    flat = Ground("flat")

    def walk(speed: float = 0.05, **more: Any) -> list[Trial]:
        return [SpaceTrial(WalkSpec(options.robot, options.gait, speed, seed=seed, **more), flat)
                for seed in range(options.count(FLAT_SEEDS))]

    goals = [
        Goal("3-D", "flat at 0.05 m/s: speed, tilt, yaw and sideways drift", "0.033 m/s, 8.7 and 8.3 deg", walk(),
             within(speed_m_s=(0.048, 0.055), roll_range_deg=(0, 3.5), pitch_range_deg=(0, 3.5),
                    yaw_drift_deg=(-3, 3), side_drift_m=(-0.03, 0.03))),
        Goal("3-D", "flat at 0.10 m/s: at least 0.09 m/s", "-", walk(0.10), within(speed_m_s=(0.09, 0.12))),
        Goal("3-D", "supply 11.1 V and 60 ms of bus delay: no fall", "-", walk(voltage_V=11.1, bus_delay_s=0.06),
             every),
        Goal("3-D", "2 kg over 1.5 m in a knee configuration: no fall", "failed",
             [payload.trial(options, knees, 2.0, 0, True) for knees in KNEE_CONFIGURATIONS], carries(1.0)),
    ]
    goals += [Goal("3-D", f"10 deg {kind}", "5.34 deg", _ramp(options, 10.0, kind, "3-D"), every)
              for kind in ramp.KINDS]
    for kind in ("up", "down"):
        goals += _steps(options, "3-D", kind, {0.04: every, 0.05: nearly, 0.06: reported})
    goals += _steps(options, "3-D", "over", {0.04: every, 0.05: nearly})
    for kind in ("angled", "left"):
        goals += _steps(options, "3-D", kind, {0.02: reported, 0.04: reported})
    return goals


def goals(options: Options) -> list[Goal]:
    """Return all goals that can be judged here."""
    return plane_goals(options) + (space_goals(options) if options.in_space else [])


def tasks(options: Options) -> list[Trial]:
    """Return all goals' trials."""
    return [trial for goal in goals(options) for trial in goal.trials]


def evaluate(options: Options, answers: list[Answer]) -> Outcome:
    """Return one row for each goal."""
    rows, text, at = [], [], 0
    words = {True: "met", False: "not met", None: "reported"}
    for goal in goals(options):
        own = answers[at : at + len(goal.trials)]
        at += len(goal.trials)
        met, told = goal.judge(own)
        failures = [answer.figures["reason"] for answer in own if not answer.ok]
        rows.append({"where": goal.where, "goal": goal.name, "met": met, "figure": told, "paper": goal.paper,
                     "failures": failures})
        text.append((goal.where, goal.name, words[met], told, goal.paper))
    table = Table(f"Goals, gait {options.gait}", ("", "", "", "figure", "paper"), text)
    return Outcome("goals", "Figures to reach", {"experiment": "goals", "gait": options.gait, "goals": rows}, [table])
