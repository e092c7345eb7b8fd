"""Sag, foot forces, load sharing and the support's margin in floats, written from the physics, not from the core."""

import math

from . import leg


def jacobian(joints, side_l1, l2, l3, step=1e-6):
    """Return d foot / d joint by differences: three columns."""
    columns = []
    for joint in range(3):
        up = list(joints)
        down = list(joints)
        up[joint] += step
        down[joint] -= step
        a = leg.forward(up, side_l1, l2, l3)
        b = leg.forward(down, side_l1, l2, l3)
        columns.append([(a[i] - b[i]) / (2 * step) for i in range(3)])
    return columns


def motor_torques(joints, force, coupled, side_l1, l2, l3):
    """Return what the three motors must hold against a force on the foot: -J^T F, for motor coordinates."""
    columns = jacobian(joints, side_l1, l2, l3)
    if coupled:  # turning the thigh's motor alone keeps the calf's angle in the body
        columns[1] = [columns[1][i] - columns[2][i] for i in range(3)]
    return [-sum([column[i] * force[i] for i in range(3)]) for column in columns]


def sag(joints, force, coupled, give, side_l1, l2, l3):
    """Return the three joint angles that, with motors giving ``give`` rad per unit of torque, sag to ``joints``."""
    torques = motor_torques(joints, force, coupled, side_l1, l2, l3)
    raised = [torques[i] * give[i] for i in range(3)]
    if coupled:
        raised[2] -= raised[1]
    return [joints[i] + raised[i] for i in range(3)]


def shares(feet, weights, com):
    """Return the weighted minimum-norm shares of 1: solves the 3 x 3 equations by Cramer's rule; None if singular."""
    s = sum(weights)
    sx = sum([w * f[0] for w, f in zip(weights, feet)])
    sy = sum([w * f[1] for w, f in zip(weights, feet)])
    sxx = sum([w * f[0] * f[0] for w, f in zip(weights, feet)])
    sxy = sum([w * f[0] * f[1] for w, f in zip(weights, feet)])
    syy = sum([w * f[1] * f[1] for w, f in zip(weights, feet)])
    rows = [[s, sx, sy], [sx, sxx, sxy], [sy, sxy, syy]]
    right = [1.0, com[0], com[1]]
    det = determinant(rows)
    if abs(det) < 1e-12:
        return None
    found = []
    for column in range(3):
        replaced = [[right[i] if j == column else rows[i][j] for j in range(3)] for i in range(3)]
        found.append(determinant(replaced) / det)
    return [w * (found[0] + found[1] * f[0] + found[2] * f[1]) for w, f in zip(weights, feet)]


def determinant(m):
    """Return the determinant of a 3 x 3 matrix."""
    return (
        m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1])
        - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0])
        + m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0])
    )


def margin(corners, point):
    """Return the signed distance of a point to a convex polygon's lines (corners against the clock), above 0 inside."""
    sides = zip(corners, corners[1:] + corners[:1])
    return min([left_of(a, b, point) / distance(a, b) for a, b in sides])


def left_of(a, b, point):
    """Return twice the area of a, b, point: above 0 if the point is to the left of the way from a to b."""
    return (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])


def distance(a, b):
    """Return how far two points are apart in the plane."""
    return math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2)
