"""The goals of tuning: their walks, each with ground and conditions from its seed, and their score.

Speeds, heights and loads follow from leg and mass alone, so robots that differ only in searched values walk the same.
"""

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from sim2d.model import GRAVITY_M_S2

from ...robot.actuators import Bldc, Servo
from ...robot.drives import STIFFNESS_KEYS
from ...robot.model import Robot
from ...sim.grounds import FLAT, GroundSpec, make_terrain
from ...sim.walk import WalkSpec
from ...util.errors import NOT_ACHIEVED, UserError
from ..experiments.data import assumptions
from ..experiments.trials import Trial, most_loaded

SEARCHED_SEEDS = range(8)  # of every candidate
FINAL_SEEDS = range(500, 516)  # of the few best ones: with eight walks, the best of 200 was also lucky
OTHER_SEEDS = range(1000, 1016)  # of the scores before and after, which choose nothing
FASTEST_M_S = 1.0  # a command that the robot file's own limit will reduce
WALK_S = 10.0
CALM_OF_FROUDE = 0.09  # of sqrt(g x leg): speed over steps, with loads, and where it is to be quiet
STONES_OF_LEG = 0.04
STEPS_OF_LEG = (0.10, 0.14, 0.18, 0.22)
LOADS_OF_MASS = (0.2, 0.4, 0.6, 0.8)
STEP_LATE = 2.5  # times what the command would take over a step, then it is over
FRICTION_KEYS = {"servo": "actuator.coulomb_Nm", "bldc": "actuator.motor.coulomb_Nm", "pd": "actuator.coulomb_Nm"}
FALL = 0.25  # of its way counts if a robot has fallen
LOUD_RAD_S2 = 100.0  # rms acceleration of the joints whose score is 1


@dataclass(frozen=True)
class Goal:
    """A goal: the unit of its score, its walks by seed, and the score of a walk from its figures."""

    unit: str
    walk: Callable[[Robot, str, int], WalkSpec]
    score: Callable[[WalkSpec, dict[str, Any]], float]


@dataclass(frozen=True)
class ScoredWalk:
    """A walk whose answer is its score. A robot that does not even stand up has none."""

    goal: str
    trial: Trial

    def run(self) -> float:
        """Walk it."""
        try:
            figures = self.trial.run().figures
        except UserError as error:
            if error.exit_code != NOT_ACHIEVED:
                raise
            return 0.0
        return GOALS[self.goal].score(self.trial.spec, figures) * (FALL if figures["falls"] else 1.0)


def walks(goal: str, robot: Robot, gait: str, where: str, seeds: range,
          spreads: Mapping[str, float]) -> list[ScoredWalk]:
    """Return the walks of a goal in one simulator; ``spreads``: of the robot file's keys, as far as it tells them."""
    return [ScoredWalk(goal, Trial(_drawn(GOALS[goal].walk(robot, gait, seed), spreads), where)) for seed in seeds]


def _drawn(spec: WalkSpec, spreads: Mapping[str, float]) -> WalkSpec:
    """Return the walk with random values from its seed: supply, delay, friction, and drives unlike the file's."""
    ranges, draw = assumptions()["tune"], random.Random(f"tune {spec.seed}")
    actuator, drop = spec.robot.actuator, draw.uniform(0.0, ranges["voltage_drop"])
    spec = replace(
        spec, voltage_V=max(actuator.least_V, actuator.supply_V * (1 - drop)),
        bus_delay_s=draw.uniform(*ranges["delay_s"]), friction=draw.uniform(*ranges["friction"]),
    )
    keys = {"spread": STIFFNESS_KEYS[actuator.kind], "friction_spread": FRICTION_KEYS[actuator.kind]}
    stiffness, friction = (1 + spreads.get(key, ranges[usual]) * draw.uniform(-1, 1) for usual, key in keys.items())
    return replace(spec, built=_built(spec.robot, stiffness, friction))


