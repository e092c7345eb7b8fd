"""One trial: a walk in the plane or in space, small enough to send to another process, with its figures."""

import random
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from sim2d.metrics import rate
from sim2d.model import GRAVITY_M_S2
from sim2d.recording import Recording

from ...robot.model import Robot
from ...sim.energy import drives_power_W, mean_power_W
from ...sim.walk import WalkSpec, run_walk, walk_result
from .data import assumptions

PLANE, SPACE = "plane", "3-D"
START_S = 4.0  # the robot's start, which steady figures leave out
FRICTIONS = (0.6, 0.9)
STRIDE_M = 0.10  # paper A: 0.05 m/s in cycles of 2 s
EDGE_M = 0.3  # the time over an edge is from this far before it to this far behind
_HELD_OUT_SEED = 1000
# Of the way from one start offset to the next. It is irrational, so that no offset is ever that of another number of
# trials of the chosen set.
_HELD_OUT_SHIFT = (3 - 5**0.5) / 2


@dataclass(frozen=True)
class Options:
    """The options of an experiment.

    ``trials`` None: the experiment's own number; ``only``: of the groups of cases, all if it is empty; ``held_out``:
    seeds and start offsets that chose no constant.
    """

    robot: Robot
    gait: str
    trials: int | None = None
    in_space: bool = True
    held_out: bool = False
    only: tuple[str, ...] = ()

    @property
    def simulators(self) -> tuple[str, ...]:
        """The simulators to run in."""
        return (PLANE, SPACE) if self.in_space else (PLANE,)

    def seeds(self, usual: int) -> range:
        """Return the trials' seeds where ``usual`` is the experiment's own number."""
        first = _HELD_OUT_SEED if self.held_out else 0
        return range(first, first + (usual if self.trials is None else self.trials))

    def starts(self, usual: int) -> list[tuple[float, float, int]]:
        """Return (start offset in m, friction, seed): offsets across a stride at each friction."""
        count, shift = len(self.seeds(usual)), _HELD_OUT_SHIFT if self.held_out else 0.0
        offsets_m = [(round(STRIDE_M * (i + shift) / count, 9), friction) for friction in FRICTIONS
                     for i in range(count)]
        return [(*start, self.seeds(usual).start + i) for i, start in enumerate(offsets_m)]


def space_is_there() -> bool:
    """Return whether walks in three dimensions can run."""
    return find_spec("mujoco") is not None


@dataclass(frozen=True)
class Answer:
    """A trial's figures, and its recording if it was to be kept."""

    figures: dict[str, Any]
    recording: Any = None

    @property
    def ok(self) -> bool:
        """True if the robot arrived."""
        return bool(self.figures["ok"])


@dataclass(frozen=True)
class Trial:
    """A walk in one of the simulators."""

    spec: WalkSpec
    where: str = PLANE
    keep: bool = False

    def run(self) -> Answer:
        """Simulate it."""
        recording, figures = (_in_space if self.where == SPACE else _in_plane)(self.spec)
        speeds_rad_s = recording.joint_speed_rad_s
        robot, weight_N = self.spec.robot, (self.spec.robot.mass_kg + self.spec.payload_kg) * GRAVITY_M_S2
        figures |= {"seed": self.spec.seed, "start_m": self.spec.ground.start_m, "friction": self.spec.friction}
        acceleration_rad_s2 = rate(speeds_rad_s, recording.time_s)
        figures["joint_acceleration_rad_s2"] = round(float(np.sqrt(np.mean(acceleration_rad_s2**2))), 3)
        figures["power_W"] = mean_power_W(robot, recording.torque_Nm, speeds_rad_s)
        walked_W = drives_power_W(robot, recording.torque_Nm, speeds_rad_s)
        mean_m_s = figures["mean_speed_m_s"]
        figures["cost_of_transport"] = round(walked_W / mean_m_s / weight_N, 3) if mean_m_s > 0 else None
        return Answer(figures, recording if self.keep else None)


def _in_plane(spec: WalkSpec) -> tuple[Recording, dict[str, Any]]:
    recording = run_walk(spec)
    figures = walk_result(spec, recording)
    del figures["real_time_factor"]  # the one figure that differs from run to run
    figures["whole_pitch_range_deg"] = figures["pitch_range_deg"]
    figures["speed_m_s"] = _steady_speed_m_s(recording.time_s, recording.torso_x_m)
    return recording, figures


def _in_space(spec: WalkSpec) -> tuple[Recording, dict[str, Any]]:
    from ...sim.space.walk import figures, walk_in_space

    recording = walk_in_space(spec)
    result = figures(recording, spec.way, START_S)
    result["crossing_s"] = _crossing_s(recording.time_s, recording.torso_x_m, spec.ground.start_m)
    return recording, result


def _steady_speed_m_s(time_s: "np.ndarray[Any, Any]", x_m: "np.ndarray[Any, Any]") -> float:
    """Mean speed without the first START_S, 0 for a run not twice as long."""
    first = int(np.searchsorted(time_s, START_S))
    if time_s[-1] < 2 * START_S:
        return 0.0
    return round(float((x_m[-1] - x_m[first]) / (time_s[-1] - time_s[first])), 5)


def _crossing_s(time_s: "np.ndarray[Any, Any]", x_m: "np.ndarray[Any, Any]", edge_m: float) -> float | None:
    """Return the time from EDGE_M before an edge to EDGE_M behind it; None if the robot did not get that far."""
    if x_m.max() < edge_m + EDGE_M:
        return None
    began, ended = (float(time_s[np.argmax(x_m >= edge_m + side * EDGE_M)]) for side in (-1, 1))
    return round(ended - began, 2)


def trials(where: str, specs: list[WalkSpec], keep: bool = False) -> list[Trial]:
    """Return the walks in one simulator; of the first the recording is kept if asked."""
    return [Trial(spec, where, keep and i == 0) for i, spec in enumerate(specs)]


def drawn(spec: WalkSpec, seed: int) -> WalkSpec:
    """Return the walk with a trial's random values from its seed: supply, bus delay and friction, and the seed."""
    return replace(spec, **trial_conditions(spec.robot, seed))  # type: ignore[arg-type]


def trial_conditions(robot: Robot, seed: int) -> dict[str, float]:
    """Return a trial's random values from its seed, named as in WalkSpec."""
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
