"""How exact the integer current step is: SVPWM against its closed form, the whole step against the same in floats."""

import random
from math import cos, pi, sin, sqrt, tau
from typing import Any

from shared.joint.commutation import set_commutation
from shared.joint.current import current_repair, current_step
from shared.joint.feed import feed_bus
from shared.joint.svpwm import svpwm

from ..robot.actuators import Bldc
from ..robot.joint_gains import joint_blocks
from ..robot.joint_units import JointSetup

VECTORS = 10_000
SVPWM_MOST = 0.0005  # of the period
STEP_MOST = 0.001


def closed_form(alpha: float, beta: float) -> tuple[float, float, float]:
    """Return the duties of a voltage vector given in shares of the bus, by min-max injection."""
    a, b, c = alpha, -alpha / 2 + sqrt(3) / 2 * beta, -alpha / 2 - sqrt(3) / 2 * beta
    middle = 0.5 - (max(a, b, c) + min(a, b, c)) / 2
    return a + middle, b + middle, c + middle


def accuracy(bldc: Bldc) -> dict[str, Any]:
    """Return the worst errors of SVPWM and of the current step, and whether both are within their bars."""
    svpwm_error, outside = _svpwm_error(bldc, random.Random(0))
    step_error = _step_error(bldc, random.Random(1))
    return {
        "ok": svpwm_error <= SVPWM_MOST and step_error <= STEP_MOST and outside == 0,
        "vectors": VECTORS,
        "svpwm_worst_duty_error": round(svpwm_error, 6),
        "svpwm_duties_outside": outside,
        "step_worst_duty_error": round(step_error, 6),
    }


def _blocks(bldc: Bldc) -> Any:
    """Blocks for comparing: commissioned, at the nominal bus, and without shortest pulses, which floats do not have."""
    blocks = joint_blocks(bldc, JointSetup(-1.0, 1.9))
    set_commutation(blocks.loop, blocks.settings)
    feed_bus(blocks.loop, blocks.settings, round(bldc.drive.bus_voltage_V / blocks.units.volt_per_vu))
    blocks.loop.pulse = 0
    return blocks


def _svpwm_error(bldc: Bldc, draw: random.Random) -> tuple[float, int]:
    blocks = _blocks(bldc)
    loop, period = blocks.loop, blocks.loop.period
    bus = 16 * bldc.drive.bus_voltage_V / blocks.units.volt_per_vu
    worst, outside = 0.0, 0
    for _ in range(VECTORS):
        length, angle = bus / sqrt(3) * sqrt(draw.random()), draw.uniform(0, tau)
        alpha, beta = round(length * cos(angle)), round(length * sin(angle))
        svpwm(loop, alpha, beta)
        for duty, want in zip(loop.duty, closed_form(alpha / bus, beta / bus), strict=True):
            worst = max(worst, abs(duty / period - want))
            outside += not 0 <= duty <= period
    return worst, outside


def _step_error(bldc: Bldc, draw: random.Random) -> float:
    blocks = _blocks(bldc)
    loop, period, worst = blocks.loop, blocks.loop.period, 0.0
    for _ in range(VECTORS):
        rotor = draw.randrange(16384)
        _draw_state(bldc, blocks, draw, rotor)
        want = _reference(bldc, blocks, rotor)
        code = current_step(rotor, 0, loop)
        if code:
            current_repair(code, rotor, 0, loop)
        for found, duty in zip(loop.duty, want, strict=True):
            worst = max(worst, abs(found / period - duty))
    return worst


def _draw_state(bldc: Bldc, blocks: Any, draw: random.Random, rotor: int) -> None:
    """Any rotor angle, phase currents up to 1.2 times the limit, references, integrals and feed-forward."""
    loop, limit = blocks.loop, bldc.drive.current_limit_A
    counts = 1.2 * limit / blocks.units.ampere_per_cu / 6
    angle = draw.uniform(0, tau)
    length = counts * draw.random()
    for phase in range(3):
        loop.raw[phase] = round(2048 + length * cos(angle - phase * tau / 3))
    loop.rotor = rotor
    loop.masked = loop.tripped = loop.reference_d = 0
    loop.reference_q = round(draw.uniform(-1, 1) * limit / blocks.units.ampere_per_cu)
    loop.integral_d = round(draw.uniform(-0.3, 0.3) * loop.voltage_limit * 8192)
    loop.integral_q = round(draw.uniform(-0.3, 0.3) * loop.voltage_limit * 8192)
    loop.feed_d = round(draw.uniform(-0.1, 0.1) * loop.voltage_limit)
    loop.feed_q = round(draw.uniform(-0.6, 0.6) * loop.voltage_limit)


def _reference(bldc: Bldc, blocks: Any, rotor: int) -> tuple[float, float, float]:
    """The same step in floats: Clarke, Park, PI, limit with d first, inverse Park, min-max injection."""
    loop = blocks.loop
    a, b, c = (raw - 2048 for raw in loop.raw)
    alpha, beta = 2.0 * (2 * a - b - c), 2 * sqrt(3) * (b - c)
    angle = bldc.motor.pole_pairs * rotor / 16384 * 2 * pi
    cosine, sine = cos(angle), sin(angle)
    e_d = loop.reference_d - (cosine * alpha + sine * beta)
    e_q = loop.reference_q - (cosine * beta - sine * alpha)
    kp, ki = loop.kp / 8192, loop.ki / 8192
    v_d = e_d * (kp + ki) + loop.integral_d / 8192 + loop.feed_d
    v_q = e_q * (kp + ki) + loop.integral_q / 8192 + loop.feed_q
    bus = bldc.drive.bus_voltage_V / blocks.units.volt_per_vu
    most = bus / sqrt(3)
    v_d = max(-most, min(most, v_d))
    rest = sqrt(most**2 - v_d**2)
    v_q = max(-rest, min(rest, v_q))
    return closed_form((cosine * v_d - sine * v_q) / bus, (cosine * v_q + sine * v_d) / bus)
