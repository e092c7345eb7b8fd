"""Motors drawn at random for commissioning, each with a robot file that only knows its supply and its limits."""

import random
from dataclasses import dataclass
from math import degrees, pi, radians, sin, sqrt, tau

from host.robot.actuators import Bldc
from host.robot.file import load_robot
from host.robot.joint_faults import fault_sentence
from host.robot.joint_units import MOTION_HZ, RATE_PER_RAD_S, JointSetup
from host.sim.motor.bench import Bench
from host.sim.motor.model import Load
from shared.joint.bend import corrected_rotor
from shared.joint.commission_state import COMMISSION_FULL
from shared.joint.layout import WAVES
from shared.wire import names as w

PARALLEL = load_robot("parallel").actuator
LONGEST_S = 60.0
STAND_MS = 500  # until the rotor has found its place between the cogging's teeth


def between(rng: random.Random, low: float, high: float) -> float:
    """Return a number as likely in each octave."""
    return low * (high / low) ** rng.random()


@dataclass
class Drawn:
    """A motor and what is wrong with its mounting."""

    file: Bldc
    real: Bldc
    load: Load
    offset_rad: float
    eccentric_rad: float
    eccentric_at_rad: float
    seed: int

    def play_deg(self) -> float:
        """Return the gear's play and what friction at the joint winds its spring up by on both ways."""
        return self.real.gear.backlash_deg + degrees(2 * self.load.friction_Nm / self.real.gear.stiffness_Nm_rad)

    def bench(self) -> Bench:
        """Return it on the bench, not commissioned."""
        setup = JointSetup(-1.0, 1.9, inertia_kg_m2=self.file.motor.rotor_inertia_kg_m2 * self.file.gear.ratio**2)
        bench = Bench(self.file, self.load, setup, False, self.offset_rad, self.seed, self.real)
        bench.wrong.eccentric_rad, bench.wrong.eccentric_at_rad = self.eccentric_rad, self.eccentric_at_rad
        return bench


def draw(seed: int) -> Drawn:
    """Draw one, L / R 0.2 .. 2 ms, with a current limit that heats it with 12 .. 30 W; its file knows little of it."""
    rng = random.Random(seed)
    ohm = between(rng, 0.05, 3.0)
    henry = min(2e-3, max(20e-6, ohm * between(rng, 0.2e-3, 2e-3)))
    current_A = sqrt(rng.uniform(12, 30) / 1.5 / ohm)
    pairs = rng.randint(7, 21)
    emf_Vs = between(rng, 0.02, 0.06)  # per rad/s of the rotor, on the q axis
    rated_Nm = 1.5 * emf_Vs * current_A
    gear = rng.uniform(6, 22)
    rotor_kg_m2 = rated_Nm / between(rng, 8e3, 4e4)
    gain = next(g for g in (40.0, 20.0, 10.0, 5.0) if 1.65 / (g * 0.6 * 0.0005) > current_A)
    motor = {
        "pole_pairs": pairs, "resistance_ohm": ohm, "inductance_H": henry, "torque_constant_Nm_A": 1.5 * emf_Vs,
        "rotor_inertia_kg_m2": rotor_kg_m2, "coulomb_Nm": rated_Nm * rng.uniform(0.005, 0.05),
    }  # fmt: skip
    shunt_ohm = 1.65 / (gain * current_A / 0.55)
    drive = {"current_limit_A": current_A, "shunt_ohm": shunt_ohm, "amplifier_gain": gain, "speed_limit_rad_s": 8.0}
    real = replaced(PARALLEL, motor, {"ratio": gear}, drive)
    nominal = {
        "pole_pairs": 7, "resistance_ohm": 0.4, "inductance_H": 2.5e-4,
        "torque_constant_Nm_A": 1.5 * 0.035, "rotor_inertia_kg_m2": rotor_kg_m2,
    }  # fmt: skip
    load = Load(
        inertia_kg_m2=rotor_kg_m2 * gear**2 * rng.uniform(0.2, 2.0),
        swapped_phases=rng.random() < 0.5,
        dead_time_s=rng.uniform(50e-9, 300e-9),
        saliency=rng.uniform(0.9, 1.5),
        cogging_Nm=rated_Nm * rng.uniform(0.0, 0.08),
        cogging_waves=6 * pairs,
        source_ohm=0.02,
        viscous_Nms_rad=rated_Nm * rng.uniform(0.0, 0.03) / (8.0 * gear),
        friction_Nm=rated_Nm * gear * rng.uniform(0.003, 0.02),
        torque_Nm=rated_Nm * gear * rng.uniform(-0.003, 0.003),  # less than that holds
    )
    guess = between(rng, 0.5, 2.0)  # what the file says of the inertia
    return Drawn(
        replaced(real, {**nominal, "rotor_inertia_kg_m2": rotor_kg_m2 * guess}, {}, {}), real, load,
        rng.uniform(0, tau), radians(rng.uniform(0.5, 2.0)),
        rng.uniform(0, tau), seed,
    )  # fmt: skip


def replaced(bldc: Bldc, motor: dict, gear: dict, drive: dict) -> Bldc:
    """Return an actuator with other values."""
    return bldc.model_copy(update={
        "motor": bldc.motor.model_copy(update=motor), "gear": bldc.gear.model_copy(update=gear),
        "drive": bldc.drive.model_copy(update=drive),
    })  # fmt: skip


