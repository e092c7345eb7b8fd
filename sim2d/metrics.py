"""Figures of a recording. All are counted over its rows, so at the controller's rate.

A swing is a stretch of rows in which a foot does not touch and goes at least SWING_MIN_TRAVEL_M up or along:
a foot that hovers just above the ground while others carry its load does not swing, but a dragged foot does.
"""

import itertools
import math

import numpy as np

from .recording import Array, Recording

SWING_MIN_TRAVEL_M = 0.010


def duration_s(rec: Recording) -> float:
    """Simulated time from the first row to the last."""
    return float(rec.time_s[-1] - rec.time_s[0])


def distance_m(rec: Recording) -> float:
    """How far the torso went forward."""
    return float(rec.torso_x_m[-1] - rec.torso_x_m[0])


def mean_speed_m_s(rec: Recording) -> float:
    """Distance over duration; 0 for a run of one row."""
    seconds = duration_s(rec)
    return distance_m(rec) / seconds if seconds > 0 else 0.0


def rate(values: Array, time_s: Array) -> Array:
    """How fast each column changes, row by row; 0 for a run of one row."""
    return np.asarray(np.gradient(values, time_s, axis=0)) if len(time_s) > 1 else np.zeros_like(values)


def pitch_range_deg(rec: Recording, skip_s: float = 0.0) -> float:
    """Largest minus smallest pitch, after the first ``skip_s``."""
    pitch = rec.torso_pitch_rad[rec.time_s >= rec.time_s[0] + skip_s]
    return math.degrees(float(np.ptp(pitch))) if len(pitch) else 0.0


def _runs(flags: np.ndarray) -> list[tuple[int, int]]:
    """Half-open stretches [start, end) of True that begin and end inside the rows."""
    change = np.flatnonzero(np.diff(flags.astype(np.int8)))
    return [(int(a) + 1, int(b) + 1) for a, b in itertools.pairwise(change) if flags[a + 1]]


def swings(rec: Recording, leg: int) -> list[tuple[int, int]]:
    """Row ranges [start, end) of the leg's complete swings."""
    foot = rec.foot_xz_m[:, leg]
    found = _runs(~rec.contact[:, leg])
    return [(a, b) for a, b in found if np.ptp(foot[a - 1 : b + 1], axis=0).max() >= SWING_MIN_TRAVEL_M]


def swing_clearances_m(rec: Recording) -> list[float]:
    """For every complete swing: the foot's highest underside above the highest ground from lift-off to landing."""
    heights = []
    for leg in range(4):
        foot = rec.foot_xz_m[:, leg]
        for start, end in swings(rec, leg):
            ground = rec.terrain.highest_m(foot[start - 1, 0], foot[end, 0])
            heights.append(float(foot[start:end, 1].max() - rec.foot_radius_m - ground))
    return heights


def min_clearance_m(rec: Recording) -> float:
    """Smallest of all swings' clearances; 0 if no foot ever swung. Negative: a foot never cleared its edge."""
    return min(swing_clearances_m(rec), default=0.0)


def torque_rms_Nm(rec: Recording) -> Array:
    """Root mean square of each drive's torque."""
    return np.asarray(np.sqrt(np.mean(rec.torque_Nm**2, axis=0)))


def torque_rms_fraction(rec: Recording) -> Array:
    """The same as a share of the drive's largest torque; 0 for the hips, which the plane does not have."""
    return np.divide(torque_rms_Nm(rec), rec.stall_Nm, out=np.zeros(len(rec.stall_Nm)), where=rec.stall_Nm > 0)
