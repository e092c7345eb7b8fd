"""The robot's nine rigid bodies in a pymunk space: torso, then thigh and calf of FR, FL, RR, RL.

Every body's own origin is its centre of mass, so that pymunk's ``center_of_gravity`` (which moves the origin
when set late) is never needed; joints are given as anchors from there. pymunk turns counter-clockwise, the
robot's angles turn about +y: pymunk angle = -(pitch + thigh + calf).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import pymunk

from .model import CALF, HIP, PLANAR_INDEX, PLANAR_JOINTS, THIGH, PlanarRobot

# All parts of the robot share one group: near and far legs overlap in the plane and must not collide.
ROBOT_GROUP = 1


@dataclass(frozen=True)
class Parts:
    """The bodies in the order of every state array, and the anchors the geometry is read back with."""

    bodies: tuple[pymunk.Body, ...]
    hip_anchor_m: tuple[tuple[float, float], ...]
    thigh_top_m: tuple[float, float]
    thigh_knee_m: tuple[float, float]
    calf_knee_m: tuple[float, float]
    calf_foot_m: tuple[float, float]
    torso_origin_m: tuple[float, float]


def build(space: pymunk.Space, robot: PlanarRobot, payload_kg: float, joint_error_bias: float) -> Parts:
    """Add the robot to ``space``, all bodies at the origin: place it before stepping."""
    torso = robot.loaded_torso(payload_kg)
    links = (torso, *(robot.thigh, robot.calf) * 4)
    bodies = [pymunk.Body(link.mass_kg, link.inertia_kgm2) for link in links]
    parts = Parts(
        bodies=tuple(bodies),
        hip_anchor_m=tuple((x - torso.com_x_m, -torso.com_z_m) for x in robot.hip_x_m),
        thigh_top_m=(-robot.thigh.com_x_m, -robot.thigh.com_z_m),
        thigh_knee_m=(-robot.thigh.com_x_m, -robot.thigh_length_m - robot.thigh.com_z_m),
        calf_knee_m=(-robot.calf.com_x_m, -robot.calf.com_z_m),
        calf_foot_m=(-robot.calf.com_x_m, -robot.calf_length_m - robot.calf.com_z_m),
        torso_origin_m=(-torso.com_x_m, -torso.com_z_m),
    )
    space.add(*bodies)
    space.add(*_torso_shapes(robot, parts, payload_kg))
    for leg in range(4):
        space.add(*_leg_shapes(robot, parts, leg))
        space.add(*_leg_joints(robot, parts, leg, joint_error_bias))
    return parts


def _in_group(shape: pymunk.Shape, friction: float) -> pymunk.Shape:
    shape.friction = friction
    shape.elasticity = 0.0
    shape.filter = pymunk.ShapeFilter(group=ROBOT_GROUP)
    return shape


def _torso_shapes(robot: PlanarRobot, parts: Parts, payload_kg: float) -> list[pymunk.Shape]:
    """The torso's box and, on top, the payload's; no mass of their own."""
    x0, z0 = parts.torso_origin_m
    boxes = [(robot.torso_half_length_m, -robot.torso_half_height_m, robot.torso_half_height_m)]
    if payload_kg > 0:
        boxes.append((robot.payload_half_length_m, robot.torso_half_height_m, robot.payload_height_m + 0.02))
    return [
        _in_group(
            pymunk.Poly(
                parts.bodies[0],
                [(x0 + side * half, z0 + z) for side, z in ((-1, low), (1, low), (1, high), (-1, high))],
                radius=0.002,
            ),
            robot.body_friction,
        )
        for half, low, high in boxes
    ]


def _leg_shapes(robot: PlanarRobot, parts: Parts, leg: int) -> list[pymunk.Shape]:
    """A thin thigh with the knee's rounding, a thin calf that hits risers, and the foot's circle."""
    thigh, calf = parts.bodies[1 + 2 * leg], parts.bodies[2 + 2 * leg]
    foot = pymunk.Circle(calf, robot.foot_radius_m, parts.calf_foot_m)
    lower = pymunk.Segment(calf, parts.calf_knee_m, parts.calf_foot_m, robot.link_radius_m)
    upper = pymunk.Segment(thigh, parts.thigh_top_m, parts.thigh_knee_m, robot.link_radius_m)
    return [
        _in_group(foot, robot.foot_friction),
        _in_group(lower, robot.body_friction),
        _in_group(upper, robot.body_friction),
    ]


def _leg_joints(robot: PlanarRobot, parts: Parts, leg: int, error_bias: float) -> list[pymunk.Constraint]:
    """Hip and knee pins, and the drives' Coulomb friction as motors of rate 0 with a torque limit.

    A calf driven from the hip has its friction there too.
    """
    torso, thigh, calf = parts.bodies[0], parts.bodies[1 + 2 * leg], parts.bodies[2 + 2 * leg]
    hip = pymunk.PivotJoint(torso, thigh, parts.hip_anchor_m[leg], parts.thigh_top_m)
    knee = pymunk.PivotJoint(thigh, calf, parts.thigh_knee_m, parts.calf_knee_m)
    hip.error_bias = knee.error_bias = error_bias
    joints: list[pymunk.Constraint] = [hip, knee]
    drives = (
        (torso, thigh, robot.thigh_servo.coulomb_Nm),
        (torso if robot.calf_on_torso else thigh, calf, robot.calf_servo.coulomb_Nm),
    )
    for reaction, driven, limit_Nm in drives:
        if limit_Nm > 0:
            friction = pymunk.SimpleMotor(reaction, driven, 0.0)
            friction.max_force = limit_Nm
            joints.append(friction)
    return joints


def place(
    parts: Parts, robot: PlanarRobot, pose_rad: Sequence[float], x_m: float, z_m: float, pitch_rad: float
) -> None:
    """Put the robot at rest: middle of the hips at (x, z), twelve joint angles, joints closed exactly."""
    torso = parts.bodies[0]
    _set(torso, (x_m, z_m), parts.torso_origin_m, -pitch_rad)
    for leg in range(4):
        thigh, calf = parts.bodies[1 + 2 * leg], parts.bodies[2 + 2 * leg]
        q_thigh, q_calf = pose_rad[leg * 3 + THIGH], pose_rad[leg * 3 + CALF]
        hip = torso.local_to_world(parts.hip_anchor_m[leg])
        _set(thigh, hip, parts.thigh_top_m, -(pitch_rad + q_thigh))
        knee = thigh.local_to_world(parts.thigh_knee_m)
        _set(calf, knee, parts.calf_knee_m, -(pitch_rad + q_thigh + q_calf))


def _set(body: pymunk.Body, point_m: tuple[float, float], anchor_m: tuple[float, float], angle: float) -> None:
    """Turn ``body`` to ``angle`` (pymunk's sense) with its local ``anchor_m`` at ``point_m``; stop it."""
    cos, sin = math.cos(angle), math.sin(angle)
    body.angle = angle
    body.position = (
        point_m[0] - (cos * anchor_m[0] - sin * anchor_m[1]),
        point_m[1] - (sin * anchor_m[0] + cos * anchor_m[1]),
    )
    body.velocity = (0.0, 0.0)
    body.angular_velocity = 0.0


def planar(joints_rad: Sequence[float]) -> list[float]:
    """Return the plane's eight of twelve joint values, thigh and calf of each leg."""
    return [joints_rad[joint] for joint in PLANAR_INDEX]


def all_joints(planar_values: Sequence[float], hips: Sequence[float]) -> list[float]:
    """Return twelve joint values from the plane's eight and four hips."""
    if len(planar_values) != PLANAR_JOINTS:
        raise ValueError(f"{len(planar_values)} planar values, must be {PLANAR_JOINTS}")
    twelve = [0.0] * 12
    for leg in range(4):
        twelve[leg * 3 + HIP] = hips[leg]
        twelve[leg * 3 + THIGH] = planar_values[2 * leg]
        twelve[leg * 3 + CALF] = planar_values[2 * leg + 1]
    return twelve
