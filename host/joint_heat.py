"""A joint's heat in integers: the thermistor's curve, the two-node model of winding and housing, the derating."""

from math import log

from shared.joint import layout as j
from shared.joint.thermal import CURVE_SIZE

from .joint_units import Board, JointSetup, Units
from .robot_actuators import Bldc

SLOW_HZ = 10  # slow_tick
PTC_PER_K = 0.0078  # silicon sensor, per K at 25 degrees C (typical datasheet value)


def heat_places(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    """Return the thermal places of cfg: limits, heating and leaks of the model, I2t."""
    t, watt = bldc.thermal, 1.5 * bldc.motor.resistance_ohm * units.ampere_per_cu**2 * 256
    heat, heat_shift = _with_shift(watt / t.winding_J_K / SLOW_HZ * 16 * 16384, 2047, 24)
    leaks = [
        1 / (t.winding_J_K * t.winding_to_housing_K_W) / SLOW_HZ,
        1 / (t.housing_J_K * t.winding_to_housing_K_W) / SLOW_HZ,
        1 / (t.housing_J_K * t.housing_to_air_K_W) / SLOW_HZ,
    ]
    _, shift = _with_shift(max(leaks), 16383, 30)
    limit = bldc.drive.current_limit_A
    lasting = min(setup.continuous_A or limit, limit)
    most, least = limit / units.ampere_per_cu, lasting / units.ampere_per_cu
    return {
        j.K_OPEN_RAW: 4032,
        j.K_SHORT_RAW: 32,
        j.K_MCU_CAL1: board.mcu_cal1,
        j.K_MCU_CAL2: board.mcu_cal2,
        j.K_WINDING_DERATE: round(t.winding_derate_C * 16),
        j.K_WINDING_CUT: round(t.winding_cutoff_C * 16),
        j.K_MCU_DERATE: round(t.board_derate_C * 16),
        j.K_MCU_CUT: round(t.board_cutoff_C * 16),
        j.K_HEAT: heat,
        j.K_HEAT_SHIFT: heat_shift,
        j.K_WINDING_LEAK: round(leaks[0] * 2**shift),
        j.K_HOUSING_GAIN: round(leaks[1] * 2**shift),
        j.K_HOUSING_LEAK: round(leaks[2] * 2**shift),
        j.K_LEAK_SHIFT: shift,
        j.K_I2T_CURRENT: round(least),
        j.K_I2T_MAX: min(1 << 29, max(2, round((most**2 - least**2) / 256 * SLOW_HZ * setup.peak_s))),
    }


def thermistor_curve(bldc: Bldc, board: Board) -> list[int]:
    """Return CURVE_SIZE temperatures in 1/16 degree C over the ADC's range, -60 .. 250 degrees C."""
    step = 4096 // (CURVE_SIZE - 1)
    points = []
    for i in range(CURVE_SIZE):
        raw = min(max(i * step, 1), 4095)
        ohm = board.thermistor_pull_up_ohm * raw / (4096 - raw)
        points.append(round(16 * min(max(thermistor_C(bldc, ohm), -60.0), 250.0)))
    return points


def thermistor_C(bldc: Bldc, ohm: float) -> float:
    """Return the temperature of a resistance: R25 exp(B (1/T - 1/T25)), or a silicon sensor's straight line."""
    t = bldc.thermal
    if t.thermistor == "ptc":
        return 25.0 + (ohm / t.thermistor_25C_ohm - 1) / PTC_PER_K
    inverse = 1 / 298.15 + log(ohm / t.thermistor_25C_ohm) / t.thermistor_beta_K
    return 1 / inverse - 273.15 if inverse > 1e-4 else 250.0


def _with_shift(value: float, most: int, shift_most: int) -> tuple[int, int]:
    """Return (mantissa, shift) with value = mantissa / 2^shift and the mantissa as large as ``most`` allows."""
    shift = 0
    while shift < shift_most and value * 2 ** (shift + 1) <= most:
        shift += 1
    return round(value * 2**shift), shift
