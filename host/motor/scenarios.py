"""What `caramelo motor sim` can show: a motion, a fault or the calibration of a simulated joint, with figures."""

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, degrees, pi, sin, sqrt, tau
from typing import Any

from shared.joint import faults as f
from shared.joint import layout as j
from shared.joint.calibration import C_REASON, C_VALUE, CAL_FULL
from shared.wire import names as w

from ..errors import UserError
from ..joint_faults import fault_name, fault_sentence
from ..joint_gains import JointSetup
from ..robot_actuators import Bldc
from .bench import STEP_S, Bench
from .model import Load

STEP_RAD = 0.5
STEP_MS = 1500
SETTLED_DEG = 0.2
SINE_HZ, SINE_RAD, SINE_MS = 2.0, 0.3, 2500
SINE_SKIP_MS = 500
HOT_MS = 25000
CURRENT_A = 1.0
SPEED_SHARES = (-0.9, -0.4, -0.05, 0.05, 0.4, 0.9)
LOAD_NM = 1.0
OVERSHOOT = 0.1  # that the current loop is allowed, of a step


@dataclass
class Result:
    """The figures, as they go into JSON, and the bench with its record."""

    name: str
    figures: dict[str, Any]
    bench: Bench

    @property
    def ok(self) -> bool:
        """Whether the scenario's bar was reached."""
        return bool(self.figures["ok"])


def step(bldc: Bldc) -> Result:
    """Position step of 0.5 rad with the leg's inertia, under the current limit."""
    bench = Bench(bldc)
    start = bench.motor.joint_rad
    bench.arm(w.MODE_POSITION, start)
    began = len(bench.trace.time_s)
    bench.goal = start + STEP_RAD
    bench.run(STEP_MS)
    way = [degrees(x - bench.goal) for x in bench.trace.joint_rad[began:]]
    peak = max(bench.trace.peak_A[began:])
    outside = [i for i, error in enumerate(way) if abs(error) > SETTLED_DEG]
    overshoot = 100 * max(0.0, max(way)) / degrees(STEP_RAD)
    error = max(abs(x) for x in way[-200:])
    limit = bldc.drive.current_limit_A
    figures = {
        "ok": bool(error <= SETTLED_DEG and overshoot < 5 and peak <= limit and _enabled(bench)),
        "settling_error_deg": round(error, 4),
        "overshoot_percent": round(overshoot, 3),
        "max_phase_current_A": round(peak, 4),
        "settling_time_s": round((outside[-1] + 1) / 1000, 4) if outside else 0.0,
        "current_limit_A": limit,
        "max_speed_rad_s": round(max(abs(x) for x in bench.trace.speed_rad_s[began:]), 3),
    }
    return Result("step", figures, bench)


def sine(bldc: Bldc) -> Result:
    """Tracking of 0.3 rad at 2 Hz, velocity fed forward, set-points at 200 Hz."""
    bench = Bench(bldc)
    middle = bench.motor.joint_rad + SINE_RAD
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    began = len(bench.trace.time_s)
    for _ in range(SINE_MS):
        phase = tau * SINE_HZ * (len(bench.trace.time_s) - began) / 1000
        bench.goal = middle - SINE_RAD * cos(phase)
        bench.goal_speed = SINE_RAD * tau * SINE_HZ * sin(phase)
        bench.run(1)
    errors = [
        degrees(x - goal)
        for x, goal in zip(
            bench.trace.joint_rad[began + SINE_SKIP_MS :], bench.trace.goal_rad[began + SINE_SKIP_MS :], strict=True
        )
    ]
    rms = sqrt(sum(x * x for x in errors) / len(errors))
    figures = {
        "ok": bool(rms <= 1.0 and _enabled(bench)),
        "tracking_rms_deg": round(rms, 4),
        "tracking_max_deg": round(max(abs(x) for x in errors), 4),
        "max_phase_current_A": round(max(bench.trace.peak_A[began:]), 4),
        "frequency_hz": SINE_HZ,
        "amplitude_rad": SINE_RAD,
    }
    return Result("sine", figures, bench)


def current(bldc: Bldc) -> Result:
    """Step of the current loop with the rotor locked, looked at in every current step."""
    bench = Bench(bldc, Load(blocked=True, ideal_gear=True))
    bench.arm(w.MODE_CURRENT, 0.0)
    bench.run(100)
    bench.goal, bench.fast = CURRENT_A, []
    bench.run(50)
    way = bench.fast
    settled = sum(way[-100:]) / 100
    low = next(i for i, x in enumerate(way) if x >= 0.1 * CURRENT_A)
    high = next(i for i, x in enumerate(way) if x >= 0.9 * CURRENT_A)
    rise_ms = (_crossing(way, high, 0.9) - _crossing(way, low, 0.1)) * 1000 * STEP_S
    overshoot = 100 * (max(way) / CURRENT_A - 1)
    error = 100 * abs(settled / CURRENT_A - 1)
    figures = {
        "ok": bool(rise_ms < 1 and overshoot < 100 * OVERSHOOT and error <= 1),
        "rise_10_90_ms": round(rise_ms, 4),
        "overshoot_percent": round(overshoot, 2),
        "steady_error_percent": round(error, 3),
        "max_phase_current_A": round(max(bench.trace.peak_A), 4),
    }
    return Result("current", figures, bench)


