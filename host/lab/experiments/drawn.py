"""Robots that chose no constant of the gaits: drawn at random, written like `caramelo robots new` writes them, walked.

Shares are of the leg, of the robot's mass, or of what a servo needs to carry it (m g L) and to swing it (sqrt(g / L)).
Their ranges are those of the known robots and a little wider. A robot that `robots check` refuses is drawn anew.
"""

import math
import random
from collections.abc import Iterator
from functools import partial
from itertools import count, islice

from sim2d.model import GRAVITY_M_S2

from ...robot.ability import ability, cannot
from ...robot.file import checked
from ...robot.model import KNEE_CONFIGURATIONS, Robot
from ...robot.new_robot import OTHER, Answers, new_file
from ...sim.grounds import GroundSpec, make_terrain
from ...sim.walk import WalkSpec
from ...util.errors import UserError
from ...util.files import parse_toml
from .case import Case, Experiment, Found, Row
from .trials import SPACE, Options, Trial, trials
from .verdicts import share, sum_up

ROBOTS = 40
LEG_M = (0.12, 0.7)
MASS_KG_M2 = (20.0, 80.0)  # per square of the leg: Solo 12 has 24, A1 75
STALL, SPEED = (0.25, 1.2), (0.6, 4.0)  # Caramelo has 0.48 and 0.9
STEP_SHARE = 0.8  # of the step that `robots check` states
CLIMB_FROUDE = 0.1  # of sqrt(g h): the speed over edges (chosen)
BAR_LENGTH_M, EDGE_M, LIMIT_S = 0.06, 0.5, 120.0
CRAWL_M_S, CRAWL_M = 0.02, 0.3


def answers(seed: int) -> Answers:
    """Return what a person with the robot of this seed would answer to `caramelo robots new`."""
    draw = random.Random(f"robot {seed}")

    def even(low: float, high: float) -> float:
        return math.exp(draw.uniform(math.log(low), math.log(high)))

    leg_m = even(*LEG_M)
    mass_kg = even(*MASS_KG_M2) * leg_m**2
    thigh, in_legs = draw.uniform(0.44, 0.56), draw.uniform(0.15, 0.5)
    parts = [draw.uniform(*ends) for ends in ((0.2, 0.4), (0.35, 0.55), (0.1, 0.25))]
    hip_kg, thigh_kg, calf_kg = (round(in_legs * mass_kg / 4 * part / sum(parts), 4) for part in parts)
    lengths = {"front_rear": (0.8, 1.4), "left_right": (0.35, 0.8), "hip_offset": (0.05, 0.35),
               "foot_radius": (0.03, 0.07), "height": (0.62, 0.85)}
    return {
        "name": f"drawn-{seed}", "thigh": round(thigh * leg_m, 4), "calf": round((1 - thigh) * leg_m, 4),
        **{name: round(draw.uniform(*ends) * leg_m, 4) for name, ends in lengths.items()},
        "knees": draw.choice(KNEE_CONFIGURATIONS), "calf_motor": draw.choice(("thigh", "body")),
        "trunk_mass": round((1 - in_legs) * mass_kg, 3), "hip_mass": hip_kg, "thigh_mass": thigh_kg,
        "calf_mass": calf_kg, "joints": OTHER, "model": "drawn", "volts": 12.0,
        "stall": round(even(*STALL) * mass_kg * GRAVITY_M_S2 * leg_m, 3),
        "rpm": round(even(*SPEED) * math.sqrt(GRAVITY_M_S2 / leg_m) * 60 / math.tau, 1),
    }


def robots(options: Options) -> Iterator[Robot]:
    """Return as many robots as asked for that `robots check` lets walk, always the same."""
    wanted = options.seeds(ROBOTS)
    drawn = (_walkable(seed, options.robot.simulation.honest) for seed in count(10 * wanted.start))
    return islice((robot for robot in drawn if robot), len(wanted))


def _walkable(seed: int, honest: bool) -> Robot | None:
    """Return the robot of a seed; None if its answers do not go together, or it can't walk."""
    try:
        robot = checked(parse_toml(new_file(answers(seed))), f"drawn robot {seed}").simulated(honest)
    except UserError:
        return None
    return None if any(cannot(robot, ability(robot))) else robot


def walks(robot: Robot, gait: str) -> dict[str, WalkSpec]:
    """Return a robot's walks by their case: what its file lets it do, and what the check says that it can."""
    speeds, step_m = robot.speed_limits, STEP_SHARE * ability(robot).step_m
    ahead_m_s, turn_rad_s = speeds.vx_m_s, 0.8 * speeds.wz_rad_s
    climb_m_s = min(ahead_m_s, CLIMB_FROUDE * math.sqrt(GRAVITY_M_S2 * robot.stance.rest_height_m))
    edges = {"a step up": GroundSpec("step-up", step_m, start_m=EDGE_M),
             "a step down": GroundSpec("step-down", step_m, start_m=EDGE_M),
             "a bar across the way": GroundSpec("box", step_m, start_m=EDGE_M, length_m=BAR_LENGTH_M)}
    walk, crawl = (partial(WalkSpec, robot, name, limit_s=LIMIT_S) for name in (gait, "crawl"))
    return {
        "level ground at top speed": walk(ahead_m_s, distance_m=min(20.0, 10 * ahead_m_s)),
        "at a third of it": walk(max(0.005, ahead_m_s / 3), distance_m=max(0.06, 3 * ahead_m_s), friction=0.6),
        "backwards": walk(0.8 * ahead_m_s, distance_m=8 * ahead_m_s, way="back"),
        "turning": walk(turn_rad_s, distance_m=8 * turn_rad_s, way="turn"),
        "in the crawl": crawl(CRAWL_M_S, distance_m=CRAWL_M),
        **{name: walk(climb_m_s, ground, distance_m=make_terrain(ground).finish_x_m or 1.0)
           for name, ground in edges.items()},
    }


def cases(options: Options) -> list[Case]:
    """Return one case for each walk, with a trial for each robot; all in space, or raise UserError."""
    if not options.in_space:
        raise UserError("experiment drawn: its walks are all in three dimensions")
    specs = [walks(robot, options.gait) for robot in robots(options)]
    return [Case(name, {SPACE: trials(SPACE, [each[name] for each in specs])}, judge=share(None)) for name in specs[0]]


def _sum_up(options: Options, rows: list[Row]) -> Found:
    found = sum_up("Robots drawn at random: how many arrive", options, rows)
    found.result["robot"] = "drawn"
    for shown, row in zip(found.result["rows"], rows, strict=True):
        pairs = zip(row.case.trials[SPACE], row.answers[SPACE], strict=True)
        shown["failures"] = {trial.spec.robot.name: answer.figures["reason"]
                             for trial, answer in pairs if isinstance(trial, Trial) and not answer.ok}
    return found


EXPERIMENT = Experiment("Robots drawn at random", cases, _sum_up)
