"""A walk in three dimensions: stand up, find the attitude, walk on command, until it is over; and its figures.

The planner is the one the robot runs (host/control/planner.py), its attitude the core's filter on raw IMU counts.
"""

import math
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from sim2d.recording import Recording
from sim2d.referee import Outcome, Referee

from ...control.gait_changes import GaitWatch, notes_json
from ...control.planner import Driver
from ...imu.attitude import Attitude
from ...robot.model import JOINT_NAMES, LEG_NAMES
from ...util.errors import NOT_ACHIEVED, UserError
from ..export.mjcf import ModelOptions
from ..grounds import make_ground
from ..imu import SimulatedImu
from ..walk import WAYS, WalkSpec
from .side import recorded
from .world import World

# (dt_s, impratio): twice as fast as in the exported model, with the same figures of a gait.
FAST = (0.002, 10.0)
FALL_TILT_RAD = math.radians(45.0)
_SETTLE_S = 0.5
_STANDING_UP_S = 20.0
_ASIDE = {"ahead": (0.0, 1.0), "back": (0.0, 1.0), "left": (1.0, 0.0), "turn": (0.0, 0.0)}  # across each of WAYS


class SpaceWalker:
    """The planner with its senses in a World, tick by tick."""

    def __init__(self, spec: WalkSpec) -> None:
        self.driver = Driver(spec.robot)
        options = ModelOptions(make_ground(spec.ground), spec.payload_kg, spec.friction, spec.voltage_V, *FAST)
        self.world = World(spec.body, options, self.driver.rate_hz, bus_delay_s=spec.bus_delay_s)
        self.attitude = Attitude(spec.robot, SimulatedImu(spec.robot, self.world.motion, spec.seed))
        self.goals = [0.0] * 12
        self.watch = GaitWatch(self.driver)
        self.driver.set_command(mode="stand", gait=spec.gait, balance=spec.balance)

    def tick(self) -> None:
        """Sense, plan, send, and run the world one control period."""
        roll_rad, pitch_rad = self.attitude.update() or (None, None)
        self.driver.sense(self.world.joints_rad().tolist(), roll_rad, pitch_rad, self.attitude.rates_rad_s)
        self.goals = self.driver.step()
        self.watch.look()
        self.world.send(self.goals)
        self.world.advance()

    def stand_up(self) -> None:
        """Settle, rise and let the attitude align at rest; UserError if it does not come to stand."""
        rate_hz = self.driver.rate_hz
        for _ in range(round(_SETTLE_S * rate_hz)):
            self.world.advance()
        for _ in range(round(_STANDING_UP_S * rate_hz)):
            self.tick()
            if self.attitude.state == "ok" and self.driver.state == "standing":
                self.watch.restart()
                return
        raise UserError(f"3-D walk: {self.driver.state} after {_STANDING_UP_S:g} s, attitude {self.attitude.state}: "
                        "the robot does not stand", NOT_ACHIEVED)


class _Log:
    """Rows of a walk, and when it is over."""

    def __init__(self, walker: SpaceWalker, spec: WalkSpec) -> None:
        self._walker, self._spec = walker, spec
        self._rows: list[tuple[object, ...]] = []
        world = walker.world
        self._start_s, self._start = world.time_s, (*world.position_m()[:2], world.attitude_rad()[2])
        self._yaw_rad, self.time_s = self._start[2], 0.0
        self.referee = Referee(0.0, spec.distance_m, spec.time_limit_s, spec.stuck_after_s, FALL_TILT_RAD)

    def add(self, progress: Callable[[float], None] | None) -> Outcome | None:
        """Keep the present instant; return how the walk ended, None while it goes on."""
        world = self._walker.world
        loads, trunk, deepest = world.foot_loads_N()
        time_s, place, attitude = world.time_s - self._start_s, world.position_m(), world.attitude_rad()
        self.time_s = time_s
        self._yaw_rad += math.remainder(attitude[2] - self._yaw_rad, math.tau)
        gone = sum(share * (now - start) for share, now, start in zip(
            WAYS[self._spec.way], (float(place[0]), float(place[1]), self._yaw_rad), self._start, strict=True))
        self._rows.append((time_s, place, attitude, world.true_joints_rad(), np.array(self._walker.goals),
                           world.drive_torques_Nm(), loads, deepest))
        if progress is not None:
            progress(self.referee.progress(time_s, gone))
        tilt_rad = math.acos(max(-1.0, min(1.0, math.cos(attitude[0]) * math.cos(attitude[1]))))
        return self.referee.judge(time_s, gone, tilt_rad, trunk)

    def close(self, outcome: Outcome, wall_s: float) -> Recording:
        """Return the recording; ``wall_s`` is the wall-clock time of the walk."""
        columns = [np.array(column, dtype=float) for column in zip(*self._rows, strict=True)]
        columns[2][:, 2] = np.unwrap(columns[2][:, 2])  # yaw
        return recorded(self._spec, columns, outcome, self._walker.watch.notes, wall_s)