def commissioned(bench: Bench, kind: int = COMMISSION_FULL) -> str:
    """Commission until it is over; return the fault's sentence, "" if all went well."""
    if not bench.motor.rotor_rad_s:
        bench.run(STAND_MS)
    began_s, result = bench.time_s, bench.request(w.COMMAND_COMMISSION, kind)
    if result != w.RESULT_OK and not bench.state.fault_code:
        return f"refused with result {result}"
    while bench.time_s < began_s + LONGEST_S + 0.1:
        bench.run(20)
        if bench.state.drive_state in (w.STATE_SWITCH_ON_DISABLED, w.STATE_FAULT):
            break
    if not bench.state.fault_code:
        return "" if bench.joint.control.settings.commissioned else "not commissioned"
    return fault_sentence(bench.state.fault_code, bench.state.fault_value, bench.units)


def errors(drawn: Drawn, bench: Bench) -> dict[str, float]:
    """Return by how much what was found is off: shares, and degrees of the rotor and of the electrical turn.

    Friction as a share of what the joint has at its current limit, play (Drawn.play_deg) in degrees of the joint. What
    is left of the cogging as a share of it and, as ``cogging_rest``, of the torque at the current limit. The largest
    phase current as a share of the limit.
    """
    c, s, u, m = bench.joint.control.commission, bench.joint.control.settings, bench.units, bench.motor
    ohm = u.volt_per_vu / u.ampere_per_cu / 65536
    pairs = -m.pole_pairs if drawn.load.swapped_phases else m.pole_pairs
    Nm = 1.5 * m.psi_Vs * m.pole_pairs * u.ampere_per_cu
    inertia = m.rotor_kg_m2 + drawn.load.inertia_kg_m2 / m.gear**2
    wanted_hz = drawn.file.drive.velocity_bandwidth_hz * c.velocity_w / s.velocity_w  # less where the gear rattles
    dry_Nm = m.coulomb_Nm + drawn.load.friction_Nm / m.gear
    emf_Vs = s.bemf / 65536 / 8 * 256 * 16384 / tau / 1000 * u.volt_per_vu  # V per rad/s of the rotor
    offset = -drawn.offset_rad if drawn.load.swapped_phases else drawn.offset_rad
    away, limit_A = [], drawn.real.drive.current_limit_A
    for rotor_rad in (k / 64 * tau for k in range(64)):
        taken = pairs * straight_rad(drawn, bench, rotor_rad) + s.elec_offset / 65536 * tau
        away.append((taken - pairs * rotor_rad - offset + pi) % tau - pi)
    mean = sum(away) / 64
    left, share = cogging_left(drawn, bench), drawn.load.cogging_Nm / (1.5 * m.psi_Vs * m.pole_pairs * limit_A)
    return {
        "pole_pairs": s.pole_pairs - m.pole_pairs,
        "resistance": c.resistance * ohm / m.resistance_ohm() - 1,
        "inductance_d": c.inductance_d * ohm * 1e-4 / m.l_H - 1,
        "inductance_q": c.inductance_q * ohm * 1e-4 / m.lq_H - 1,
        "flux": emf_Vs / (m.psi_Vs * m.pole_pairs) - 1,
        "offset_elec_deg": degrees(mean),
        "eccentric_deg": max(abs(degrees(a - mean)) for a in away) / m.pole_pairs,
        "inertia": s.inertia / 256 * Nm * RATE_PER_RAD_S / MOTION_HZ / inertia - 1,
        "friction_share": (c.coulomb / 16 * Nm - dry_Nm) / (limit_A / u.ampere_per_cu * Nm),
        "velocity_hz": s.velocity_p / 4096 * Nm * RATE_PER_RAD_S / inertia / tau / wanted_hz - 1,
        "play_deg": degrees(c.backlash / 16 * u.rad_per_rc) - drawn.play_deg(),
        "cogging_left": left,
        "cogging_rest": left * share,
        "current": max(bench.trace.peak_A) / limit_A,
        "seconds": bench.time_s - STAND_MS / 1000,
    }  # fmt: skip


def cogging_left(drawn: Drawn, bench: Bench) -> float:
    """Return what the waves, which go by what the joint reads, leave of the cogging's torque: a share, rms.

    1024 places hold its at most 250 waves a turn: with 4096 the share was the same within 0.0003.
    """
    settings, m, at = bench.joint.control.settings, bench.motor, [k / 1024 * tau for k in range(1024)]
    read = [straight_rad(drawn, bench, rotor_rad) for rotor_rad in at]
    left = [drawn.load.cogging_Nm * sin(drawn.load.cogging_waves * rotor_rad) for rotor_rad in at]
    Nm = 1.5 * m.psi_Vs * m.pole_pairs * bench.units.ampere_per_cu * settings.direction / 16
    for wave in range(WAVES):
        order, current, phase = (getattr(settings, f"cogging_{name}_{wave}") for name in ("order", "current", "phase"))
        for k, read_rad in enumerate(read):
            left[k] -= current * Nm * sin(order * read_rad + phase / 65536 * tau)
    return sqrt(sum(Nm * Nm for Nm in left) / len(left)) / (drawn.load.cogging_Nm / sqrt(2))


def straight_rad(drawn: Drawn, bench: Bench, rotor_rad: float) -> float:
    """Return what the joint takes a rotor angle for."""
    read = rotor_rad + drawn.eccentric_rad * sin(rotor_rad - drawn.eccentric_at_rad)
    loop = bench.joint.control.loop
    return corrected_rotor(loop, int(read / tau * 16384) & 16383) / 16384 * tau
