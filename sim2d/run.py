"""A run: sense, ask the controller, send its goals over a late bus, step the plane, until it is over.

All times are simulated; the wall clock serves only for the real-time factor.
"""

import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Protocol

from .actuator import Drives
from .body import planar
from .model import JOINTS, PlanarRobot
from .recording import Log, Recording
from .referee import Outcome, Referee
from .sensors import Sensed, Sensors
from .terrain import Terrain
from .world import World

__all__ = ["Controller", "Sensed", "simulate"]


class Controller(Protocol):
    """The robot's controller: any object with a rate and a tick."""

    rate_hz: int

    def tick(self, sensed: Sensed) -> Sequence[float]:
        """Return twelve joint goals in rad, index leg * 3 + joint (hip, thigh, calf), legs FR, FL, RR, RL."""


class LateBus:
    """Goals under way: each acts a fixed number of sub-steps after it was sent."""

    def __init__(self, world: World, delay_s: float, goal_rad: Sequence[float]) -> None:
        if not 0 <= delay_s <= 1.0:
            raise ValueError(f"bus_delay_s = {delay_s}: allowed 0 .. 1")
        self._world, self._delay_steps = world, round(delay_s / world.dt_s)
        self._acting = list(goal_rad)
        self._sent: deque[tuple[int, list[float]]] = deque()

    def send(self, goal_rad: list[float]) -> None:
        """Send eight planar goals now."""
        self._sent.append((self._world.steps + self._delay_steps, goal_rad))

    def advance_to(self, step: int) -> None:
        """Run the world up to a sub-step, each goal from the instant it arrives."""
        world, sent = self._world, self._sent
        while sent and sent[0][0] <= step:
            due, goal = sent.popleft()
            world.advance(self._acting, due - world.steps)
            self._acting = goal
        world.advance(self._acting, step - world.steps)


class _Run:
    """The parts of one run, tick by tick."""

    def __init__(
        self, world: World, drives: Drives, controller: Controller, bus_delay_s: float, seed: int
    ) -> None:
        self.world, self._controller = world, controller
        self._goals = clamped(world.robot, world.robot.stand_pose_rad)
        self._bus = LateBus(world, bus_delay_s, planar(self._goals))
        self._sensors, self.log = Sensors(world, seed), Log(world, drives)
        self._ticks, self._start_step = 0, 0

    def settle(self, seconds: float) -> float:
        """Hold the stand, set the time after it to 0, and return the torso's x then, m."""
        self._start_step = round(seconds / self.world.dt_s)
        self._bus.advance_to(self._start_step)
        return self.log.torso_of(self.world.state())[0]

    def tick(self, referee: Referee, progress: Callable[[float], None] | None) -> Outcome | None:
        """Judge and record the present instant; unless it is the last, ask the controller and go on to the next."""
        world = self.world
        time_s = (world.steps - self._start_step) * world.dt_s
        state, contacts = world.state(), world.contacts()
        sensed = self._sensors.read(state, self._goals[0::3], time_s)
        x_m, pitch_rad = self.log.torso_of(state)
        outcome = referee.judge(time_s, x_m, abs(pitch_rad), contacts.torso_touches)
        if outcome is None:
            answer = checked(self._controller.tick(sensed), f"goal at {time_s:.3f} s")
            self._goals = clamped(world.robot, answer)
            self._bus.send(planar(self._goals))
        self.log.add(time_s, state, contacts, self._goals)
        if progress is not None:
            progress(1.0 if outcome else referee.progress(time_s, x_m))
        if outcome is None:
            self._ticks += 1
            steps = math.ceil(self._ticks / (self._controller.rate_hz * world.dt_s) - 1e-9)
            self._bus.advance_to(self._start_step + steps)
        return outcome


def simulate(
    robot: PlanarRobot,
    controller: Controller,
    terrain: Terrain,
    *,
    duration_s: float,
    distance_m: float | None = None,
    payload_kg: float = 0.0,
    supply_voltage_V: float | None = None,
    bus_delay_s: float = 0.02,
    seed: int = 0,
    dt_s: float = 0.001,
    start_x_m: float = 0.0,
    settle_s: float = 0.5,
    stuck_after_s: float = 10.0,
    actuator: Drives | None = None,
    progress: Callable[[float], None] | None = None,
) -> Recording:
    """Run ``controller`` on ``robot`` over ``terrain`` and return the recording of every control tick.

    The robot starts at rest at ``start_x_m`` in its stand, sinks into its servos for ``settle_s`` and then hears the
    controller from time 0. It ends when ``distance_m`` is walked from there, on a fall, when no progress is made for
    ``stuck_after_s``, or after ``duration_s``. ``progress`` gets the share done, 0 .. 1, each tick. The supply is the
    servos' nominal voltage unless told otherwise. Bad arguments raise ValueError with one line.
    """
    _check_run(controller.rate_hz, duration_s, distance_m, dt_s, settle_s, start_x_m)
    checked(robot.stand_pose_rad, "initial pose")
    world = World(
        robot, terrain, payload_kg=payload_kg, supply_voltage_V=supply_voltage_V, actuator=actuator, dt_s=dt_s
    )
    world.place(robot.stand_pose_rad, start_x_m)
    run = _Run(world, world.servos if actuator is None else actuator, controller, bus_delay_s, seed)
    referee = Referee(run.settle(settle_s), distance_m, duration_s, stuck_after_s)
    began, outcome = time.perf_counter(), None
    while outcome is None:
        outcome = run.tick(referee, progress)
    return run.log.close(outcome, time.perf_counter() - began)


def _check_run(
    rate_hz: int, duration_s: float, distance_m: float | None, dt_s: float, settle_s: float, start_x_m: float
) -> None:
    if not 1 <= rate_hz <= 1 / dt_s:
        raise ValueError(f"controller rate {rate_hz} Hz: allowed 1 .. {1 / dt_s:.0f}, one tick per sub-step")
    if not 0 < duration_s <= 3600:
        raise ValueError(f"duration {duration_s} s: allowed above 0 and up to 3600")
    if distance_m is not None and not 0 < distance_m <= 100:
        raise ValueError(f"distance {distance_m} m: allowed above 0 and up to 100")
    if not 0 <= settle_s <= 60:
        raise ValueError(f"settle_s = {settle_s}: allowed 0 .. 60")
    if not -2 <= start_x_m <= 10:
        raise ValueError(f"start_x_m = {start_x_m}: allowed -2 .. 10")


def checked(goals_rad: Sequence[float], what: str) -> Sequence[float]:
    """Return twelve finite angles or raise: a wrong goal must never reach a drive."""
    if len(goals_rad) != JOINTS:
        raise ValueError(f"{what}: {len(goals_rad)} angles, must be {JOINTS}")
    for joint, angle in enumerate(goals_rad):
        if not math.isfinite(angle):
            raise ValueError(f"{what}: joint {joint} is {angle}, must be a finite angle")
    return goals_rad


def clamped(robot: PlanarRobot, goals_rad: Sequence[float]) -> list[float]:
    """Return the goals within the joints' limits, as the servos themselves would; hips as they are."""
    limits = (None, robot.thigh_limits_rad, robot.calf_limits_rad)
    result = list(goals_rad)
    for joint in range(JOINTS):
        bounds = limits[joint % 3]
        if bounds is not None:
            result[joint] = min(max(result[joint], bounds[0]), bounds[1])
    return result
