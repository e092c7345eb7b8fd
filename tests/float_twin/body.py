"""Paper A's body (eqs 7-9) with matrices: feet that stay where they are under a body that moves.

A pose is (x, y, z, roll, pitch, yaw), m and rad, R = Rx(roll) Ry(pitch) Rz(yaw): intrinsic x-y'-z''.
"""

import math


def about(axis, angle_rad):
    """Return the matrix that turns by an angle about axis 0, 1 or 2 (eq 8's factors)."""
    c, s = math.cos(angle_rad), math.sin(angle_rad)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[float(row == column) for column in range(3)] for row in range(3)]
    matrix[i][i], matrix[i][j], matrix[j][i], matrix[j][j] = c, -s, s, c
    return matrix


def product(a, b):
    """Return the product of two matrices."""
    return [[sum([a[i][k] * b[k][j] for k in range(3)]) for j in range(3)] for i in range(3)]


def rotation(pose):
    """Return R of a pose (eq 8)."""
    return product(product(about(0, pose[3]), about(1, pose[4])), about(2, pose[5]))


def from_base(pose, point_m, hip_m):
    """Return a point of the base frame as seen from a hip of the posed body: R^T (p - c) - h (eq 9)."""
    r = rotation(pose)
    away = [point_m[i] - pose[i] for i in range(3)]
    return [sum([r[k][i] * away[k] for k in range(3)]) - hip_m[i] for i in range(3)]
