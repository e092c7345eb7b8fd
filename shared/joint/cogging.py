"""Cogging: magnets and teeth pull the rotor to and fro as it turns, and a current fed forward compensates for that.

A table of waves over the rotor's turn: how often a turn each comes, its current, and its phase at the reading 0. They
are added up at each reading of the rotor, before the current step. The wanted current and the waves together stay
within the current limit.
"""

from ..num.fixed import saturate
from ..runtime import const, hot
from .commission_state import Commission
from .layout import WAVES, CurrentLoop, JointSettings

_SINE_STEPS = const(1023)  # of the sine table, less one


@hot
def cogging_step(loop: CurrentLoop, rotor: int) -> int:
    """Set loop.cogging_q for a rotor at ``rotor`` (corrected, 0 .. 16383) and return it, in cu; in the interrupt.

    Error 1 cu, and 0.3 % of each wave because of the sine table's step. Below 2^30 for amplitudes below 2^15 (Q4).
    """
    current = 8
    for wave in range(loop.waves):
        at = (rotor * loop.wave_order[wave] >> 4) + loop.wave_phase[wave]
        current += loop.wave_current[wave] * loop.sine[at & _SINE_STEPS] >> 15
    wanted = loop.reference_q
    current = (current >> 4) + wanted
    most = loop.current_most
    if current > most:
        current = most
    elif current < 0 - most:
        current = 0 - most
    current -= wanted
    loop.cogging_q = current
    return current


@hot
def set_waves(loop: CurrentLoop, settings: JointSettings) -> int:
    """Hand the stored waves to the interrupt; return how many there are."""
    put_wave(loop, 0, settings.cogging_order_0, settings.cogging_current_0, settings.cogging_phase_0)
    put_wave(loop, 1, settings.cogging_order_1, settings.cogging_current_1, settings.cogging_phase_1)
    put_wave(loop, 2, settings.cogging_order_2, settings.cogging_current_2, settings.cogging_phase_2)
    return WAVES


@hot
def put_wave(loop: CurrentLoop, wave: int, order: int, current_q4: int, phase_brad: int) -> None:
    """Set one wave: 0 .. 511 times a turn, 0 .. 32767 cu in Q4, phase at the reading 0 in brad."""
    loop.wave_order[wave] = order
    loop.wave_current[wave] = saturate(current_q4, 0, 0x7FFF)
    loop.wave_phase[wave] = (phase_brad + 32 >> 6) & _SINE_STEPS


@hot
def try_wave(loop: CurrentLoop, commission: Commission, wave: int) -> None:
    """Set one wave as commissioning found it."""
    put_wave(loop, wave, commission.wave_order[wave], commission.wave_current[wave], commission.wave_phase[wave])


@hot
def drop_wave(loop: CurrentLoop, commission: Commission, wave: int) -> None:
    """Forget a wave that commissioning found."""
    commission.wave_order[wave] = 0
    commission.wave_current[wave] = 0
    try_wave(loop, commission, wave)


@hot
def switch_waves(loop: CurrentLoop, on: int) -> int:
    """Switch the waves on (``on`` 1) or off (0); return how many act."""
    loop.waves = 0
    if on:
        loop.waves = WAVES
    else:
        loop.cogging_q = 0
    return loop.waves