def closed_loop(bldc: Bldc) -> Result:
    """Mean currents of both axes against their references while the joint turns under load, up to its full speed."""
    rated = bldc.drive.current_limit_A
    rows, bench = [], Bench(bldc)
    for share in SPEED_SHARES:
        for torque in (-LOAD_NM, LOAD_NM):
            bench = Bench(bldc, Load(torque_Nm=torque), JointSetup(-3.1, 3.1))
            bench.arm(w.MODE_VELOCITY, 0.0)
            bench.goal = share * bldc.drive.speed_limit_rad_s
            bench.run(150)
            rows.append(_axis_errors(bench, 60))
    worst_d, worst_q = max(abs(d) for d, _ in rows), max(abs(q) for _, q in rows)
    figures = {
        "ok": bool(max(worst_d, worst_q) <= rated / 100 and _enabled(bench)),
        "worst_d_error_percent": round(100 * worst_d / rated, 3),
        "worst_q_error_percent": round(100 * worst_q / rated, 3),
        "rated_A": rated,
        "speeds_rad_s": [round(share * bldc.drive.speed_limit_rad_s, 2) for share in SPEED_SHARES],
    }
    return Result("closed-loop", figures, bench)


def _axis_errors(bench: Bench, milliseconds: int) -> tuple[float, float]:
    """Return the mean true current of d, and of q minus its reference, in A."""
    d = q = 0.0
    for _ in range(milliseconds):
        bench.run(1)
        d += bench.motor.i_d
        q += bench.motor.i_q - bench.joint.control.foc[j.F_Q_REF] * bench.units.ampere_per_cu
    return d / milliseconds, q / milliseconds


def _crossing(way: list[float], at: int, share: float) -> float:
    """Return when, in steps, the way to CURRENT_A passes a share of it just before sample ``at``."""
    if at == 0:
        return 0.0
    return at - (way[at] - share * CURRENT_A) / (way[at] - way[at - 1])


def stall(bldc: Bldc) -> Result:
    """Blocked at the current limit: torque with an ideal gear; then badly cooled until the current is derated."""
    cold = Bench(bldc, Load(blocked=True, ideal_gear=True))
    limit = bldc.drive.current_limit_A
    cold.arm(w.MODE_CURRENT, 0.0)
    cold.goal = limit
    cold.run(1200)
    torque = sum(cold.trace.torque_Nm[-100:]) / 100
    peak = max(cold.trace.peak_A)
    hot = Bench(
        bldc,
        Load(blocked=True, ideal_gear=True, air_C=45.0, winding_J_K=1.0, housing_J_K=1.5, housing_to_air_K_W=25.0),
    )
    hot.arm(w.MODE_CURRENT, 0.0)
    began = len(hot.trace.time_s)
    hot.goal = limit
    hot.run(HOT_MS)
    hottest = max(hot.trace.winding_C)
    derated = next((i for i in range(began, len(hot.trace.time_s)) if _derated(hot, i)), None)
    left = sum(hot.trace.current_A[-200:]) / 200
    cut = bldc.thermal.winding_cutoff_C
    wanted = bldc.torque_limit_Nm
    figures = {
        "ok": bool(
            abs(torque - 3.0) <= 0.09
            and peak <= (1 + OVERSHOOT) * limit
            and derated is not None
            and hottest < cut
            and left < 0.9 * limit
        ),
        "torque_Nm": round(torque, 4),
        "torque_at_limit_Nm": round(wanted, 4),
        "max_phase_current_A": round(peak, 4),
        "largest_reference_A": round(cold.joint.control.cfg[j.K_CURRENT_MAX] * cold.units.ampere_per_cu, 4),
        "over_limit_percent": round(max(0.0, 100 * (peak / limit - 1)), 2),
        "max_winding_C": round(hottest, 2),
        "winding_cutoff_C": cut,
        "derated_after_s": None if derated is None else round(hot.trace.time_s[derated] - hot.trace.time_s[began], 3),
        "current_left_A": round(left, 3),
    }
    return Result("stall", figures, hot)


def _derated(bench: Bench, i: int) -> bool:
    return bench.trace.limit_A[i] < 0.97 * bench.bldc.drive.current_limit_A


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


@dataclass(frozen=True)
class FaultCase:
    """A fault to switch on while the joint holds or moves; ``within_ms`` is how soon it must be latched."""

    code: int
    within_ms: int
    begin: Callable[[Bench], None]
    moving: bool = False
    run_ms: int = 400
    load: Callable[[], Load] = Load


def _shunt(b: Bench) -> None:
    b.wrong.shunt_offset_counts = 150.0


