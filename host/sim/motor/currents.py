"""The current loop of the simulated joint: its step, both axes at speed, and a blocked joint at the limit until hot."""

from math import degrees

from shared.wire import names as w

from ...robot.actuators import Bldc
from ...robot.joint_units import JointSetup
from .bench import STEP_S, Bench
from .model import Load
from .result import Result

CURRENT_A = 1.0
OVERSHOOT = 0.1  # that the current loop is allowed, of a step
SPEED_SHARES = (-0.9, -0.4, -0.05, 0.05, 0.4, 0.9)
LOAD_NM = 1.0
HOT_MS = 25000


def current_locked(bldc: Bldc) -> Result:
    """Step of the current loop with the rotor itself locked: the winding and the loop, nothing else."""
    return _current("current-locked", bldc, Load(locked=True))


def current_held(bldc: Bldc) -> Result:
    """The same step with the joint held: the rotor winds the gear's spring up and swings, its back-EMF disturbs."""
    return _current("current-held", bldc, Load(blocked=True, ideal_gear=True))


def _current(name: str, bldc: Bldc, load: Load) -> Result:
    """Step of the current from rest, checked in every current step; reports how far the rotor turned."""
    bench = Bench(bldc, load)
    bench.arm(w.MODE_CURRENT, 0.0)
    bench.run(100)
    stood = bench.motor.rotor_rad
    bench.goal, bench.fast = CURRENT_A, []
    bench.run(50)
    way = bench.fast
    settled = sum(way[-100:]) / 100
    rise_ms = (_crossing(way, 0.9) - _crossing(way, 0.1)) * 1000 * STEP_S
    overshoot = 100 * (max(way) / CURRENT_A - 1)
    error = 100 * abs(settled / CURRENT_A - 1)
    figures = {
        "ok": bool(rise_ms < 1 and overshoot < 100 * OVERSHOOT and error <= 1),
        "rise_10_90_ms": round(rise_ms, 4),
        "overshoot_percent": round(overshoot, 2),
        "steady_error_percent": round(error, 3),
        "max_phase_current_A": round(max(bench.trace.peak_A), 4),
        "rotor_turned_elec_deg": round(degrees(bench.motor.pole_pairs * (bench.motor.rotor_rad - stood)), 2),
    }
    return Result(name, figures, bench)


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
        "ok": bool(max(worst_d, worst_q) <= rated / 100 and bench.enabled),
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
        q += bench.motor.i_q - bench.joint.control.loop.reference_q * bench.units.ampere_per_cu
    return d / milliseconds, q / milliseconds


def _crossing(way: list[float], share: float) -> float:
    """Return when, in steps, the way to CURRENT_A first passes a share of it."""
    at = next(i for i, current_A in enumerate(way) if current_A >= share * CURRENT_A)
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
        "largest_reference_A": round(cold.joint.control.settings.current_max * cold.units.ampere_per_cu, 4),
        "over_limit_percent": round(max(0.0, 100 * (peak / limit - 1)), 2),
        "max_winding_C": round(hottest, 2),
        "winding_cutoff_C": cut,
        "derated_after_s": None if derated is None else round(hot.trace.time_s[derated] - hot.trace.time_s[began], 3),
        "current_left_A": round(left, 3),
    }
    return Result("stall", figures, hot)


def _derated(bench: Bench, i: int) -> bool:
    return bench.trace.limit_A[i] < 0.97 * bench.bldc.drive.current_limit_A
