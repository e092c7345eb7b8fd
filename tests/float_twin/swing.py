"""The swing of paper A: cycloid (eqs 11-14) and the instants at which its program samples it (section 2.5.3)."""

import math

from .fixed import limit


def instants(samples, p_t=1.0, p_n=1.0):
    """Return t / T of each sample: int(samples x P_N) of them over 0 .. P_T, the others over what is left."""
    first = int(samples * p_n + 1e-9)
    if p_t >= 1 or p_n >= 1 or first < 2:
        return evenly(0.0, 1.0, samples)
    return evenly(0.0, p_t, first) + evenly(p_t, 1.0, samples - first + 1)[1:]


def evenly(start, stop, count):
    """Return ``count`` values from start to stop, both included; numpy calls it linspace."""
    return [start + (stop - start) * i / (count - 1) for i in range(count)]


def advance(phase):
    """Return the share of the way made at t / T (eqs 11, 12)."""
    k = 2 * math.pi * limit(phase, 0.0, 1.0)
    return (k - math.sin(k)) / (2 * math.pi)


def lift(phase):
    """Return the share of the height at t / T (eq 13)."""
    return (1 - math.cos(2 * math.pi * limit(phase, 0.0, 1.0))) / 2
