"""One walk of the simulated robot: its specification, the run, its figures, and its files."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

from sim2d import metrics
from sim2d.actuator import Drives
from sim2d.recording import Recording
from sim2d.run import Sensed, simulate

from ..control.gait_changes import GaitWatch, change_lines, notes_json
from ..control.planner import Driver
from ..robot.gait_advice import tried_up_to_m_s, why_not_advised
from ..robot.gait_names import gait_index
from ..robot.model import JOINT_NAMES, LEG_NAMES, Robot
from ..robot.plane import planar_robot
from ..util.errors import UserError
from .grounds import FLAT, ONLY_SPACE, GroundSpec, make_terrain
from .servos.plane import honest_servos

# How a walk's way is measured: ahead and to the left in m, turning to the left in rad.
WAYS: dict[str, tuple[int, int, int]] = {"ahead": (1, 0, 0), "back": (-1, 0, 0), "left": (0, 1, 0), "turn": (0, 0, 1)}

ENOUGH = 0.5  # of the commanded speed, where nothing was in the way
CRAWLS_M_S = 0.005  # Caramelo's crawl makes 8 mm/s where the ground is unknown (chosen)
_FASTER = 1.001  # a command is limited if it is beyond the limit by more than the core's rounding


@dataclass(frozen=True)
class Push:
    """A force on the trunk's middle, N ahead and to the left, for ``seconds`` from ``at_s`` after the start."""

    at_s: float
    force_N: tuple[float, float]
    seconds: float = 0.1


@dataclass(frozen=True)
class WalkSpec:
    """A walk to simulate. ``limit_s`` None: see ``time_limit_s``; ``stuck_after_s`` without progress end it.

    ``way``: one of WAYS; for "turn" speed and distance are rad/s and rad. Other ways than ahead and pushes are in
    space only. ``built``: the robot as it is, where it is not quite what its file says, which the planner goes by.
    """

    robot: Robot
    gait: str
    speed_m_s: float = 0.05
    ground: GroundSpec = FLAT
    distance_m: float = 1.5
    payload_kg: float = 0.0
    friction: float = 0.9
    voltage_V: float | None = None
    bus_delay_s: float = 0.02
    balance: bool = True
    seed: int = 0
    limit_s: float | None = None
    stuck_after_s: float = 45.0  # to back off from an edge and crawl back may take over 30 s
    way: str = "ahead"
    push: Push | None = None
    built: Robot | None = None

    def __post_init__(self) -> None:
        gait_index(self.robot, self.gait)
        self._check("--speed", self.speed_m_s, 0.005, 1.0 if self.way == "ahead" else 5.0, "m/s")
        self._check("--distance", self.distance_m, 0.05, 20.0, "m")
        self._check("--payload", self.payload_kg, 0.0, 20.0, "kg")
        self._check("--friction", self.friction, 0.05, 2.0, "")
        self._check("--bus-delay", self.bus_delay_s, 0.0, 0.5, "s")

    @staticmethod
    def _check(flag: str, value: float, low: float, high: float, unit: str) -> None:
        if not (math.isfinite(value) and low <= value <= high):
            raise UserError(f"{flag} {value:g}: allowed {low:g} .. {high:g} {unit}".rstrip())

    @property
    def body(self) -> Robot:
        """The robot that walks."""
        return self.built or self.robot

    @property
    def time_limit_s(self) -> float:
        """Give up after this: the given time, or five times the command's own time plus 20 s; enough for a crawl."""
        return self.limit_s or min(3600.0, 20.0 + self.distance_m / min(self.speed_m_s / 5.0, CRAWLS_M_S))


class PlannerController:
    """The planner as the simulator's controller: one Driver, walking straight on."""

    def __init__(self, spec: WalkSpec) -> None:
        self._driver = Driver(spec.robot, planar=True)
        self.rate_hz = self._driver.rate_hz
        self._driver.set_command(mode="walk", gait=spec.gait, vx_m_s=spec.speed_m_s, balance=spec.balance)
        self.watch = GaitWatch(self._driver)

    def tick(self, sensed: Sensed) -> Sequence[float]:
        """See sim2d.run.Controller."""
        rates = (0.0, sensed.pitch_rate_rad_s, 0.0)
        self._driver.sense(sensed.joint_position_rad, sensed.roll_rad, sensed.pitch_rad, rates)
        goals = self._driver.step()
        self.watch.look()
        return goals


