"""What the interrupt adds up in commissioning: currents and voltages, or a loop's response to a sine.

A millisecond is longer than most windings' L / R; everything else is done in the motion tick.
"""

from ..runtime import const, hot
from .layout import COSINE_AT, CurrentLoop, JointSettings

SUMS = const(1)  # CurrentLoop.probing
SINE_ON_D = const(2)
SINE_ON_Q = const(3)
_BRAD_Q14 = const(41722)  # 65536 / 2 pi a rad, of a bandwidth in Q12


@hot
def probe_begin(loop: CurrentLoop, sign: int) -> None:
    """Begin to add up currents and voltages times ``sign``, from the next current step on."""
    loop.probing = 0  # the interrupt may come between any two of these
    loop.probe_sign = sign
    loop.probe_steps = 0
    loop.sum_current_d = 0
    loop.sum_current_q = 0
    loop.sum_voltage_d = 0
    loop.sum_voltage_q = 0
    loop.probing = 1


@hot
def probe_step(loop: CurrentLoop) -> int:
    """Add up one current step, in the interrupt; change the sign of an alternating voltage.

    Returns the next sign, or the next current of a sine. Up to 46 000 steps of 23170 each stay below 2^30.
    """
    if loop.probing > SUMS:
        return _sine_step(loop)
    sign = loop.probe_sign
    loop.probe_steps += 1
    loop.sum_current_d += loop.current_d * sign
    loop.sum_current_q += loop.current_q * sign
    loop.sum_voltage_d += loop.voltage_d * sign
    loop.sum_voltage_q += loop.voltage_q * sign
    if loop.alternate_d | loop.alternate_q:
        sign = 0 - sign
        loop.probe_sign = sign
        loop.feed_d = loop.level + loop.alternate_d * sign
        loop.feed_q = loop.alternate_q * sign
    return sign


@hot
def sine_begin(loop: CurrentLoop, settings: JointSettings, probing: int) -> None:
    """Begin to add a sine to the wanted current: a quarter of the commissioning current, at current_w."""
    probe_begin(loop, 1)
    loop.probing = 0
    loop.sine_at = 0
    loop.sine_add = settings.current_w * _BRAD_Q14 >> 14
    loop.sine_current = settings.commission_current >> 2
    loop.probing = probing


@hot
def _sine_step(loop: CurrentLoop) -> int:
    """Add up response and error times the sine and its cosine, and set the next current; return it.

    Up to 20000 steps of 24576 cu each stay below 2^30.
    """
    at = loop.sine_at >> 6
    sine = loop.sine[at]
    cosine = loop.sine[at + COSINE_AT]
    wanted = loop.sine_current * sine >> 15
    got = loop.current_q
    if loop.probing == SINE_ON_D:
        got = loop.current_d - loop.level_current
    loop.sum_current_d += got * sine >> 15
    loop.sum_current_q += got * cosine >> 15
    loop.sum_voltage_d += (wanted - got) * sine >> 15
    loop.sum_voltage_q += (wanted - got) * cosine >> 15
    loop.sine_at = (loop.sine_at + loop.sine_add) & 0xFFFF
    wanted = loop.sine_current * loop.sine[loop.sine_at >> 6] >> 15
    if loop.probing == SINE_ON_D:
        loop.reference_d = loop.level_current + wanted
    else:
        loop.reference_q = wanted
    return wanted
