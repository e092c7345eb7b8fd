"""A walk in space from its right side: a recording as the plane makes it, with the same figures, pictures and page."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from sim2d.metrics import rate
from sim2d.recording import Aside, Recording

from ...robot.model import Robot
from ...util.errors import UserError
from ..grounds import FLAT, STONES, make_terrain
from ..walk import WalkSpec
from .walk import SpaceRecording, figures, walk_in_space
from .world import Array


def side_view(spec: WalkSpec, rec: SpaceRecording, real_time_factor: float) -> Recording:
    """Return the walk as a recording of the plane: all points projected along y."""
    turn = _turned(rec.attitude_rad)
    points = _legs_m(spec.robot, rec.joint_rad) @ turn[:, None].transpose(0, 1, 3, 2) + rec.position_m[:, None, None]
    xz = points[..., [0, 2]]
    count = len(rec.time_s)
    return Recording(
        time_s=rec.time_s,
        torso_x_m=rec.position_m[:, 0],
        torso_z_m=rec.position_m[:, 2],
        torso_pitch_rad=rec.attitude_rad[:, 1],
        joint_rad=rec.joint_rad,
        joint_speed_rad_s=rate(rec.joint_rad, rec.time_s),
        goal_rad=rec.goal_rad,
        torque_Nm=rec.torque_Nm,
        hip_xz_m=xz[:, :, 0],
        knee_xz_m=xz[:, :, 1],
        foot_xz_m=xz[:, :, 2],
        foot_force_N=np.stack([np.zeros_like(rec.foot_load_N), rec.foot_load_N], axis=2),
        contact=rec.foot_load_N > 0,
        joint_opening_m=np.zeros(count),
        penetration_m=rec.penetration_m,
        stone_xz_m=np.zeros((count, 0, 2)),
        stone_turn_rad=np.zeros((count, 0)),
        stall_Nm=rec.stall_Nm,
        foot_radius_m=spec.robot.geometry.foot_radius_m,
        terrain=make_terrain(FLAT if spec.ground.name in STONES else spec.ground),  # of stones the floor under them
        outcome=rec.outcome,
        real_time_factor=real_time_factor,
        notes=rec.notes,
        aside=Aside(rec.position_m[:, 1], turn, points[..., 1]),
    )


def run_in_space(spec: WalkSpec, progress: Callable[[float], None] | None = None) -> tuple[Recording, dict[str, Any]]:
    """Simulate the walk; return its recording from the side, and the figures that only space has."""
    began_s = time.perf_counter()
    try:
        rec = walk_in_space(spec, progress)
    except (ValueError, ArithmeticError) as error:
        raise UserError(f"walk: {error}") from error
    taken_s = time.perf_counter() - began_s
    told = figures(rec)
    more = {key: told[key] for key in ("roll_range_deg", "yaw_drift_deg", "side_drift_m")}
    return side_view(spec, rec, float(rec.time_s[-1]) / taken_s), more


def _legs_m(robot: Robot, joint_rad: Array) -> Array:
    """Return thigh joint, knee and foot of each leg in body axes from the middle of the hips: (n, legs, 3, 3)."""
    offset_m, thigh_m, calf_m = robot.geometry.links_m
    legs = []
    for leg in range(4):
        hip, thigh, calf = joint_rad[:, 3 * leg : 3 * leg + 3].T
        out_m, (hip_x_m, hip_y_m) = robot.side(leg) * offset_m, robot.hip_m(leg)
        chain = [(0 * thigh, 0 * thigh)]
        for length_m, angle in ((thigh_m, thigh), (calf_m, thigh + calf)):
            chain.append((chain[-1][0] - length_m * np.sin(angle), chain[-1][1] + length_m * np.cos(angle)))
        legs.append([
            [hip_x_m + x, hip_y_m + out_m * np.cos(hip) + drop * np.sin(hip), out_m * np.sin(hip) - drop * np.cos(hip)]
            for x, drop in chain
        ])
    return np.array(legs).transpose(3, 0, 1, 2)


def _turned(attitude_rad: Array) -> Array:
    """Return the rotations, (n, 3, 3), of roll, pitch and yaw about fixed axes."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude_rad).T, np.sin(attitude_rad).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(rows).transpose(2, 0, 1)