def run_walk(
    spec: WalkSpec,
    progress: Callable[[float], None] | None = None,
    actuator: Drives | None = None,
) -> Recording:
    """Simulate the walk in the plane; the same spec, the same recording.

    ``actuator`` replaces the drives as linear laws (robot/drives.py). UserError for anything that the plane lacks.
    """
    if spec.ground.name in ONLY_SPACE:
        raise UserError(f"--terrain {spec.ground.name}: the plane has no left and right: add --in space")
    if spec.way != "ahead" or spec.push:
        raise UserError("walk: in the plane a robot only walks ahead, and can't be pushed")
    controller = PlannerController(spec)
    robot, servos = honest_servos(spec.body, planar_robot(spec.body, foot_friction=spec.friction), spec.voltage_V)
    try:
        recording = simulate(
            robot,
            controller,
            make_terrain(spec.ground),
            duration_s=spec.time_limit_s,
            distance_m=spec.distance_m,
            payload_kg=spec.payload_kg,
            supply_voltage_V=spec.voltage_V,
            bus_delay_s=spec.bus_delay_s,
            seed=spec.seed,
            stuck_after_s=spec.stuck_after_s,
            actuator=actuator or servos,
            progress=progress,
        )
    except (ValueError, ArithmeticError) as error:
        raise UserError(f"walk: {error}") from error
    return replace(recording, notes=tuple(controller.watch.notes))


def walk_result(spec: WalkSpec, recording: Recording) -> dict[str, Any]:
    """Return the walk's figures as plain values for JSON."""
    torque = metrics.torque_rms_fraction(recording)
    names = [f"{leg}_{joint}" for leg in LEG_NAMES for joint in JOINT_NAMES]
    return {
        "robot": spec.robot.name,
        "gait": spec.gait,
        "honest": spec.body.simulation.honest,
        "terrain": spec.ground.name,
        "height_m": spec.ground.height,
        "payload_kg": spec.payload_kg,
        "commanded_speed_m_s": spec.speed_m_s,
        "mean_speed_m_s": round(metrics.mean_speed_m_s(recording), 5),
        "distance_m": round(metrics.distance_m(recording), 5),
        "duration_s": round(metrics.duration_s(recording), 4),
        "pitch_range_deg": round(metrics.pitch_range_deg(recording), 3),
        "min_clearance_m": round(float(metrics.min_clearance_m(recording)), 5),
        "torque_rms_fraction": {name: round(float(torque[i]), 4) for i, name in enumerate(names)},
        "gait_changes": notes_json(recording.notes),
        "falls": int(recording.outcome.kind == "fell"),
        "ok": recording.outcome.ok,
        "reason": recording.outcome.sentence,
        "real_time_factor": round(recording.real_time_factor, 2),
        "seed": spec.seed,
    }


def asked_of(spec: WalkSpec) -> tuple[float, str, float]:
    """Return the speed asked of a walk, m/s, how a command beyond the limits was limited, and what share is enough.

    Of a gait with a speed of its own no more than that is asked: nothing, if the robot file does not name it.
    """
    driver = Driver(spec.robot, planar=True)
    if driver.has_own_speed(spec.gait):
        own_m_s = tried_up_to_m_s(spec.robot, spec.gait)
        return (spec.speed_m_s, "", 0.0) if own_m_s is None else (min(spec.speed_m_s, own_m_s), "", ENOUGH)
    most_m_s, key = driver.speed_limit(spec.gait)
    limited = f"limited to {most_m_s:.3g} m/s by {key}" if spec.speed_m_s > _FASTER * most_m_s else ""
    return spec.speed_m_s, limited, ENOUGH


