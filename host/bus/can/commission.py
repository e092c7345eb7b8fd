"""Commissioning over the bus: starts, follows and stops it, and reads a joint's results in SI."""

from collections.abc import Callable
from dataclasses import dataclass
from math import degrees, hypot, tau

from shared.joint.commission_state import COMMISSION_FULL, COMMISSION_VERIFY
from shared.wire import names as w

from ...robot.actuators import Bldc
from ...robot.joint_heat import COPPER_PER_K
from ...robot.joint_units import MOTION_HZ, RATE_PER_RAD_S, Board, choose_units
from ...util.errors import NOT_ACHIEVED, UserError
from .joints import CanJoints
from .params import find_all, read

LONGEST_S = 90.0  # a commissioning ends by itself before this
LOOK_S = 0.1
NAMES = (
    "pole_pairs", "direction", "bemf", "current_kp", "current_ki", "resistance", "inductance_d", "inductance_q",
    "friction_lag", "coulomb", "viscous", "backlash", "inertia", "velocity_p",
    "bend_cos1", "bend_sin1", "bend_cos2", "bend_sin2", "velocity_w_found",
    "cogging_current_0", "cogging_current_1", "cogging_current_2",
)  # fmt: skip


@dataclass(frozen=True)
class Found:
    """One joint's findings about its motor."""

    node: int
    pole_pairs: int
    direction: int
    resistance_ohm: float  # at 25 degrees C
    inductance_d_H: float
    inductance_q_H: float
    torque_constant_Nm_A: float
    eccentricity_deg: float  # of the rotor encoder, amplitude at the rotor
    friction_lag_deg: float  # electrical, at the commissioning current
    inertia_kg_m2: float  # at the rotor, with everything that it turns
    coulomb_Nm: float  # at the rotor
    viscous_Nms_rad: float  # at the rotor
    backlash_deg: float | None  # at the joint; None without a joint encoder
    cogging_Nm: float  # at the rotor, amplitude of the strongest wave
    velocity_bandwidth_hz: float  # set for the velocity loop
    current_kp: int
    current_ki: int
    velocity_p: int

    @property
    def inductance_H(self) -> float:
        """The mean of both axes, from which the current loop's gain follows."""
        return (self.inductance_d_H + self.inductance_q_H) / 2


def run(bus: CanJoints, node: int, verify: bool, show: Callable[[float], None]) -> None:
    """Commission a joint, or verify it; ``show`` gets the elapsed seconds. UserError with the joint's reason.

    If this ends before the joint is done, for whatever reason, it disarms the joint.
    """
    view = bus.link.views[node]
    kind = COMMISSION_VERIFY if verify else COMMISSION_FULL
    bus.requests.challenged(node, w.COMMAND_COMMISSION, kind, low=0)
    began_s = bus.now()
    try:
        bus.run_for(0.5)
        while view.heartbeat.mode == w.MODE_COMMISSIONING and bus.now() < began_s + LONGEST_S:
            bus.run_for(LOOK_S)
            show(bus.now() - began_s)
    finally:
        if view.heartbeat.mode == w.MODE_COMMISSIONING:
            bus.torque(False)
    if view.heartbeat.fault:
        bus.run_for(1.1)  # the joint's fault record comes within a second
        raise UserError(f"node {node}: {bus.cycle.guard.fault_text(view)}", NOT_ACHIEVED)
    if bus.now() >= began_s + LONGEST_S:
        raise UserError(f"node {node}: not done after {LONGEST_S:.0f} s; disarmed it; look at its fault", NOT_ACHIEVED)


def found(bus: CanJoints, node: int, bldc: Bldc) -> Found:
    """Read a joint's findings."""
    raw = {p.name: read(bus.requests, node, p) for p in find_all(NAMES)}
    units, hz = choose_units(bldc, Board()), bldc.drive.current_loop_hz
    ohm = units.volt_per_vu / units.ampere_per_cu
    Nm_A = 1.5 * raw["bemf"] / 65536 / 8 * RATE_PER_RAD_S * units.volt_per_vu
    Nm = Nm_A * units.ampere_per_cu
    winding_C = bus.link.views[node].status.winding_temperature / 16
    bends = [raw[f"bend_{wave}"] / 16 * 360 / 16384 for wave in ("cos1", "sin1", "cos2", "sin2")]
    return Found(
        node, raw["pole_pairs"], raw["direction"],
        resistance_ohm=raw["resistance"] / 65536 * ohm / (1 + COPPER_PER_K * (winding_C - 25)),
        inductance_d_H=raw["inductance_d"] / 65536 * ohm / hz,
        inductance_q_H=raw["inductance_q"] / 65536 * ohm / hz,
        torque_constant_Nm_A=Nm_A,
        eccentricity_deg=hypot(*bends[:2]) + hypot(*bends[2:]),
        friction_lag_deg=raw["friction_lag"] * 360 / 65536,
        inertia_kg_m2=raw["inertia"] / 256 * Nm * RATE_PER_RAD_S / MOTION_HZ,
        coulomb_Nm=raw["coulomb"] / 16 * Nm, viscous_Nms_rad=raw["viscous"] / 65536 * Nm * RATE_PER_RAD_S,
        backlash_deg=degrees(raw["backlash"] / 16 * units.rad_per_rc) if raw["backlash"] >= 0 else None,
        cogging_Nm=max(raw[f"cogging_current_{wave}"] for wave in range(3)) / 16 * Nm,
        velocity_bandwidth_hz=raw["velocity_w_found"] / 65536 * MOTION_HZ / tau,
        current_kp=raw["current_kp"], current_ki=raw["current_ki"], velocity_p=raw["velocity_p"],
    )  # fmt: skip
