"""A foot in the air (paper A, section 4.1.1): one swing of a leg on a held robot, in the plane and in space.

The plane has no hips: there the foot goes forward and up only.

The path is the core's own cycloid (shared/gait/swing.py), sampled evenly, sent every tick over the late bus; the foot
is where the encoders put it. Its time ends when the foot comes within ARRIVED_M of where it stays.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from shared.gait.swing import cycloid_q15, lift_q15, swing_phase_q16
from sim2d import terrain
from sim2d.world import World

from ...robot.kinematics_si import Vector, leg_forward
from ...robot.model import Robot
from ...robot.plane import planar_robot
from ...robot.poses import leg_to_rad, rest_pose_rad
from ...util.errors import UserError
from .data import papers
from .trials import Answer

ARRIVED_M = 0.001
_LEG = 1  # front left: outward is +y
_HANG_S = 1.0
_WATCH_S = 1.2
_STEP_S = 0.001

Rows = list[tuple[float, float, float, float]]


@dataclass(frozen=True)
class Swing:
    """A swing's path: rows of time, x, y, height from the foot's rest, wanted and done."""

    wanted: Rows
    done: Rows

    def figures(self) -> dict[str, float]:
        """Return time, final place and highest point, s and m."""
        rows = np.array(self.done)
        final = rows[-50:, 1:].mean(axis=0)
        away = np.linalg.norm(rows[:, 1:] - final, axis=1) > ARRIVED_M
        last = int(np.flatnonzero(away)[-1]) + 1 if away.any() else 0
        return {"time_s": round(float(rows[min(last, len(rows) - 1), 0]), 4), "x_final_m": round(float(final[0]), 6),
                "y_final_m": round(float(final[1]), 6), "z_max_m": round(float(rows[:, 3].max()), 6)}


@dataclass(frozen=True)
class AirTrial:
    """One noisy trial."""

    robot: Robot
    target_m: tuple[float, float]
    conditions: dict[str, float]
    in_space: bool

    def run(self) -> Answer:
        """Simulate it; the plane has no sideways motion."""
        swing = self.swing()
        figures = {"ok": True, **swing.figures()}
        if not self.in_space:
            del figures["y_final_m"]
        return Answer(figures, swing)

    def swing(self) -> Swing:
        """Return the swing."""
        goals = path_goals(self.robot, self.target_m if self.in_space else (self.target_m[0], 0.0))
        move = _space_mover(self) if self.in_space else _plane_mover(self)
        rest = self.robot.foot_m(_LEG, self.robot.stance.rest_height_m)
        tick = 1 / self.robot.control.rate_hz
        wanted, done, steps_per_tick = [], [], round(tick / _STEP_S)
        late = round(self.conditions["bus_delay_s"] / _STEP_S)
        for step in range(round(_WATCH_S / _STEP_S)):
            sent = (step - late) // steps_per_tick
            angles = move(goals[min(max(sent, 0), len(goals) - 1)])
            foot = leg_forward(self.robot.geometry.links_m, self.robot.side(_LEG), angles)
            time_s = (step + 1) * _STEP_S
            done.append((time_s, *(a - b for a, b in zip(foot, rest, strict=True))))
        for index, goal in enumerate(goals):
            foot = leg_forward(self.robot.geometry.links_m, self.robot.side(_LEG), goal)
            wanted.append((index * tick, *(a - b for a, b in zip(foot, rest, strict=True))))
        return Swing(wanted, done)  # type: ignore[arg-type]


def path_goals(robot: Robot, target_m: tuple[float, float]) -> list[Vector]:
    """Return the joint goals of the paper's points, evenly spaced over its period."""
    table = papers()["table1"]
    points = round(table["period_s"] * robot.control.rate_hz)
    rest = robot.foot_m(_LEG, robot.stance.rest_height_m)
    goals = []
    for point in range(points):
        phase = swing_phase_q16(point, points, 65536, 65536)
        along, up = cycloid_q15(phase) / 32768, lift_q15(phase) / 32768
        foot = (rest[0] + along * target_m[0], rest[1] + along * target_m[1], rest[2] + up * table["height_m"])
        goal = leg_to_rad(robot, _LEG, foot)
        if goal is None:
            raise UserError(f"table1: robot {robot.name} can't reach its foot's path at {foot[2]:.3f} m")
        goals.append(goal)
    return goals


def _encoder(robot: Robot) -> Callable[[Sequence[float]], Vector]:
    """Return a function that rounds three joint angles as the encoders do."""
    step_rad = robot.actuator.step_rad
    steps = (step_rad, step_rad, step_rad * robot.calf_drive.ratio)

    def rounded(angles: Sequence[float]) -> Vector:
        hip, thigh, calf = (round(a / s) * s for a, s in zip(angles, steps, strict=True))
        return hip, thigh, calf

    return rounded


def _plane_mover(trial: AirTrial) -> Callable[[Vector], Vector]:
    """Return a function that moves the leg one step in the plane towards a goal and reads the encoders."""
    robot, encode = trial.robot, _encoder(trial.robot)
    plane = planar_robot(robot)
    world = World(plane, terrain.flat(), supply_voltage_V=trial.conditions["voltage_V"], dt_s=_STEP_S)
    world.place(plane.stand_pose_rad, lift_m=0.2)
    world.pin_torso()
    goals = [plane.stand_pose_rad[leg * 3 + joint] for leg in range(4) for joint in (1, 2)]
    world.advance(goals, round(_HANG_S / _STEP_S))

    def move(goal: Vector) -> Vector:
        goals[2 * _LEG : 2 * _LEG + 2] = goal[1:]
        world.advance(goals, 1)
        return encode((goal[0], *world.position_rad[2 * _LEG : 2 * _LEG + 2]))

    return move


def _space_mover(trial: AirTrial) -> Callable[[Vector], Vector]:
    """Return the same in space, the robot on a stand."""
    from ...sim.export.mjcf import ModelOptions
    from ...sim.space.world import World as Space

    robot, rate_hz = trial.robot, round(1 / _STEP_S)
    options = ModelOptions(voltage_V=trial.conditions["voltage_V"], on_a_stand=True, dt_s=_STEP_S)
    world = Space(robot, options, rate_hz, bus_delay_s=0.0)
    goals: list[Any] = rest_pose_rad(robot)
    for _ in range(round(_HANG_S / _STEP_S)):
        world.advance()

    def move(goal: Vector) -> Vector:
        goals[3 * _LEG : 3 * _LEG + 3] = goal
        world.send(goals)
        world.advance()
        hip, thigh, calf = world.joints_rad()[3 * _LEG : 3 * _LEG + 3].tolist()
        return hip, thigh, calf

    return move
