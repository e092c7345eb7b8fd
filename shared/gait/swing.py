"""The swing foot's path: a cycloid (paper A, eqs 11-14) and its P_T / P_N re-timing.

With K = 2 pi t / T: horizontally (K - sin K) / 2 pi of the way, vertically H (1 - cos K) / 2
above the straight line from lift-off to touchdown. The paper's eq 13 lacks the line's rise
z_f - z_0, without which a foot can't step onto anything. Slope is zero at both ends.
"""

from ..num.fixed import cos_q15, sin_q15
from ..runtime import const, hot

_INV_TWO_PI_Q17 = const(20861)  # 2^17 / (2 pi) = 20860.76


@hot
def swing_phase_q16(sample: int, samples: int, p_t_q16: int, p_n_q16: int) -> int:
    """Return t / T in Q16, 0 .. 65536, of sample 0 .. samples - 1 (paper A, section 2.5.3).

    The first floor(samples * P_N) samples lie evenly over 0 .. P_T * T, the rest over what is
    left, both ends included; P_T = 1 or P_N = 1 gives even spacing. Range: samples 1 .. 16384,
    p_t_q16 and p_n_q16 0 .. 65536; a sample outside is taken as the first or last. Error at most
    1 LSB of Q16. Largest intermediate 16383 * 65536 < 2^30.
    """
    if sample <= 0 or samples < 2:
        return 0
    if sample >= samples - 1:
        return 65536
    head = samples * p_n_q16 >> 16
    if p_t_q16 >= 65536 or p_n_q16 >= 65536 or head < 2:
        return (sample << 16) // (samples - 1)
    if sample < head:
        return sample * p_t_q16 // (head - 1)
    return p_t_q16 + (sample - head + 1) * (65536 - p_t_q16) // (samples - head)


@hot
def cycloid_q15(phase_q16: int) -> int:
    """Return (K - sin K) / 2 pi in Q15, 0 .. 32768, for t / T in Q16, 0 .. 65536 (eqs 11, 12, 14).

    Error at most 1 LSB, so it may step back by 1 LSB. Largest intermediate 32767 * 20861 + 2^16 < 2^30.
    """
    return ((phase_q16 << 1) - (sin_q15(phase_q16) * _INV_TWO_PI_Q17 + 0x4000 >> 15) + 2) >> 2


@hot
def lift_q15(phase_q16: int) -> int:
    """Return (1 - cos K) / 2 in Q15, 0 .. 32767, for t / T in Q16, 0 .. 65536 (eq 13).

    Error at most 1 LSB. Exactly 0 at both ends.
    """
    return (32767 - cos_q15(phase_q16) + 1) >> 1
