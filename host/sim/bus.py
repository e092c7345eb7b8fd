"""The simulated robot's joints without any bus in between: goals go straight to the drives of the plane."""

import time
from collections.abc import Callable, Sequence
from math import copysign

from ..bus.base import JOINTS, Bus, Measured, checked_fraction, checked_goals
from ..robot.model import Robot
from ..robot.poses import seated_pose_rad
from .plant import PlanePlant, Plant

ROOM_TEMPERATURE_C = 25.0


class SimulatedBus(Bus):
    """A robot that waits seated on flat ground; ``clock`` is real time unless told otherwise."""

    kind = "simulated"

    def __init__(self, robot: Robot, clock: Callable[[], float] = time.monotonic, plant: Plant | None = None) -> None:
        super().__init__()
        self.plant = PlanePlant(robot, seated_pose_rad(robot)) if plant is None else plant
        self._clock, self._start_s = clock, clock()
        self._supply_V = robot.actuator.supply_V

    def open(self) -> None:
        """See Bus: nothing to connect."""
        self._start_s = self._clock() - self.plant.time_s

    def now(self) -> float:
        """See Bus."""
        return self._clock()

    def read(self) -> Measured:
        """Let the plane catch up with the clock and look at it."""
        self._catch_up()
        plant = self.plant
        self.counters.sent += JOINTS
        self.counters.answered += JOINTS
        return Measured(
            time_s=self.now(),
            position_rad=tuple(plant.position_rad),
            speed_rad_s=tuple(plant.speed_rad_s),
            load=tuple(copysign(min(abs(load), 1.0), load) for load in plant.drives.load),
            temperature_C=(ROOM_TEMPERATURE_C,) * JOINTS,
            voltage_V=(self._supply_V,) * JOINTS,
            age_s=(0.0,) * JOINTS,
            slow_age_s=(0.0,) * JOINTS,
        )

    def write(self, goals_rad: Sequence[float]) -> None:
        """See Bus."""
        goals = checked_goals(goals_rad)
        self._catch_up()
        self.plant.drives.goal_rad[:] = goals

    def torque(self, on: bool) -> None:
        """See Bus."""
        self._catch_up()
        drives = self.plant.drives
        if on:
            drives.goal_rad[:] = self.plant.position_rad
        drives.on[:] = [on] * JOINTS

    def limit_torque(self, fraction: float) -> None:
        """See Bus."""
        self.plant.drives.limit[:] = [checked_fraction(fraction)] * JOINTS

    def emergency_stop(self) -> None:
        """See Bus."""
        self.plant.drives.on[:] = [False] * JOINTS

    def close(self) -> None:
        """See Bus."""
        self.emergency_stop()

    def _catch_up(self) -> None:
        self.plant.advance_to(self._clock() - self._start_s)