def _built(robot: Robot, stiffness: float, friction: float) -> Robot:
    """Return the robot as it may be built: all drives differ from its file by the same factors."""
    drive = robot.actuator
    if isinstance(drive, Servo):
        changed = {"duty_per_rad": drive.duty_per_rad * stiffness, "coulomb_Nm": drive.coulomb_Nm * friction}
    elif isinstance(drive, Bldc):
        loops = drive.drive.model_copy(update={"position_bandwidth_hz": drive.drive.position_bandwidth_hz * stiffness})
        motor = drive.motor.model_copy(update={"coulomb_Nm": drive.motor.coulomb_Nm * friction})
        return robot.model_copy(update={"actuator": drive.model_copy(update={"drive": loops, "motor": motor})})
    else:
        changed = {"stiffness_Nm_rad": drive.stiffness_Nm_rad * stiffness, "coulomb_Nm": drive.coulomb_Nm * friction}
    return robot.model_copy(update={"actuator": drive.model_copy(update=changed)})


def _calm_m_s(robot: Robot) -> float:
    return CALM_OF_FROUDE * sqrt(GRAVITY_M_S2 * robot.geometry.leg_m)


def _level(robot: Robot, gait: str, seed: int, speed_m_s: float, **more: Any) -> WalkSpec:
    """Return a walk of WALK_S, every second one over low stones."""
    stones = GroundSpec("stones", STONES_OF_LEG * robot.geometry.leg_m, start_m=0.25, length_m=2.0, seed=seed)
    return WalkSpec(robot, gait, speed_m_s, stones if seed % 2 else FLAT, distance_m=20.0, seed=seed, limit_s=WALK_S,
                    **more)


def _fast(robot: Robot, gait: str, seed: int) -> WalkSpec:
    return _level(robot, gait, seed, FASTEST_M_S)


def _step(robot: Robot, gait: str, seed: int) -> WalkSpec:
    draw = random.Random(f"step {seed}")
    height_m = (STEPS_OF_LEG[seed // 2 % len(STEPS_OF_LEG)] + draw.uniform(-0.02, 0.02)) * robot.geometry.leg_m
    start_m = 0.3 + draw.uniform(0.0, 0.1)
    ground = GroundSpec(("step-up", "step-down")[seed % 2], height_m, start_m=start_m)
    distance_m, speed_m_s = make_terrain(ground).finish_x_m or 1.0, _calm_m_s(robot)
    return WalkSpec(robot, gait, speed_m_s, ground, distance_m=distance_m, seed=seed,
                    limit_s=STEP_LATE * distance_m / speed_m_s)


def _loaded(robot: Robot, gait: str, seed: int) -> WalkSpec:
    load_kg = LOADS_OF_MASS[seed // 2 % len(LOADS_OF_MASS)] * robot.mass_kg
    return _level(robot, gait, seed, _calm_m_s(robot), payload_kg=min(20.0, load_kg))


def _calm(robot: Robot, gait: str, seed: int) -> WalkSpec:
    return _level(robot, gait, seed, _calm_m_s(robot))


def _made(spec: WalkSpec, figures: dict[str, Any]) -> float:
    """Return the share of the commanded speed that was held for the whole time."""
    return min(1.0, max(0.0, figures["distance_m"]) / (spec.speed_m_s * spec.time_limit_s))


def _carried(spec: WalkSpec, figures: dict[str, Any]) -> float:
    most = assumptions()["payload"]["largest_torque_rms"]
    return spec.payload_kg * _made(spec, figures) * min(1.0, most / max(1e-9, most_loaded(figures)[1]))


GOALS = {
    "speed": Goal("m/s", _fast, lambda spec, figures: max(0.0, figures["distance_m"]) / spec.time_limit_s),
    "steps": Goal("of the way", _step,
                  lambda spec, figures: min(1.0, max(0.0, figures["distance_m"]) / spec.distance_m)),
    "payload": Goal("kg", _loaded, _carried),
    "quiet": Goal("of 100 rad/s2", _calm, lambda spec, figures: _made(spec, figures) * LOUD_RAD_S2
                  / max(1e-9, figures["joint_acceleration_rad_s2"])),
}
