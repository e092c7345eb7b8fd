"""Clarke and Park transforms: Clarke amplitude-invariant for three shunts, Park with the d axis at the rotor's flux.

alpha = (2a - b - c) / 3, beta = (b - c) / sqrt 3; d = c alpha + s beta, q = c beta - s alpha. The
current step spells the same sums out, because a call costs more than a sum; these are the forms to
use anywhere else.
"""

from ..runtime import hot


@hot
def clarke_alpha(a: int, b: int, c: int) -> int:
    """Return alpha in the unit of the phase values; each within +-16383.

    Rejects a common offset. Error at most 1/2 + 2^-13 of alpha, from 1/3 as 21845/2^16 halved to
    10923/2^15. Largest intermediate 65532 * 10923 + 2^14 < 2^30.
    """
    return ((a + a - b - c) * 10923 + 0x4000) >> 15


@hot
def clarke_beta(b: int, c: int) -> int:
    """Return beta in the unit of the phase values; each within +-16383.

    Error at most 1/2 + 2^-15 of beta, from 1/sqrt 3 as 18919/2^15. Largest intermediate
    32766 * 18919 + 2^14 < 2^30.
    """
    return ((b - c) * 18919 + 0x4000) >> 15


@hot
def park_d(alpha: int, beta: int, sin_q15: int, cos_q15: int) -> int:
    """Return the part of (alpha, beta) along the rotor's flux, in their unit.

    alpha, beta: a vector no longer than 32000. Error at most 1/2 plus 1/16384 of its length from
    the sine. Largest intermediate 32000 * 32768 + 2^14 < 2^30.
    """
    return (cos_q15 * alpha + sin_q15 * beta + 0x4000) >> 15


@hot
def park_q(alpha: int, beta: int, sin_q15: int, cos_q15: int) -> int:
    """Return the part of (alpha, beta) a quarter electrical turn ahead of the flux; as park_d."""
    return (cos_q15 * beta - sin_q15 * alpha + 0x4000) >> 15


@hot
def unpark_alpha(d: int, q: int, sin_q15: int, cos_q15: int) -> int:
    """Return alpha of the vector (d, q), in their unit; range and error as park_d."""
    return (cos_q15 * d - sin_q15 * q + 0x4000) >> 15


@hot
def unpark_beta(d: int, q: int, sin_q15: int, cos_q15: int) -> int:
    """Return beta of the vector (d, q), in their unit; range and error as park_d."""
    return (cos_q15 * q + sin_q15 * d + 0x4000) >> 15
