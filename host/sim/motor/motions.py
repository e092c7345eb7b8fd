"""Motions of the simulated joint: a position step, the same with a disturbed encoder, a sine."""

from math import cos, degrees, sin, sqrt, tau

from shared.wire import names as w

from ...robot.actuators import Bldc
from .bench import Bench
from .result import Result

STEP_RAD = 0.5
STEP_MS = 1500
SETTLED_DEG = 0.2
GLITCH_SHARE = 0.02  # of the rotor readings: 200 a second
SINE_HZ, SINE_RAD, SINE_MS = 2.0, 0.3, 2500
SINE_SKIP_MS = 500
HUM = 1.5  # times the current that the sine needs: more is gear and velocity loop shaking each other


def step(bldc: Bldc) -> Result:
    """Position step of 0.5 rad with the leg's inertia, under the current limit."""
    return _step("step", Bench(bldc))


def glitches(bldc: Bldc) -> Result:
    """The same step while 2 % of the rotor encoder's readings are any angle: those that cannot be are left out."""
    bench = Bench(bldc)
    bench.wrong.glitch_share = GLITCH_SHARE
    result = _step("glitches", bench)
    result.figures |= {"glitches": bench.sensors.glitches, "rejected": bench.rejected}
    return result


def _step(name: str, bench: Bench) -> Result:
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
    limit = bench.bldc.drive.current_limit_A
    figures = {
        "ok": bool(error <= SETTLED_DEG and overshoot < 5 and peak <= limit and bench.enabled),
        "settling_error_deg": round(error, 4),
        "overshoot_percent": round(overshoot, 3),
        "max_phase_current_A": round(peak, 4),
        "settling_time_s": round((outside[-1] + 1) / 1000, 4) if outside else 0.0,
        "current_limit_A": limit,
        "max_speed_rad_s": round(max(abs(x) for x in bench.trace.speed_rad_s[began:]), 3),
    }
    return Result(name, figures, bench)


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
    current = sqrt(sum(x * x for x in bench.trace.current_A[began:]) / SINE_MS)
    figures = {
        "ok": bool(rms <= 1.0 and current <= HUM * _needed_A(bench) and bench.enabled),
        "tracking_rms_deg": round(rms, 4),
        "tracking_max_deg": round(max(abs(x) for x in errors), 4),
        "max_phase_current_A": round(max(bench.trace.peak_A[began:]), 4),
        "current_rms_A": round(current, 4),
        "needed_rms_A": round(_needed_A(bench), 4),
        "frequency_hz": SINE_HZ,
        "amplitude_rad": SINE_RAD,
    }
    return Result("sine", figures, bench)


def _needed_A(bench: Bench) -> float:
    """Return the rms current that turns the inertia along the sine and overcomes the rotor's friction and the gear."""
    motor, gear = bench.bldc.motor, bench.bldc.gear
    inertia = motor.rotor_inertia_kg_m2 * gear.ratio + bench.load.inertia_kg_m2 / gear.ratio / gear.efficiency
    return (inertia * SINE_RAD * (tau * SINE_HZ) ** 2 / sqrt(2) + motor.coulomb_Nm) / motor.torque_constant_Nm_A
