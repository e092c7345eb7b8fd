"""The simulated joint finds its own commutation: full calibration of one that nobody has calibrated."""

from math import tau

from shared.joint import layout as j
from shared.joint.calibration import C_REASON, C_VALUE, CAL_FULL
from shared.wire import names as w

from ..joint_faults import fault_sentence
from ..robot_actuators import Bldc
from .bench import Bench
from .result import Result


def calibrate(bldc: Bldc) -> Result:
    """Full calibration of a joint nobody has calibrated: offset, direction, pole pairs; then it moves."""
    true_rad = 2.345
    bench = Bench(bldc, calibrated=False, elec_offset_rad=true_rad)
    result = bench.request(w.COMMAND_CALIBRATE, CAL_FULL)
    for _ in range(200):
        bench.run(100)
        if bench.state[j.S_DRIVE] in (w.STATE_SWITCH_ON_DISABLED, w.STATE_FAULT):
            break
    cfg, cal = bench.joint.control.cfg, bench.joint.control.cal
    error = (cfg[j.K_ELEC_OFFSET] - true_rad / tau * 65536 + 32768) % 65536 - 32768
    found = bool(cfg[j.K_CALIBRATED] and not cal[C_REASON] and result == w.RESULT_OK)
    figures = {
        "ok": found and abs(error) * 360 / 65536 < 5 and cfg[j.K_POLE_PAIRS] == bldc.motor.pole_pairs,
        "pole_pairs": cfg[j.K_POLE_PAIRS],
        "direction": cfg[j.K_DIRECTION],
        "offset_error_elec_deg": round(error * 360 / 65536, 3),
        "duration_s": round(bench.time_s, 2),
        "reason": "" if found else fault_sentence(cal[C_REASON], cal[C_VALUE], bench.units),
    }
    return Result("calibrate", figures, bench)
