"""A joint's load: the leg's weight and inertia in the air, its share of the robot's weight on the ground."""

from collections.abc import Sequence
from math import pi

from sim2d.model import GRAVITY_M_S2

from ..robot.kinematics_si import leg_forward
from ..robot.mass import leg_inertia_kg_m2, leg_parts
from ..robot.model import Robot
from ..robot.poses import rest_pose_rad
from ..robot.statics import load_slope_Nm
from .model import Load


def joint_per_shaft(robot: Robot, joint: int) -> float:
    """Return how far a joint turns when its servo's shaft turns by 1; the calf's rod has a ratio."""
    return robot.calf_drive.ratio if joint % 3 == 2 else 1.0


def in_the_air(robot: Robot, joint: int) -> Load:
    """Return a joint's load with the robot on its stand and the rest of its leg as at rest."""
    leg, kind = divmod(joint, 3)
    pose, ratio = rest_pose_rad(robot)[3 * leg : 3 * leg + 3], joint_per_shaft(robot, joint)
    # A rigid part on an axis: its weight's torque is a sin q + b cos q, so two angles determine it.
    turned = ([*pose[:kind], angle, *pose[kind + 1 :]] for angle in (0.0, pi / 2))
    cosine, sine = (_holds_Nm(robot, leg, other, kind, 0.0) for other in turned)
    return Load(leg_inertia_kg_m2(robot)[kind] * ratio**2, sine, cosine, ratio)


def _holds_Nm(robot: Robot, leg: int, pose: Sequence[float], kind: int, push_N: float) -> float:
    return load_slope_Nm(robot, leg, (pose[0], pose[1], pose[2]), kind, push_N)


def pushes_N(robot: Robot, pose_rad: Sequence[float]) -> list[float]:
    """Return the ground's push on each of four feet; the centre of mass decides the shares."""
    parts = [(robot.links.trunk.mass_kg, robot.links.trunk.com_m)]
    feet = []
    for leg in range(4):
        joints = (pose_rad[3 * leg], pose_rad[3 * leg + 1], pose_rad[3 * leg + 2])
        parts += leg_parts(robot, leg, joints)
        foot, hip = leg_forward(robot.geometry.links_m, robot.side(leg), joints), robot.hip_m(leg)
        feet.append((hip[0] + foot[0], hip[1] + foot[1]))
    mass = sum(part for part, _ in parts)
    x, y = (sum(part * at[axis] for part, at in parts) / mass for axis in (0, 1))
    front, rear = (feet[0][0] + feet[1][0]) / 2, (feet[2][0] + feet[3][0]) / 2
    left, right = (feet[1][1] + feet[3][1]) / 2, (feet[0][1] + feet[2][1]) / 2
    ahead, beside = (x - rear) / (front - rear), (y - right) / (left - right)
    return [mass * GRAVITY_M_S2 * (ahead if leg < 2 else 1 - ahead) * (beside if leg % 2 else 1 - beside)
            for leg in range(4)]  # fmt: skip


def on_the_ground_Nm(robot: Robot, pose_rad: Sequence[float]) -> list[float]:
    """Return the torque of the standing robot's weight on each shaft, in the direction in which it would turn it."""
    pushes, loads = pushes_N(robot, pose_rad), []
    for joint in range(12):
        leg, kind = divmod(joint, 3)
        holds = _holds_Nm(robot, leg, pose_rad[3 * leg : 3 * leg + 3], kind, pushes[leg])
        loads.append(-holds * joint_per_shaft(robot, joint))
    return loads