def judged(spec: WalkSpec, result: dict[str, Any], *, in_space: bool = False) -> dict[str, Any]:
    """Return a walk's figures with the verdict on the command: arriving is not enough if it was not walked.

    A command above the limits of robot and gait is limited, and so not achieved. A walk below ENOUGH of the asked speed
    counts as achieved only if the robot backed off and crawled on: then the reason names the ground.
    """
    asked_m_s, limited, enough = asked_of(spec)
    share = result["mean_speed_m_s"] / asked_m_s
    advice = why_not_advised(spec.robot, spec.gait, asked_m_s, in_space=in_space)
    more: dict[str, Any] = {"limited": limited, "advice": advice, "asked_speed_m_s": asked_m_s}
    if result["ok"] and limited:
        more |= {"ok": False, "reason": f"{result['reason']}, but {spec.speed_m_s:g} m/s was {limited}"}
    elif result["ok"] and share < enough and all(change["to"] != "backing off" for change in result["gait_changes"]):
        whose = "commanded" if asked_m_s == spec.speed_m_s else f"{spec.gait}'s own"
        slow = f"at {100 * share:.0f} % of the {whose} speed; at least {100 * ENOUGH:.0f} % is asked"
        more |= {"ok": False, "reason": f"{result['reason']}, but {slow}"}
    return result | more


def own_speed_facts(result: dict[str, Any]) -> list[tuple[str, str]]:
    """Return what was asked of a gait that walks at its own speed, if that is less than the command."""
    told, asked = result["commanded_speed_m_s"], result["asked_speed_m_s"]
    return [("command", f"{told:g} m/s; the {result['gait']}'s own speed is {asked:g} m/s")] if asked < told else []


def facts(result: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the figures of a walk, judged, as rows of name and value with unit, for people."""
    share = result["mean_speed_m_s"] / result["asked_speed_m_s"]
    worst = max(result["torque_rms_fraction"], key=lambda name: result["torque_rms_fraction"][name])
    height = f" {1000 * result['height_m']:.0f} mm" if result["height_m"] else ""
    return [
        ("robot", result["robot"]),
        ("gait", result["gait"]),
        ("drives", "honest" if result["honest"] else "simple"),
        *([("not advised", result["advice"])] if result["advice"] else []),
        ("terrain", result["terrain"] + height),
        ("speed", f"{result['mean_speed_m_s']:.4f} of {result['asked_speed_m_s']:.4f} m/s ({100 * share:.0f} %)"),
        *([("command", result["limited"])] if result["limited"] else own_speed_facts(result)),
        ("distance", f"{result['distance_m']:.3f} m in {result['duration_s']:.1f} s"),
        ("pitch range", f"{result['pitch_range_deg']:.1f} deg"),
        *space_facts(result),
        ("least clearance of a swing", f"{1000 * result['min_clearance_m']:.1f} mm"),
        ("most loaded joint", f"{worst}, {100 * result['torque_rms_fraction'][worst]:.0f} % of stall rms"),
        *energy_facts(result),
        *change_lines(result["gait_changes"]),
        ("falls", str(result["falls"])),
        ("simulated", f"{result['real_time_factor']:.0f} x real time, seed {result['seed']}"),
    ]


def space_facts(result: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the figures that only a walk in space has (host/sim/space/walk.py)."""
    if "roll_range_deg" not in result:
        return []
    aside = f"{1000 * result['side_drift_m']:.0f} mm to the left, turned {result['yaw_drift_deg']:.1f} deg"
    return [("roll range", f"{result['roll_range_deg']:.1f} deg"), ("drift in 1.5 m", aside)]


def energy_facts(result: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the drives' energy (host/sim/motor/walking.py); per metre only if the robot went some way ahead."""
    rows = []
    per_metre_J = result["energy_per_metre_J"]
    if per_metre_J is not None:
        rows.append(("legs' drives", f"{per_metre_J:.0f} J/m, {result['cost_of_transport']:.1f} J/(N m)"))
    if result["largest_torque_Nm"] is not None:
        if per_metre_J is not None:
            best_J = result["energy_per_metre_regenerating_J"]
            rows.append(("with all braking energy fed back", f"{best_J:.0f} J/m"))
        rows.append(("largest torque", f"{result['largest_torque_Nm']:.2f} N m"))
        rows.append(("hottest winding", f"{result['hottest_winding_C']:.1f} degrees C"))
    return rows