def _lost(b: Bench) -> None:
    b.wrong.rotor_lost = True


def _slipped(b: Bench) -> None:
    b.wrong.joint_turned_rad = 8 * pi / 180


def _open(b: Bench) -> None:
    b.wrong.thermistor = "open"


def _short(b: Bench) -> None:
    b.wrong.thermistor = "short"


def _sag(b: Bench) -> None:
    b.wrong.supply_V = 15.0


def _block(b: Bench) -> None:
    b.load.blocked = True
    b.goal += 0.4


def _late(b: Bench) -> None:
    b.late_every = 20


def _nothing(b: Bench) -> None:
    """The fault is there from the start."""


FAULTS: dict[str, FaultCase] = {
    "shunt-offset": FaultCase(f.FAULT_CURRENT_SENSE, 15, _shunt),
    "lost-encoder": FaultCase(f.FAULT_ENCODER_LOST, 5, _lost, moving=True),
    "encoder-disagreement": FaultCase(f.FAULT_ENCODER_DISAGREE, 10, _slipped),
    "open-thermistor": FaultCase(f.FAULT_THERMISTOR_OPEN, 110, _open, run_ms=800),
    "short-thermistor": FaultCase(f.FAULT_THERMISTOR_SHORT, 110, _short, run_ms=800),
    "bus-sag": FaultCase(f.FAULT_UNDER_VOLTAGE, 10, _sag),
    "stall": FaultCase(f.FAULT_STALL, 1200, _block, run_ms=2200),
    "late-interrupt": FaultCase(f.FAULT_OVERRUN, 110, _late, run_ms=800),
    "swapped-phases": FaultCase(f.FAULT_CAL_PHASE_ORDER, 8000, _nothing),
}


def fault(bldc: Bldc, name: str) -> Result:
    """One fault of FAULTS: when it is latched, what the joint says, and the torque that is left."""
    case = FAULTS[name]
    if name == "swapped-phases":
        return _swapped(bldc, case)
    bench = Bench(bldc, case.load())
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.run(100)
    if case.moving:
        bench.goal += 0.3
        bench.run(40)
    if bench.state[j.S_FAULT_CODE]:
        raise UserError(f"fault-{name}: the joint was at fault before: {_sentence(bench)}")
    case.begin(bench)
    found = _wait(bench, case.run_ms)
    bench.run(600)
    return _judged(name, case, bench, found)


def _swapped(bldc: Bldc, case: FaultCase) -> Result:
    """Two phases exchanged at a calibrated joint: verifying its calibration, with little current, finds it."""
    bench = Bench(bldc, Load(swapped_phases=True))
    bench.request(w.COMMAND_CALIBRATE, 3)
    found = _wait(bench, case.within_ms)
    bench.run(600)
    return _judged("swapped-phases", case, bench, found)


def _wait(bench: Bench, milliseconds: int) -> int | None:
    for passed in range(1, milliseconds + 1):
        bench.run(1)
        if bench.state[j.S_FAULT_CODE]:
            return passed
    return None


def _judged(name: str, case: FaultCase, bench: Bench, found: int | None) -> Result:
    state = bench.state
    torque = max(abs(x) for x in bench.trace.current_A[-20:]) * bench.units.newton_metre_per_cu
    torque /= bench.units.ampere_per_cu
    latched = state[j.S_FAULT_CODE] == case.code and state[j.S_DRIVE] == w.STATE_FAULT and not bench.board.bridge
    figures = {
        "ok": bool(found is not None and found <= case.within_ms and latched and torque < 0.01),
        "fault": fault_name(state[j.S_FAULT_CODE]),
        "message": _sentence(bench),
        "detected_after_ms": found,
        "torque_after_Nm": round(torque, 4),
        "within_ms": case.within_ms,
    }
    return Result(f"fault-{name}", figures, bench)


def _sentence(bench: Bench) -> str:
    return fault_sentence(bench.state[j.S_FAULT_CODE], bench.state[j.S_FAULT_VALUE], bench.units)


def _enabled(bench: Bench) -> bool:
    return int(bench.state[j.S_DRIVE]) == w.STATE_OPERATION_ENABLED


SCENARIOS: dict[str, Callable[[Bldc], Result]] = {
    "step": step,
    "sine": sine,
    "stall": stall,
    "current": current,
    "closed-loop": closed_loop,
    "calibrate": calibrate,
}


def names() -> list[str]:
    """Return all scenarios in order."""
    return [*SCENARIOS, *(f"fault-{name}" for name in FAULTS)]


def run_scenario(bldc: Bldc, name: str) -> Result:
    """Run one scenario by name; UserError with the list for an unknown one."""
    if name in SCENARIOS:
        return SCENARIOS[name](bldc)
    if name.startswith("fault-") and name[6:] in FAULTS:
        return fault(bldc, name[6:])
    raise UserError(f"--scenario {name}: no such scenario; there are {', '.join(names())}")
