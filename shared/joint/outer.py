"""Gains of the velocity and position loops from the inertia found; keeps those from before commissioning.

kp = J w and ki = kp w / 4 for the velocity loop, half of kp for damping, and the acceleration that 0.6 of the current
limit gives. The position loop's gain is its bandwidth, whatever mass turns.
"""

from ..num.fixed import saturate
from ..runtime import const, hot
from .commission_state import Commission
from .layout import JointSettings

_P_MOST = const(8191)  # limits of the parameters
_I_MOST = const(8191)
_INERTIA_MOST = const(0x3FFF0)  # Q12
_RATE_MOST = const(65535)


@hot
def set_outer_gains(settings: JointSettings, inertia_q12: int, w: int) -> int:
    """Set the gains for an inertia in cu / (rate / tick), Q12; return 1, or 0 if they are out of range.

    w 0 .. 20588 (Q16). The inertia's 2^18 times 2^12 (w >> 2) stays below 2^30. Error 1/2 of each and 0.1 %.
    """
    if inertia_q12 < 16 or inertia_q12 > _INERTIA_MOST:
        return 0
    proportional = ((inertia_q12 * (w >> 3)) + 0x1000) >> 13
    if proportional < 4 or proportional > _P_MOST:
        return 0
    integral = (proportional * w + 0x800) >> 12 >> 2
    if integral < 1 or integral > _I_MOST:
        return 0
    settings.velocity_p = proportional
    settings.velocity_i = integral
    settings.damp = proportional >> 1
    settings.inertia = (inertia_q12 + 8) >> 4
    acceleration = (settings.commission_current << 12) // inertia_q12
    settings.accel = saturate(acceleration + acceleration // 5, 16, _RATE_MOST)
    return 1


@hot
def keep_outer(settings: JointSettings, commission: Commission) -> None:
    """Keep the gains from before commissioning."""
    kept = commission.outer_before
    kept[0] = settings.velocity_p
    kept[1] = settings.velocity_i
    kept[2] = settings.damp
    kept[3] = settings.inertia
    kept[4] = settings.accel


@hot
def restore_outer(settings: JointSettings, commission: Commission) -> None:
    """Restore the gains from before commissioning, if any are kept."""
    kept = commission.outer_before
    if kept[0] == 0:
        return
    settings.velocity_p = kept[0]
    settings.velocity_i = kept[1]
    settings.damp = kept[2]
    settings.inertia = kept[3]
    settings.accel = kept[4]
    kept[0] = 0
