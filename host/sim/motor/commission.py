"""The simulated joint measures its motor: commissioning of a fresh joint."""

from math import degrees, hypot, tau

from shared.joint.commission_state import COMMISSION_FULL
from shared.wire import names as w

from ...robot.actuators import Bldc
from ...robot.joint_faults import fault_sentence
from .bench import Bench
from .result import Result

ECCENTRIC_RAD = 0.02  # of the rotor encoder: 1.1 degrees (chosen)
LEFT_DEG = 0.1
MOST = {"resistance_error": 0.05, "inductance_d_error": 0.05, "inductance_q_error": 0.05, "flux_error": 0.03}


def commission(bldc: Bldc) -> Result:
    """Commission a fresh joint: commutation, resistance, inductance, flux linkage, eccentricity."""
    true_rad = 2.345
    bench = Bench(bldc, commissioned=False, elec_offset_rad=true_rad)
    bench.wrong.eccentric_rad = ECCENTRIC_RAD
    result = bench.request(w.COMMAND_COMMISSION, COMMISSION_FULL)
    for _ in range(600):
        bench.run(100)
        if bench.state.drive_state in (w.STATE_SWITCH_ON_DISABLED, w.STATE_FAULT):
            break
    settings, commission, units = bench.joint.control.settings, bench.joint.control.commission, bench.units
    error = (settings.elec_offset - true_rad / tau * 65536 + 32768) % 65536 - 32768
    ohm, henry = bench.motor.resistance_ohm(), bldc.motor.inductance_H * bldc.drive.current_loop_hz
    per_raw = units.volt_per_vu / units.ampere_per_cu / 65536
    off = {
        "resistance_error": commission.resistance * per_raw / ohm - 1,
        "inductance_d_error": commission.inductance_d * per_raw / henry - 1,
        "inductance_q_error": commission.inductance_q * per_raw / henry - 1,
        "flux_error": settings.bemf / bench.blocks.settings.bemf - 1,
    }
    bend_deg = hypot(settings.bend_cos1, settings.bend_sin1) / 16 * 360 / 16384
    left_deg = abs(bend_deg - degrees(ECCENTRIC_RAD))
    found = bool(settings.commissioned and not commission.reason and result == w.RESULT_OK)
    exact = abs(error) * 360 / 65536 < 2 and settings.pole_pairs == bldc.motor.pole_pairs and left_deg < LEFT_DEG
    figures = {
        "ok": found and exact and all(abs(off[name]) < most for name, most in MOST.items()),
        "pole_pairs": settings.pole_pairs,
        "direction": settings.direction,
        "offset_error_elec_deg": round(error * 360 / 65536, 3),
        **{name: round(value, 4) for name, value in off.items()},
        "eccentricity_left_deg": round(left_deg, 3),
        "duration_s": round(bench.time_s, 2),
        "reason": "" if found else fault_sentence(commission.reason, commission.reason_value, units),
    }
    return Result("commission", figures, bench)
