"""Pieces the plane's tests share: controllers that stand or hang, energy of a world, the servo's static sag."""

import math
import struct

import numpy as np

from sim2d.metrics import duration_s
from sim2d.model import GRAVITY_M_S2, PLANAR_JOINTS
from sim2d.world import BODY_FIELDS, World


class Stand:
    """Asks for the same pose at every tick and keeps what it sensed."""

    rate_hz = 50

    def __init__(self, pose_rad):
        self.pose_rad, self.sensed = list(pose_rad), []

    def tick(self, sensed):
        self.sensed.append(sensed)
        return self.pose_rad


class Limp:
    """Drives without torque: a rag doll."""

    def torques(self, goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm):
        torque_Nm[:] = [0.0] * PLANAR_JOINTS


def body_states(world: World) -> list[tuple[float, ...]]:
    """x, z, angle, vx, vz, angular speed of the nine bodies, pymunk's sense."""
    return list(struct.iter_unpack(f"{BODY_FIELDS}d", world.state()))[: len(world.parts.bodies)]


def energy_J(world: World) -> float:
    """Kinetic, height and end-stop energy of the robot, positions taken half a sub-step ahead.

    The plane moves bodies with the old speed and then changes the speed. Of that scheme the energy that stays
    constant is the one with positions at x + v dt / 2 (exactly so in free fall).
    """
    half_s = 0.5 * world.dt_s
    states = [
        (x + vx * half_s, z + vz * half_s, angle + turn * half_s, vx, vz, turn)
        for x, z, angle, vx, vz, turn in body_states(world)
    ]
    total = 0.0
    for part, (_, z, _, vx, vz, turn) in zip(world.parts.bodies, states, strict=True):
        total += part.mass * (0.5 * (vx * vx + vz * vz) + GRAVITY_M_S2 * z) + 0.5 * part.moment * turn * turn
    for carrier, link, armature_kgm2 in world.rotors.rows:
        total -= armature_kgm2 * states[carrier][5] * states[link][5]
    limits = (world.robot.thigh_limits_rad, world.robot.calf_limits_rad)
    for joint in range(PLANAR_JOINTS):
        child, parent = joint + 1, joint if joint % 2 else 0
        angle = states[parent][2] - states[child][2]
        low, high = limits[joint % 2]
        beyond = max(low - angle, angle - high, 0.0)
        total += 0.5 * world.robot.end_stop_Nm_rad * beyond * beyond
    return total


def torso_height_m(world: World) -> float:
    """Height of the middle of the hips."""
    return world.parts.bodies[0].local_to_world(world.parts.torso_origin_m).y


def foot_in_hip_frame(robot, thigh_rad, calf_rad):
    """Return the foot centre (x, z) from the hip for an upright torso: paper A's FK in the plane."""
    both = thigh_rad + calf_rad
    x = -robot.thigh_length_m * math.sin(thigh_rad) - robot.calf_length_m * math.sin(both)
    return x, -robot.thigh_length_m * math.cos(thigh_rad) - robot.calf_length_m * math.cos(both)


def static_sag_m(robot, load_N) -> float:
    """How far one hip sinks over a foot that carries ``load_N`` straight up: two springs, solved by iteration.

    Balance of each joint: stiffness x (goal - q) = load x horizontal lever, thigh about the hip, calf about the knee.
    """
    thigh_goal, calf_goal = robot.stand_pose_rad[1:3]
    thigh, calf = thigh_goal, calf_goal
    for _ in range(200):
        x, _ = foot_in_hip_frame(robot, thigh, calf)
        knee_x = -robot.thigh_length_m * math.sin(thigh)
        thigh = thigh_goal - load_N * x / robot.thigh_servo.stiffness_Nm_rad
        calf = calf_goal - load_N * (x - knee_x) / robot.calf_servo.stiffness_Nm_rad
    return foot_in_hip_frame(robot, thigh, calf)[1] - foot_in_hip_frame(robot, thigh_goal, calf_goal)[1]


def foot_slip_m(rec):
    """Slip of each foot from row to row (n - 1, 4): the part of its path that rolling does not explain, >= 0.

    Rolling about +y by an angle moves the foot's centre by radius x angle along the ground. Rows in which the
    foot does not touch at both ends count 0.
    """
    turn = rec.torso_pitch_rad[:, None] + rec.joint_rad[:, 1::3] + rec.joint_rad[:, 2::3]
    moved = np.diff(rec.foot_xz_m, axis=0)
    rolled = rec.foot_radius_m * np.diff(turn, axis=0)
    along = np.hypot(moved[:, :, 0], moved[:, :, 1]) * np.sign(moved[:, :, 0])
    standing = rec.contact[1:] & rec.contact[:-1]
    return np.abs(along - rolled) * standing


def foot_skate_m(rec, cycle_s, min_load_N=0.0):
    """Worst foot's slip per gait cycle, while it carries at least ``min_load_N``.

    Feet that carry next to nothing slide by Coulomb's law; a foot under load must not.
    """
    load = rec.foot_force_N[:, :, 1]
    carrying = (load[1:] >= min_load_N) & (load[:-1] >= min_load_N)
    cycles = duration_s(rec) / cycle_s
    return float((foot_slip_m(rec) * carrying).sum(axis=0).max() / cycles) if cycles > 0 else 0.0
