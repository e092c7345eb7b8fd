"""A brushless motor with inverter, gear, load and heat: dq equations, one call for half a PWM-update period.

v_d = R i_d + L di_d/dt - w L i_q,  v_q = R i_q + L di_q/dt + w L i_d + w psi,  torque = 3/2 p psi i_q. Rotor and load
are two inertias with the gear's spring, backlash and efficiency between them; winding and housing are two heat nodes.
The PWM ripple is the closed form for centre-aligned PWM: a sample at the centre does not see it, losses and peaks do.
"""

from dataclasses import dataclass
from math import cos, exp, pi, sin, sqrt

from ...robot.actuators import Bldc
from ...robot.joint_heat import COPPER_PER_K

GEAR_DAMPING = 0.05  # share of critical damping of the gear's spring (assumed)


@dataclass
class Load:
    """What the joint carries and what may be wrong or different with this one; SI at the joint."""

    inertia_kg_m2: float = 0.01
    torque_Nm: float = 0.0
    blocked: bool = False  # the joint is held where it is; the rotor still winds the gear's spring up
    locked: bool = False  # the rotor itself is held
    ideal_gear: bool = False  # no losses, no backlash
    swapped_phases: bool = False
    source_ohm: float = 0.1  # battery and wiring (assumed)
    air_C: float = 25.0
    winding_J_K: float | None = None  # None: the robot file's
    housing_J_K: float | None = None
    housing_to_air_K_W: float | None = None
    dead_time_s: float = 100e-9
    saliency: float = 1.0  # inductance across the flux over that along it
    open_phase: int = -1  # 0 .. 2: that phase's wire is off
    cogging_Nm: float = 0.0  # amplitude at the rotor
    cogging_waves: int = 0  # a turn
    viscous_Nms_rad: float = 0.0  # at the rotor
    friction_Nm: float = 0.0  # dry, of the joint behind the gear
    stop_rad: float | None = None  # of the joint: it goes no further


