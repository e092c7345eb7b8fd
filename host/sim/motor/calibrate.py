"""The simulated joint finds its own commutation: full calibration of one that nobody has calibrated."""

from math import tau

from shared.joint.calibration import CAL_FULL
from shared.wire import names as w

from ...robot.actuators import Bldc
from ...robot.joint_faults import fault_sentence
from .bench import Bench
from .result import Result


def calibrate(bldc: Bldc) -> Result:
    """Full calibration of a joint nobody has calibrated: offset, direction, pole pairs; then it moves."""
    true_rad = 2.345
    bench = Bench(bldc, calibrated=False, elec_offset_rad=true_rad)
    result = bench.request(w.COMMAND_CALIBRATE, CAL_FULL)
    for _ in range(200):
        bench.run(100)
        if bench.state.drive_state in (w.STATE_SWITCH_ON_DISABLED, w.STATE_FAULT):
            break
    settings, calibration = bench.joint.control.settings, bench.joint.control.calibration
    error = (settings.elec_offset - true_rad / tau * 65536 + 32768) % 65536 - 32768
    found = bool(settings.calibrated and not calibration.reason and result == w.RESULT_OK)
    figures = {
        "ok": found and abs(error) * 360 / 65536 < 5 and settings.pole_pairs == bldc.motor.pole_pairs,
        "pole_pairs": settings.pole_pairs,
        "direction": settings.direction,
        "offset_error_elec_deg": round(error * 360 / 65536, 3),
        "duration_s": round(bench.time_s, 2),
        "reason": "" if found else fault_sentence(calibration.reason, calibration.reason_value, bench.units),
    }
    return Result("calibrate", figures, bench)
