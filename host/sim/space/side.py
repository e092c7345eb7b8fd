"""A walk in space from its right side: a recording as the plane makes it, with the same figures, pictures and page."""

from collections.abc import Sequence

import numpy as np

from sim2d.metrics import rate
from sim2d.notes import Note
from sim2d.recording import Aside, Recording, rotations
from sim2d.referee import Outcome

from ...robot.model import Robot
from ...robot.plane import planar_robot
from ..export.mjcf import drives
from ..grounds import FLAT, STONES, make_terrain
from ..walk import WalkSpec
from .world import Array


def recorded(
    spec: WalkSpec, columns: Sequence[Array], outcome: Outcome, notes: Sequence[Note] = (), wall_s: float = 0.0
) -> Recording:
    """Return the recording of a walk; ``wall_s`` is its wall-clock time.

    ``columns``, a row per control tick: time, position, attitude, joints, goals, torques, feet's loads, penetration.
    All are true values, not sensor readings.
    """
    time_s, position_m, attitude_rad, joint_rad, goal_rad, torque_Nm, foot_load_N, penetration_m = columns
    turn = rotations(attitude_rad)
    points = _legs_m(spec.robot, joint_rad) @ turn[:, None].transpose(0, 1, 3, 2) + position_m[:, None, None]
    xz = points[..., [0, 2]]
    count, stall = len(time_s), [d.stall_torque_Nm for d in drives(planar_robot(spec.robot), spec.voltage_V)]
    return Recording(
        time_s=time_s,
        torso_x_m=position_m[:, 0],
        torso_z_m=position_m[:, 2],
        torso_pitch_rad=attitude_rad[:, 1],
        joint_rad=joint_rad,
        joint_speed_rad_s=rate(joint_rad, time_s),
        goal_rad=goal_rad,
        torque_Nm=torque_Nm,
        hip_xz_m=xz[:, :, 0],
        knee_xz_m=xz[:, :, 1],
        foot_xz_m=xz[:, :, 2],
        foot_force_N=np.stack([np.zeros_like(foot_load_N), foot_load_N], axis=2),
        contact=foot_load_N > 0,
        joint_opening_m=np.zeros(count),
        penetration_m=penetration_m,
        stone_xz_m=np.zeros((count, 0, 2)),
        stone_turn_rad=np.zeros((count, 0)),
        stall_Nm=np.array(stall * 4),
        foot_radius_m=spec.robot.geometry.foot_radius_m,
        terrain=make_terrain(FLAT if spec.ground.name in STONES else spec.ground),  # of stones the floor under them
        outcome=outcome,
        real_time_factor=float(time_s[-1]) / wall_s if wall_s > 0 else 0.0,
        notes=tuple(notes),
        aside=Aside(position_m[:, 1], attitude_rad, points[..., 1]),
    )


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
