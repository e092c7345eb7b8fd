"""Temperatures: sensors with curves as data, a two-node model of the winding, derating, I2t.

Model, per slow tick (J/K and K/W are in the gains the host made): the winding is heated by 1.5 R i^2, with R of copper
at the winding's temperature, and leaks to the housing, the housing to the air. A thermistor between the windings lags
behind the copper, so the hotter of sensor and model counts.
"""

from ..num.fixed import fall_q15, saturate
from ..runtime import Ints, const, hot
from ..wire.names import LIMIT_I2T, LIMIT_MCU_TEMPERATURE, LIMIT_WINDING_TEMPERATURE
from .faults import FAULT_MCU_HOT, FAULT_MCU_SENSOR, FAULT_THERMISTOR_OPEN, FAULT_THERMISTOR_SHORT, FAULT_WINDING_HOT
from .layout import CurrentLoop, JointIo, JointSettings, JointState

CURVE_POINTS = const(32)  # a power of two: a point is found by halving
CURVE_SIZE = const(64)  # the points' ADC counts, growing, then their temperatures in t16

_NODE_MOST = const(0x3FFFFFF)  # t16/2^14: 256 degrees above the air
_SQUARE_MOST = const(0x7FFFF)
_COPPER_Q24 = const(4121)  # 0.00393 per K, in 1/16 K
_WARM_T16 = const(400)  # 25 degrees C, at which the robot file gives the resistance


@hot
def gather_heat(loop: CurrentLoop, state: JointState) -> None:
    """Add this tick's i^2/256 to the sum the slow tick takes. 300 ticks at most: below 2^30."""
    if state.heat_ticks < 300:
        state.heat_sum += loop.current_d * loop.current_d + loop.current_q * loop.current_q >> 8
        state.heat_ticks += 1


@hot
def slow_tick(settings: JointSettings, state: JointState, io: JointIo, curve: Ints) -> int:
    """Read both temperatures, advance the models, set derate, slow_limits, slow_cause; return state.derate (Q15).

    Ten times a second. The current's share falls linearly from 1 at the derating temperature to 0 at
    the cut, winding and MCU alike; at the cut it is also a fault. An open or shorted sensor is a fault.
    """
    state.slow_cause = 0
    state.slow_limits = 0
    winding_known = _read_winding(settings, state, io, curve)
    _read_mcu(settings, state, io)
    square = 0
    if state.heat_ticks > 0:
        square = state.heat_sum // state.heat_ticks
    state.heat_sum = 0
    state.heat_ticks = 0
    model = model_step(settings, state, square)
    if model > state.winding or winding_known == 0:
        state.winding = model
    state.derate = _derate(settings, state, square)
    return state.derate


@hot
def _read_winding(settings: JointSettings, state: JointState, io: JointIo, curve: Ints) -> int:
    """Set state.winding from the thermistor; return 0 if it is open or shorted."""
    raw = io.thermistor_raw
    if raw >= settings.open_raw:
        _slow_cause(state, FAULT_THERMISTOR_OPEN, raw)
        return 0
    if raw <= settings.short_raw:
        _slow_cause(state, FAULT_THERMISTOR_SHORT, raw)
        return 0
    state.winding = thermistor_t16(curve, raw)
    if state.thermal_started == 0:
        state.thermal_started = 1
        model_reset(state, state.winding)
    return 1


@hot
def _read_mcu(settings: JointSettings, state: JointState, io: JointIo) -> None:
    raw = io.mcu_raw
    state.mcu = mcu_t16(raw, settings.mcu_cal1, settings.mcu_cal2)
    if raw <= 0 or raw >= 4095 or settings.mcu_cal1 == settings.mcu_cal2:
        _slow_cause(state, FAULT_MCU_SENSOR, raw)


@hot
def _derate(settings: JointSettings, state: JointState, square: int) -> int:
    """Return the share of the largest current that temperatures and I2t leave, in Q15, with its flags and faults."""
    share = fall_q15(state.winding, settings.winding_derate, settings.winding_cut)
    if share < 0x8000:
        state.slow_limits = state.slow_limits | LIMIT_WINDING_TEMPERATURE
    if state.winding >= settings.winding_cut:
        _slow_cause(state, FAULT_WINDING_HOT, state.winding)
    mcu = fall_q15(state.mcu, settings.mcu_derate, settings.mcu_cut)
    if mcu < 0x8000:
        state.slow_limits = state.slow_limits | LIMIT_MCU_TEMPERATURE
    if state.mcu >= settings.mcu_cut:
        _slow_cause(state, FAULT_MCU_HOT, state.mcu)
    if mcu < share:
        share = mcu
    left = _i2t_share(settings, state, square)
    if left < share:
        share = left
    return share


@hot
def _i2t_share(settings: JointSettings, state: JointState, square: int) -> int:
    excess = i2t_step(settings, state, square)
    most = settings.current_max
    lasting = settings.i2t_current
    if excess >= 0x8000 or lasting >= most or most < 1:
        return 0x8000
    state.slow_limits = state.slow_limits | LIMIT_I2T
    return (lasting << 15) // most + ((most - lasting) * excess) // most


