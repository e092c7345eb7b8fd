"""A joint's heat in integers: the two-node model of winding and housing, the derating."""

from .actuators import Bldc
from .joint_units import Board, JointSetup, Units
from .thermistor import OPEN_RAW, SHORT_RAW

SLOW_HZ = 10  # slow_tick
COPPER_PER_K = 0.00393  # resistance of copper; shared/joint/thermal.py has the same


def heat_places(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    """Return the thermal settings: limits, heating and leaks of the model, I2t."""
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
        "open_raw": OPEN_RAW,
        "short_raw": SHORT_RAW,
        "mcu_cal1": board.mcu_cal1,
        "mcu_cal2": board.mcu_cal2,
        "winding_derate": round(t.winding_derate_C * 16),
        "winding_cut": round(t.winding_cutoff_C * 16),
        "mcu_derate": round(t.board_derate_C * 16),
        "mcu_cut": round(t.board_cutoff_C * 16),
        "heat": heat,
        "heat_shift": heat_shift,
        "winding_leak": round(leaks[0] * 2**shift),
        "housing_gain": round(leaks[1] * 2**shift),
        "housing_leak": round(leaks[2] * 2**shift),
        "leak_shift": shift,
        "i2t_current": round(least),
        "i2t_max": min(1 << 29, max(2, round((most**2 - least**2) / 256 * SLOW_HZ * setup.peak_s))),
    }


def _with_shift(value: float, most: int, shift_most: int) -> tuple[int, int]:
    """Return (mantissa, shift) with value = mantissa / 2^shift and the mantissa as large as ``most`` allows."""
    shift = 0
    while shift < shift_most and value * 2 ** (shift + 1) <= most:
        shift += 1
    return round(value * 2**shift), shift
