"""A field that turns as wanted holds the rotor like a spring, in the current step, and the velocity loop damps.

This is stiffer than any velocity loop: strong cogging does not let the rotor hop from tooth to tooth. The commissioning
current flows along the field; across it flows what the velocity loop asks for and what the waves add. The rotor is
turned by the current across its flux, which follows from its lag behind the field; where both axes' inductances differ,
the current along the flux adds to the flux or takes from it.
"""

from ..num.fixed import cos_q15, saturate, sin_q15, wrap_brad
from ..runtime import const, hot
from .commission_state import STEPS, Commission, fail
from .commutation import point
from .faults import FAULT_COMMISSION_COGGING
from .layout import CurrentLoop, JointSettings, JointState

_LAG_MOST = const(16384)  # brad: a quarter of an electrical turn, beyond which no field holds a rotor
_SUM_MOST = const(0x1FFFF)  # cu, times 10
_APART_MOST = const(0x7FFFF)  # of a difference of inductances / 16: its product with 2^11 stays below 2^30
_PART_MOST = const(0x7FFF)
_SHARE_MOST = const(192)  # in 1/256
_TAKEN_MOST = const(1023)  # in 1/256: its product with the largest current stays below 2^28


@hot
def hold_rotor(loop: CurrentLoop, settings: JointSettings, state: JointState, commission: Commission) -> int:
    """Turn the field by one tick of swing_reference, at first from the rotor's angle; return the field's angle."""
    pairs = commission.pole_pairs
    if loop.electrical_gain:
        commission.field_q6 = 4 * pairs * commission.direction * loop.rotor + commission.offset_found << 6
    commission.field_q6 = (commission.field_q6 + commission.swing_reference * pairs) & 0x3FFFFF
    commission.angle = commission.field_q6 >> 6
    point(loop, commission)
    most = settings.commission_current
    across = state.current_reference * settings.joint_sign * commission.direction
    loop.reference_d = most
    loop.reference_q = saturate(across, 0 - most, most)
    return commission.angle


@hot
def turning_current(settings: JointSettings, commission: Commission, d: int, q: int, rotor: int, moved: int) -> int:
    """Return the current across the flux, times 10, that has the effect of the last tick's currents on the held rotor.

    d, q: sums over that tick along and across the field, cu; rotor at its end, rc; moved in it, electrical-signed. The
    current along the rotor's flux takes its share of that. A rotor a quarter of an electrical turn away is lost:
    refused. Error 16 cu, and of the lag 1 brad for each pole pair. Intermediates: 2^15 * 2^14 * sqrt 2, and below
    2^18 * 2^10.
    """
    pairs = commission.pole_pairs
    middle = 4 * pairs * commission.direction * rotor - 2 * pairs * moved + commission.offset_found
    lag = wrap_brad(commission.angle - middle)
    if lag > _LAG_MOST or lag < -_LAG_MOST:
        fail(commission, FAULT_COMMISSION_COGGING, settings.commission_current)
    sine = sin_q15(lag) >> 1
    cosine = cos_q15(lag) >> 1
    d = saturate(d, -_SUM_MOST, _SUM_MOST) >> 3
    q = saturate(q, -_SUM_MOST, _SUM_MOST) >> 3
    across = d * sine + q * cosine >> 11
    along = d * cosine - q * sine >> 11
    taken = along * commission.flux_taken // (saturate(settings.commission_current, 1, 0x7FFF) * STEPS)
    return across - (across * saturate(taken, -_TAKEN_MOST, _TAKEN_MOST) >> 8)


@hot
def find_flux_taken(settings: JointSettings, commission: Commission) -> int:
    """Find the share of the flux, in 1/256, that the commissioning current takes: (Lq - Ld) i / flux; return it.

    Limited to 3/4. Error 0.01 of the flux and 2 %. Intermediates: 2^19 * 2^11.
    """
    apart = saturate(commission.inductance_q - commission.inductance_d >> 4, -_APART_MOST, _APART_MOST)
    share = apart * (settings.commission_current >> 4) // saturate(commission.flux, 1, 0x3FFF)
    share = saturate(share, -_PART_MOST, _PART_MOST) * commission.pole_pairs * 20 // 255  # 2 pi / 80
    commission.flux_taken = saturate(share, -_SHARE_MOST, _SHARE_MOST)
    return commission.flux_taken