@hot
def _slow_cause(state: JointState, code: int, value: int) -> None:
    """Keep the first cause of a fault in this slow tick, with its value."""
    if state.slow_cause == 0:
        state.slow_cause = code
        state.slow_value = value


@hot
def thermistor_t16(curve: Ints, raw: int) -> int:
    """Return the temperature of a reading from a curve: the counts of CURVE_POINTS points, then their temperatures.

    The curve is data, so NTC and PTC are the same here: the host puts points where the curve bends. Linear between
    points, constant beyond the first and the last. Counts 0 .. 4095, not falling; temperatures within +-2^16. Error at
    most 1 t16 plus the curve's own. Below 2^30.
    """
    at = 0
    half = CURVE_POINTS >> 1
    while half:
        if curve[at + half] <= raw:
            at += half
        half >>= 1
    value = curve[CURVE_POINTS + at]
    if at == CURVE_POINTS - 1 or raw <= curve[at]:
        return value
    span = curve[at + 1] - curve[at]
    return value + ((curve[CURVE_POINTS + at + 1] - value) * (raw - curve[at]) + (span >> 1)) // span


@hot
def mcu_t16(raw: int, cal1: int, cal2: int) -> int:
    """Return the STM32F405's temperature from its sensor: 30 + (raw - cal1) 80 / (cal2 - cal1) degrees C.

    cal1 and cal2 are the factory's readings at 30 and 110 degrees C (datasheet section 5.3.22); all 0 .. 4095. Error 1
    t16. With cal1 = cal2 there is no calibration: 32767, which is never taken for cold.
    """
    span = cal2 - cal1
    if span == 0:
        return 32767
    return 480 + (raw - cal1) * 1280 // span


@hot
def model_reset(state: JointState, air_t16: int) -> None:
    """Start the model with everything at ``air_t16``."""
    state.air = air_t16
    state.model_winding = 0
    state.model_housing = 0


@hot
def model_step(settings: JointSettings, state: JointState, square: int) -> int:
    """Advance the model one slow tick with the mean of i^2/256 (cu^2, 0 .. 2^19 - 1); return the winding in t16.

    Ranges: settings.heat 0 .. 2047 with heat_shift 0 .. 24, the leaks 0 .. 16383 with leak_shift 13 .. 30. Both
    nodes stay within 0 .. 256 degrees above the air, state.air within +-2^13. Error of the end temperature below 1 K.
    Intermediates: 2^19 * 2047 below 2^30; the copper's share of the heat, 2^13 * 2^14 (scaled).
    """
    square = saturate(square, 0, _SQUARE_MOST)
    winding = state.model_winding
    housing = state.model_housing
    flow = winding - housing
    shift = settings.leak_shift
    heat = saturate(square * settings.heat >> settings.heat_shift, 0, _NODE_MOST)
    heat += scaled(heat, copper_share(state.air + (winding >> 14)), 14)
    winding += heat - scaled(flow, settings.winding_leak, shift)
    housing += scaled(flow, settings.housing_gain, shift) - scaled(housing, settings.housing_leak, shift)
    state.model_winding = saturate(winding, 0, _NODE_MOST)
    state.model_housing = saturate(housing, 0, _NODE_MOST)
    return state.air + (state.model_winding >> 14)


@hot
def copper_share(winding_t16: int) -> int:
    """Return the share by which copper's resistance is above that at 25 degrees C, in Q14, -4025 .. 16379.

    winding_t16 within +-2^29: below -37 degrees C that of -37, above 279 that of 279. Error 1.
    """
    return saturate(winding_t16 - _WARM_T16, -1000, 4070) * _COPPER_Q24 >> 10


@hot
def scaled(value: int, factor: int, shift: int) -> int:
    """Return value x factor / 2^shift for value within +-2^26, factor 0 .. 16383, shift 13 .. 30. Error below 1.

    In two halves, so that no product reaches 2^30: each is 2^13 * 2^14 at most.
    """
    return (value >> 13) * factor + ((value & 8191) * factor >> 13) >> shift - 13


@hot
def i2t_step(settings: JointSettings, state: JointState, square: int) -> int:
    """Add i^2 minus the lasting current's to state.i2t; return the share in Q15 of the excess current still allowed.

    square: i^2/256 in cu^2, 0 .. 2^19 - 1. 32768 up to half of i2t_max, then linearly to 0 at i2t_max
    (2 .. 2^29), where only i2t_current is left. Error 2^-14.
    """
    current = settings.i2t_current
    top = settings.i2t_max
    total = saturate(state.i2t + square - (current * current >> 8), 0, top)
    state.i2t = total
    shift = 0
    while (top >> shift) > 32767:
        shift += 1
    return fall_q15(total >> shift, top >> shift + 1, top >> shift)
