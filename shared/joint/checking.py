"""Waves of the cogging are checked by their purpose, an even speed: one round without them and one with them.

A wave has to halve the ripple of the speed at its own number per turn, else it is dropped. It is also dropped if its
ripple was less than what the first wave leaves, or than half of what its current would make, and if it is below a
sixteenth of the friction: friction alone made waves of 1/25 of it.
"""

from ..num.fixed import saturate
from ..runtime import const, hot
from .cogging import drop_wave, switch_waves, try_wave
from .commission_state import Commission
from .creeping import CREEP_WITH, CREEP_WITHOUT, begin_round
from .layout import WAVES, CurrentLoop, JointSettings
from .spectrum import look_for, wave_amplitude

_LEFT_MOST = const(128)  # of the ripple, in 1/256


@hot
def begin_check(loop: CurrentLoop, settings: JointSettings, commission: Commission, least: int) -> int:
    """Set up the settled first wave and all others of an amplitude of at least ``least``, but creep without; return 0.

    If the settled one is the only one there is nothing to check: return 1.
    """
    others = 0
    if least < commission.coulomb >> 4:
        least = commission.coulomb >> 4
    for wave in range(WAVES):
        if wave >= commission.creep_settled:
            if commission.wave_current[wave] < least:
                drop_wave(loop, commission, wave)
            others += commission.wave_order[wave]
        try_wave(loop, commission, wave)
    if others == 0:
        return 1
    switch_waves(loop, 0)
    commission.rejected_waves = 0
    begin_round(loop, settings, commission, CREEP_WITHOUT)
    return 0


@hot
def check_wave(loop: CurrentLoop, settings: JointSettings, commission: Commission) -> int:
    """Take the ripple without or with a wave; after the last wave go on. Return 1 when the check is over."""
    ripple = 0
    if commission.order > 0:
        ripple = wave_amplitude(commission)
    wave = commission.wave
    if commission.creep_part == CREEP_WITHOUT:
        commission.ripple[wave] = ripple
        commission.rejected_waves |= _too_quiet(commission, wave) << wave
    else:
        commission.rejected_waves |= _rejected(commission, wave, ripple) << wave
    look_for(commission, commission.order)
    if wave < WAVES - 1:
        commission.wave = wave + 1
        commission.order = commission.wave_order[wave + 1]
        return 0
    if commission.creep_part == CREEP_WITHOUT:
        switch_waves(loop, 1)
        begin_round(loop, settings, commission, CREEP_WITH)
        return 0
    for each in range(WAVES):
        if commission.rejected_waves >> each & 1:
            drop_wave(loop, commission, each)
    return 1


@hot
def _too_quiet(commission: Commission, wave: int) -> int:
    """Return 1 if a wave's ripple is less than half of what its current would make, as the settled first one's does."""
    if wave == 0 or commission.creep_settled == 0:
        return 0
    makes = commission.ripple[0] * (commission.wave_current[wave] >> 4)
    if commission.ripple[wave] * (commission.wave_current[0] >> 3) < makes:
        return 1
    return 0


@hot
def _rejected(commission: Commission, wave: int, ripple: int) -> int:
    """Return 1 if a wave leaves more than half of its ripple, or its ripple was less than the first leaves; else 0."""
    before = commission.ripple[wave]
    if wave == 0:
        commission.ripple[0] = ripple  # what it leaves, from here on
    if wave < commission.creep_settled or commission.order == 0:
        return 0
    if (ripple << 8) // saturate(before, 1, 0xFFFF) > _LEFT_MOST or before < commission.ripple[0]:
        return 1
    return 0
