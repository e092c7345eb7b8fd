"""What the joint reports, in the wire's units (docs/can-protocol.md), saturated, never wrapped."""

from ..num.fixed import saturate
from ..runtime import const, hot
from .layout import CurrentLoop, JointSettings, JointState

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
def report_position(settings: JointSettings, state: JointState) -> int:
    """Return the joint's position in brad."""
    return position_to_wire(state.position, settings.gear_q8)


@hot
def report_velocity(settings: JointSettings, state: JointState) -> int:
    """Return the joint's velocity in 1/4096 turn/s. Error below 1 plus 4 rate units."""
    return saturate((state.velocity >> 2) * settings.wire_rate_q16 >> 14, -_INT16, _INT16)


@hot
def report_current(loop: CurrentLoop, settings: JointSettings) -> int:
    """Return the measured q current in 1/4096 A, positive when it drives the joint forward. Error below 1."""
    current = loop.current_q * settings.joint_sign
    if loop.electrical_gain < 0:
        current = 0 - current
    return saturate(current * settings.wire_current_q12 >> 12, -_INT16, _INT16)


@hot
def report_temperature(value_t16: int) -> int:
    """Return 1/16 degree C for any value in that unit, within +-4095. Exact."""
    return saturate(value_t16, -_INT13, _INT13)


@hot
def report_bus(settings: JointSettings, state: JointState) -> int:
    """Return the bus voltage in 1/16 V, 0 .. 1023. Rounds down."""
    return saturate(state.bus * settings.wire_bus_q12 >> 12, 0, _UINT10)
