"""What the joint reports, in the wire's units (docs/can-protocol.md), saturated, never wrapped."""

from ..fixed import saturate
from ..runtime import Ints, const, hot
from .layout import (
    F_ELEC_GAIN,
    F_I_Q,
    K_GEAR_Q8,
    K_JOINT_SIGN,
    K_WIRE_BUS_Q12,
    K_WIRE_CURRENT_Q12,
    K_WIRE_RATE_Q16,
    S_BUS,
    S_POSITION,
    S_VELOCITY,
)

_INT16 = const(32767)
_INT13 = const(4095)
_UINT10 = const(1023)
_POSITION_MOST = const(0x1FFFFF)


@hot
def position_to_wire(position_rc: int, gear_q8: int) -> int:
    """Return brad (1/65536 joint turn) for rc and a gear 1 .. 63.99 (Q8), within +-32767. Rounds down: error below 1.

    In two divisions, so that nothing reaches 2^30. gear_q8 below 4, which would, gives 0.
    """
    if gear_q8 < 4:
        return 0
    scaled = saturate(position_rc, -_POSITION_MOST, _POSITION_MOST) << 8
    whole = scaled // gear_q8
    rest = scaled - whole * gear_q8
    return saturate((whole << 2) + (rest << 2) // gear_q8, -_INT16, _INT16)


@hot
def report_position(cfg: Ints, state: Ints) -> int:
    """Return the joint's position in brad."""
    return position_to_wire(state[S_POSITION], cfg[K_GEAR_Q8])


@hot
def report_velocity(cfg: Ints, state: Ints) -> int:
    """Return the joint's velocity in 1/4096 turn/s. Error below 1 plus 4 rate units."""
    return saturate((state[S_VELOCITY] >> 2) * cfg[K_WIRE_RATE_Q16] >> 14, -_INT16, _INT16)


@hot
def report_current(foc: Ints, cfg: Ints) -> int:
    """Return the measured q current in 1/4096 A, positive when it drives the joint forward. Error below 1."""
    current = foc[F_I_Q] * cfg[K_JOINT_SIGN]
    if foc[F_ELEC_GAIN] < 0:
        current = 0 - current
    return saturate(current * cfg[K_WIRE_CURRENT_Q12] >> 12, -_INT16, _INT16)


@hot
def report_temperature(value_t16: int) -> int:
    """Return 1/16 degree C for any value in that unit, within +-4095. Exact."""
    return saturate(value_t16, -_INT13, _INT13)


@hot
def report_bus(cfg: Ints, state: Ints) -> int:
    """Return the bus voltage in 1/16 V, 0 .. 1023. Rounds down."""
    return saturate(state[S_BUS] * cfg[K_WIRE_BUS_Q12] >> 12, 0, _UINT10)
