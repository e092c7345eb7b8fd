"""Sag, foot forces, load sharing and the support's margin in floats, written from the physics, not from the core."""

import math

from . import leg as twin_leg


def foot(joints, side_l1, l2, l3):
    """Return the foot from the hip (paper A eqs 1-6)."""
    return twin_leg.forward(joints, side_l1, l2, l3)


def jacobian(joints, side_l1, l2, l3, step=1e-6):
    """Return d foot / d joint by differences: three columns."""
    columns = []
    for joint in range(3):
        up = list(joints)
        down = list(joints)
        up[joint] += step
        down[joint] -= step
        a = foot(up, side_l1, l2, l3)
        b = foot(down, side_l1, l2, l3)
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
    least = None
    for i in range(len(corners)):
        a = corners[i]
        b = corners[(i + 1) % len(corners)]
        length = math.sqrt((b[0] - a[0]) ** 2 + (b[1] - a[1]) ** 2)
        side = ((b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])) / length
        if least is None or side < least:
            least = side
    return least