class Motor:
    """State and equations. ``advance`` is called with the phases' duties, ``bridge`` False opens all switches."""

    def __init__(self, bldc: Bldc, load: Load, rotor_rad: float = 0.3, elec_offset_rad: float = 0.0) -> None:
        m, g, t = bldc.motor, bldc.gear, bldc.thermal
        self.load = load
        self.pole_pairs, self.r25_ohm, self.l_H = m.pole_pairs, m.resistance_ohm, m.inductance_H
        self.lq_H = load.saliency * m.inductance_H
        self.psi_Vs = m.torque_constant_Nm_A / 1.5 / m.pole_pairs
        self.rotor_kg_m2, self.coulomb_Nm = m.rotor_inertia_kg_m2, m.coulomb_Nm
        self.gear, self.efficiency = g.ratio, 1.0 if load.ideal_gear else g.efficiency
        self.slack_rad = 0.0 if load.ideal_gear else g.backlash_deg * pi / 360
        self.spring_Nm_rad = g.stiffness_Nm_rad
        reflected = m.rotor_inertia_kg_m2 * g.ratio**2
        reduced = reflected * load.inertia_kg_m2 / (reflected + load.inertia_kg_m2)
        self.damping_Nms_rad = 2 * GEAR_DAMPING * sqrt(g.stiffness_Nm_rad * reduced)
        self.supply_V = bldc.drive.bus_voltage_V
        self.bus_V = self.supply_V
        self.dead_share = load.dead_time_s * bldc.drive.pwm_hz
        self.ripple_s = 1 / (4 * m.inductance_H * bldc.drive.pwm_hz)
        self.winding_J_K = load.winding_J_K or t.winding_J_K
        self.housing_J_K = load.housing_J_K or t.housing_J_K
        self.to_housing_K_W = t.winding_to_housing_K_W
        self.to_air_K_W = load.housing_to_air_K_W or t.housing_to_air_K_W
        self.rotor_rad, self.rotor_rad_s = rotor_rad, 0.0
        self.joint_rad, self.joint_rad_s = rotor_rad / g.ratio, 0.0
        self.elec_offset_rad = elec_offset_rad
        self.i_d = self.i_q = 0.0
        self.phases_A = (0.0, 0.0, 0.0)  # at the board's three terminals, without ripple
        self.winding_C = self.housing_C = load.air_C
        self.heat_J = 0.0  # since the last warm()
        self.gear_Nm = 0.0  # at the joint
        self.ripple_A = 0.0  # peak to peak
        self._decay_key = (0.0, 0.0)
        self._decay = self._decay_q = 0.0

    def _phases_A(self) -> tuple[float, float, float]:
        e = self.pole_pairs * self.rotor_rad + self.elec_offset_rad
        c, s = cos(e), sin(e)
        alpha = self.i_d * c - self.i_q * s
        half = 0.8660254037844386 * (self.i_d * s + self.i_q * c)
        b, c = half - alpha / 2, -half - alpha / 2
        return (alpha, c, b) if self.load.swapped_phases else (alpha, b, c)

    def resistance_ohm(self) -> float:
        """Return the phase resistance at the winding's temperature."""
        return self.r25_ohm * (1 + COPPER_PER_K * (self.winding_C - 25))

    def advance(self, seconds: float, bridge: bool, a: float, b: float, c: float) -> None:
        """Go ``seconds`` on with the phases' shares of the bus voltage, each 0 .. 1."""
        if bridge:
            self._electrical(seconds, a, b, c)
        else:
            self.i_d = self.i_q = self.ripple_A = 0.0
            self.bus_V = self.supply_V
        self._mechanical(seconds)
        self.phases_A = self._phases_A() if bridge else (0.0, 0.0, 0.0)

    def _electrical(self, seconds: float, a: float, b: float, c: float) -> None:
        """Exact decay of the windings, axes coupled through last values; dead time against each phase's current."""
        bus, dead = self.bus_V, self.dead_share
        i_a, i_b, i_c = self.phases_A
        highest, lowest = max(a, b, c), min(a, b, c)
        a -= dead * (1.0 if i_a > 0.05 else -1.0 if i_a < -0.05 else i_a * 20)
        b -= dead * (1.0 if i_b > 0.05 else -1.0 if i_b < -0.05 else i_b * 20)
        c -= dead * (1.0 if i_c > 0.05 else -1.0 if i_c < -0.05 else i_c * 20)
        if self.load.swapped_phases:
            b, c = c, b
        alpha, beta = (2 * a - b - c) * bus / 3, (b - c) * bus * 0.5773502691896258
        w = self.pole_pairs * self.rotor_rad_s
        e = self.pole_pairs * self.rotor_rad + self.elec_offset_rad + w * seconds / 2
        cos_e, sin_e = cos(e), sin(e)
        v_d, v_q = alpha * cos_e + beta * sin_e, beta * cos_e - alpha * sin_e
        r, inductance = self.resistance_ohm(), self.l_H
        key = (seconds, r)
        if key != self._decay_key:
            self._decay_key, self._decay = key, exp(-r * seconds / inductance)
            self._decay_q = exp(-r * seconds / self.lq_H)
        decay, decay_q, i_d, i_q = self._decay, self._decay_q, self.i_d, self.i_q
        self.i_d = i_d * decay + (1 - decay) * (v_d + w * self.lq_H * i_q) / r
        self.i_q = i_q * decay_q + (1 - decay_q) * (v_q - w * inductance * i_d - w * self.psi_Vs) / r
        if self.load.open_phase >= 0:
            self._open(self.load.open_phase)
        span = highest - lowest
        self.ripple_A = bus * span * (1 - span) * 4 * self.ripple_s
        square = i_d * i_d + i_q * i_q + self.ripple_A**2 / 12
        self.heat_J += 1.5 * r * square * seconds
        power = 1.5 * (v_d * i_d + v_q * i_q)
        self.bus_V = self.supply_V - self.load.source_ohm * power / bus

    def _open(self, phase: int) -> None:
        """Remove the current that would flow in an open phase; the rest flows through the other two."""
        e = self.pole_pairs * self.rotor_rad + self.elec_offset_rad - 2 * pi * phase / 3
        c, s = cos(e), sin(e)
        flows = self.i_d * c - self.i_q * s
        self.i_d -= flows * c
        self.i_q += flows * s

    def _mechanical(self, seconds: float) -> None:
        """Rotor and load with the gear between; the gear's losses take from whichever side drives."""
        load, gear = self.load, self.gear
        if load.locked:
            self.rotor_rad_s = self.joint_rad_s = 0.0
            return
        twist = self.rotor_rad / gear - self.joint_rad
        if twist > self.slack_rad:
            touching = twist - self.slack_rad
        elif twist < -self.slack_rad:
            touching = twist + self.slack_rad
        else:
            touching = 0.0
        speed = self.rotor_rad_s / gear
        carried = 0.0
        if touching:
            carried = self.spring_Nm_rad * touching + self.damping_Nms_rad * (speed - self.joint_rad_s)
        on_rotor, on_joint = carried / gear, carried
        if carried * speed >= 0:
            on_joint *= self.efficiency
        else:
            on_rotor *= self.efficiency
        flux_Vs = self.psi_Vs + (self.l_H - self.lq_H) * self.i_d
        drive = 1.5 * self.pole_pairs * flux_Vs * self.i_q - on_rotor - load.viscous_Nms_rad * self.rotor_rad_s
        if load.cogging_waves:
            drive -= load.cogging_Nm * sin(load.cogging_waves * self.rotor_rad)
        friction = self.coulomb_Nm
        if load.ideal_gear:
            friction = 0.0
        if abs(self.rotor_rad_s) < 0.02 and abs(drive) < friction:
            self.rotor_rad_s = 0.0
        else:
            turning = self.rotor_rad_s or drive
            step = seconds * (drive - (friction if turning > 0 else -friction)) / self.rotor_kg_m2
            self.rotor_rad_s += step
        self.rotor_rad += seconds * self.rotor_rad_s
        self.gear_Nm = on_joint
        if load.blocked:
            self.joint_rad_s = 0.0
        else:
            self._move_joint(seconds, on_joint + load.torque_Nm)

    def _move_joint(self, seconds: float, torque_Nm: float) -> None:
        """The joint moves on under ``torque_Nm``; its dry friction brings it to rest within a step, or only brakes."""
        load = self.load
        pushed = self.joint_rad_s + seconds * torque_Nm / load.inertia_kg_m2
        braked = seconds * load.friction_Nm / load.inertia_kg_m2
        self.joint_rad_s = pushed - min(braked, max(-braked, pushed))
        self.joint_rad += seconds * self.joint_rad_s
        if load.stop_rad is not None and self.joint_rad > load.stop_rad:
            self.joint_rad, self.joint_rad_s = load.stop_rad, 0.0

    def warm(self, seconds: float) -> None:
        """Bring the heat of the last ``seconds`` into the winding, and on to housing and air."""
        flow = (self.winding_C - self.housing_C) / self.to_housing_K_W * seconds
        self.winding_C += (self.heat_J - flow) / self.winding_J_K
        away = (self.housing_C - self.load.air_C) / self.to_air_K_W * seconds
        self.housing_C += (flow - away) / self.housing_J_K
        self.heat_J = 0.0
