"""The rotor encoder's eccentricity: an off-centre magnet distorts its readings by a wave once and a wave twice a turn.

A table of corrections, linear between its entries, is applied to every reading before the current step. Only these two
harmonics of the measured error are kept: cogging bends the rotor's path as well, but many times a turn.
"""

from ..runtime import hot
from .layout import BENDS, COSINE_AT, CurrentLoop, JointSettings


@hot
def corrected_rotor(loop: CurrentLoop, rotor: int) -> int:
    """Return the corrected rotor angle for a reading, both 0 .. 16383 rc. Error 1 rc and the table's (fill_bend)."""
    at = rotor >> 9
    bend = loop.bend[at]
    return (rotor + bend + ((loop.bend[at + 1] - bend) * (rotor & 511) >> 9)) & 16383


@hot
def fill_bend(loop: CurrentLoop, cos1_q4: int, sin1_q4: int, cos2_q4: int, sin2_q4: int) -> None:
    """Write the table of corrections from its harmonics, rc in Q4, each within +-4095.

    Error 1 rc, and by linear interpolation 0.5 % of the first and 2 % of the second harmonic. Sum below 2^29.
    """
    for at in range(BENDS):
        one = at << 5 & 1023  # of the sine table's 1024 entries a turn
        two = at << 6 & 1023
        wave = cos1_q4 * loop.sine[one + COSINE_AT] + sin1_q4 * loop.sine[one]
        wave += cos2_q4 * loop.sine[two + COSINE_AT] + sin2_q4 * loop.sine[two]
        loop.bend[at] = (wave + 0x40000) >> 19


@hot
def set_bend(loop: CurrentLoop, settings: JointSettings) -> None:
    """Hand the stored eccentricity to the interrupt."""
    fill_bend(loop, settings.bend_cos1, settings.bend_sin1, settings.bend_cos2, settings.bend_sin2)
