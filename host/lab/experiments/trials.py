"""One trial: a walk in the plane or in space, small enough to send to another process, with its figures."""

import random
from dataclasses import dataclass
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

import numpy as np

from sim2d.recording import Recording
from sim2d.terrain import Terrain

from ...robot.model import Robot
from ...sim.energy import mean_power_W
from ...sim.export.ground import Ground
from ...sim.walk import WalkSpec, run_walk, walk_result
from .data import assumptions

if TYPE_CHECKING:
    from ...sim.space.walk import SpaceRecording

START_S = 4.0


@dataclass(frozen=True)
class Options:
    """What is asked of an experiment. ``trials`` None: the experiment's own number."""

    robot: Robot
    gait: str
    trials: int | None = None
    jobs: int = 1
    in_space: bool = True

    def count(self, usual: int) -> int:
        """Return how many trials to run where ``usual`` is the experiment's own number."""
        return usual if self.trials is None else self.trials


def space_is_there() -> bool:
    """Return whether the 3-D check can run."""
    return find_spec("mujoco") is not None


@dataclass(frozen=True)
class Answer:
    """A trial's figures, and its recording if it was to be kept."""

    figures: dict[str, Any]
    recording: "Recording | SpaceRecording | None" = None

    @property
    def ok(self) -> bool:
        """True if the robot arrived."""
        return bool(self.figures["ok"])


@dataclass(frozen=True)
class PlaneTrial:
    """A walk in sim2d, over ``ground`` if given."""

    spec: WalkSpec
    ground: Terrain | None = None
    keep: bool = False

    def run(self) -> Answer:
        """Simulate it."""
        recording = run_walk(self.spec, ground=self.ground)
        figures = walk_result(self.spec, recording)
        del figures["real_time_factor"]  # the one figure that differs from run to run
        figures["speed_m_s"] = _steady_speed_m_s(recording.time_s, recording.torso_x_m)
        figures["power_W"] = mean_power_W(self.spec.robot, recording.torque_Nm, recording.joint_speed_rad_s)
        return Answer(figures, recording if self.keep else None)


def _steady_speed_m_s(time_s: "np.ndarray[Any, Any]", x_m: "np.ndarray[Any, Any]") -> float:
    """Mean speed without the first START_S, 0 for a run not twice as long."""
    first = int(np.searchsorted(time_s, START_S))
    if time_s[-1] < 2 * START_S:
        return 0.0
    return round(float((x_m[-1] - x_m[first]) / (time_s[-1] - time_s[first])), 5)


@dataclass(frozen=True)
class SpaceTrial:
    """The same walk in three dimensions, over ``ground``."""

    spec: WalkSpec
    ground: Ground
    keep: bool = False

    def run(self) -> Answer:
        """Simulate it."""
        from ...sim.space.walk import figures, walk_in_space

        recording = walk_in_space(self.spec, self.ground)
        result = figures(recording, START_S)
        speeds = np.gradient(recording.joint_rad, recording.time_s, axis=0)
        result["power_W"] = mean_power_W(self.spec.robot, recording.torque_Nm, speeds)
        return Answer(result, recording if self.keep else None)


def trial_conditions(robot: Robot, seed: int) -> dict[str, float]:
    """Return what a trial draws by its seed: supply, bus delay and friction, and the seed itself."""
    ranges, draw = assumptions()["trial"], random.Random(f"trial {seed}")
    drop = draw.uniform(0.0, ranges["voltage_drop"])
    return {
        "voltage_V": max(robot.actuator.least_V, robot.actuator.supply_V * (1 - drop)),
        "bus_delay_s": draw.uniform(*ranges["delay_s"]),
        "friction": draw.uniform(*ranges["friction"]),
        "seed": seed,
    }


def with_knees(robot: Robot, configuration: str) -> Robot:
    """Return the robot with its knees the other way (host/robot/model.py, KNEE_CONFIGURATIONS)."""
    geometry = robot.geometry.model_copy(update={"knee_configuration": configuration})
    return robot.model_copy(update={"geometry": geometry})


def most_loaded(figures: dict[str, Any]) -> tuple[str, float]:
    """Return the joint with the largest torque and its share of stall, rms."""
    shares = figures["torque_rms_fraction"]
    name = max(shares, key=lambda joint: float(shares[joint]))
    return name, float(shares[name])