def walk_in_space(spec: WalkSpec, progress: Callable[[float], None] | None = None) -> Recording:
    """Simulate the walk; the same spec, the same recording on the same machine. UserError if it can't be done."""
    try:
        return _walk(spec, progress)
    except (ValueError, ArithmeticError) as error:
        raise UserError(f"walk: {error}") from error


def _walk(spec: WalkSpec, progress: Callable[[float], None] | None) -> Recording:
    began_s = time.perf_counter()
    walker = SpaceWalker(spec)
    walker.stand_up()
    log, push = _Log(walker, spec), spec.push
    ahead, left, turn = (spec.speed_m_s * share for share in WAYS[spec.way])
    walker.driver.set_command(mode="walk", vx_m_s=ahead, vy_m_s=left, wz_rad_s=turn)
    outcome = log.add(progress)
    while outcome is None:
        if push is not None:
            pushed = 0 <= log.time_s - push.at_s < push.seconds - 1e-9
            walker.world.push(push.force_N if pushed else (0.0, 0.0))
        walker.tick()
        outcome = log.add(progress)
    return log.close(outcome, time.perf_counter() - began_s)


def figures(rec: Recording, way: str = "ahead", skip_s: float = 4.0) -> dict[str, Any]:
    """Return a walk's figures for JSON.

    ``mean_speed_m_s`` and the ``whole`` ranges are of the whole way; ``speed_m_s``, the other ranges and the torques
    leave out the first ``skip_s``, in which the robot starts. Yaw and sideways drift are per 1.5 m of way. Where the
    way is a turn, speeds are rad/s and the distance is rad.
    """
    assert rec.aside is not None
    seconds = float(rec.time_s[-1])
    first = int(np.searchsorted(rec.time_s, skip_s)) if seconds > 2 * skip_s else 0
    places = np.column_stack((rec.torso_x_m, rec.aside.torso_y_m, rec.aside.attitude_rad[:, 2]))
    way_m = (places - places[0]) @ np.array(WAYS[way], dtype=float)
    degrees = np.degrees(rec.aside.attitude_rad)
    steady_s = max(1e-9, seconds - float(rec.time_s[first]))
    gone_m = float(way_m[-1])
    aside_m = float((places[-1, :2] - places[0, :2]) @ np.array(_ASIDE[way]))
    per_course = 1.5 / gone_m if gone_m > 0.05 else 0.0
    torque = np.sqrt(np.mean(rec.torque_Nm[first:] ** 2, axis=0)) / rec.stall_Nm
    names = [f"{leg}_{joint}" for leg in LEG_NAMES for joint in JOINT_NAMES]
    return {
        "mean_speed_m_s": round(gone_m / seconds, 5) if seconds > 0 else 0.0,
        "speed_m_s": round((gone_m - float(way_m[first])) / steady_s, 5),
        "distance_m": round(gone_m, 4),
        "duration_s": round(seconds, 2),
        "roll_range_deg": round(float(np.ptp(degrees[first:, 0])), 3),
        "pitch_range_deg": round(float(np.ptp(degrees[first:, 1])), 3),
        "whole_roll_range_deg": round(float(np.ptp(degrees[:, 0])), 3),
        "whole_pitch_range_deg": round(float(np.ptp(degrees[:, 1])), 3),
        "yaw_drift_deg": round(float(degrees[-1, 2] - degrees[0, 2]) * per_course, 2),
        "side_drift_m": round(aside_m * per_course, 4),
        "torque_rms_fraction": {name: round(float(share), 4) for name, share in zip(names, torque, strict=True)},
        "penetration_mm": round(1000 * float(rec.penetration_m.max()), 3),
        "gait_changes": notes_json(rec.notes),
        "falls": int(rec.outcome.kind == "fell"),
        "ok": rec.outcome.ok,
        "reason": rec.outcome.sentence,
    }
