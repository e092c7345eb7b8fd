"""The honest law of a servo: late goals, coarse duty, a sagging supply, friction that depends on load, and play.

A simulator calls, once per sub-step and joint, in motor angles:

    law.step(goal_rad, most, position_rad, speed_rad_s, load_Nm, dt_s)

and then gives the link ``law.torque_Nm``, and brakes it with at most ``law.friction_Nm``. A zero leaves its part
out; with all of them zero it is torque = stall x clip(duty) - stall / no-load speed x speed, and
``coulomb_Nm`` of friction.

Friction is the M6 model of Duclusaud et al., "Extended Friction Models for the Physics Simulation of Servo Actuators",
ICRA 2025 (arXiv 2410.08650), equation of M6. The stall torque of a data sheet is measured at the shaft, after friction
has taken its share, so the motor gives more (``motor_stall_Nm``).

With play the rotor turns by itself between the flanks of its gears: this module steps it with its friction, and
the link gets the force of a flank. Then ``link_armature_kg_m2`` is 0, else the link carries the rotor's inertia.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from math import copysign, exp, inf, radians, sqrt

from ...robot.actuators import Bldc, Friction, PdJoint, Servo

DRY = Friction()
FLANK_NM_RAD = 300.0  # stiffness of gear flanks: 2.5 N m wind them up by half a degree (assumed)
FLANK_DAMPING = 0.5  # of critical (assumed)
LEAST_PLAY_RAD = 3e-4  # an arc minute: in the walking simulators a link between closer flanks never comes to rest


@dataclass(frozen=True)
class Figures:
    """The figures of a law at the servo's shaft, for one supply voltage. ``delay_s`` is for one direction."""

    stall_Nm: float
    no_load_rad_s: float
    duty_per_rad: float
    coulomb_Nm: float
    armature_kg_m2: float
    voltage_V: float = 12.0
    friction: Friction = DRY
    backlash_rad: float = 0.0
    pwm_steps: int = 0
    counts_per_rad: float = 0.0
    stall_A: float = 0.0
    delay_s: float = 0.0

    @property
    def motor_stall_Nm(self) -> float:
        """The motor's own stall torque: after the friction of its load, the data sheet's torque remains."""
        return self.stall_Nm / (1.0 - self.friction.load_motor - self.friction.load_motor_stribeck)

    @property
    def braking_Nms_rad(self) -> float:
        """How its own voltage brakes the motor."""
        return self.motor_stall_Nm / self.no_load_rad_s


def figures_of(servo: Servo, delay_s: float = 0.0) -> Figures:
    """Return the figures of a robot file's servo at its nominal voltage; the delay is up to the caller."""
    nominal = servo.nominal
    return Figures(
        stall_Nm=nominal.stall_Nm,
        no_load_rad_s=nominal.no_load_rad_s,
        duty_per_rad=servo.duty_per_rad,
        coulomb_Nm=servo.coulomb_Nm,
        armature_kg_m2=servo.armature_kg_m2,
        voltage_V=nominal.voltage_V,
        friction=servo.friction,
        backlash_rad=radians(servo.backlash_deg),
        pwm_steps=servo.pwm_steps,
        counts_per_rad=1.0 / servo.step_rad,
        stall_A=servo.stall_A,
        delay_s=delay_s,
    )


def honest_figures(actuator: Servo | Bldc | PdJoint) -> Figures | None:
    """Return a drive's data beyond its linear law for the walking simulators; None if the robot file has none.

    For a brushless joint this is its gear: its play, and its loss as friction that grows with the motor's torque.
    """
    if isinstance(actuator, PdJoint):
        return None
    if isinstance(actuator, Servo):
        return figures_of(actuator) if actuator.backlash_deg > 0 or actuator.friction != DRY else None
    motor, gear = actuator.motor, actuator.gear
    return Figures(
        stall_Nm=actuator.torque_limit_Nm * gear.efficiency,
        no_load_rad_s=inf,
        duty_per_rad=0.0,
        coulomb_Nm=motor.coulomb_Nm * gear.ratio,
        armature_kg_m2=motor.rotor_inertia_kg_m2 * gear.ratio**2,
        voltage_V=actuator.supply_V,
        friction=Friction(load_motor=1.0 - gear.efficiency),
        backlash_rad=radians(gear.backlash_deg),
    )


class Battery:
    """A supply with a resistance: its voltage falls with the current that all servos drew in the last sub-step."""

    def __init__(self, voltage_V: float, resistance_ohm: float) -> None:
        self.open_V, self.resistance_ohm = voltage_V, resistance_ohm
        self.voltage_V = voltage_V
        self._drawn_A = 0.0

    def draw(self, current_A: float) -> None:
        """Add a servo's current; what a braking servo gives back does not raise the voltage."""
        self._drawn_A += current_A

    def settle(self) -> None:
        """End a sub-step: from now on the current reduces the voltage."""
        self.voltage_V = max(0.0, self.open_V - self.resistance_ohm * max(0.0, self._drawn_A))
        self._drawn_A = 0.0


def friction_law(figures: Figures) -> Callable[[float, float, float], float]:
    """Return M6: the largest friction torque for a motor torque, a load torque (on the shaft) and a speed.

    Dry friction, more of it at rest (Stribeck), a share of what the gears pass on, and viscous friction. A function
    made once for each servo: it is called some ten thousand times per simulated second.
    """
    f, coulomb_Nm = figures.friction, figures.coulomb_Nm
    load_share, motor_share, viscous_Nms_rad = f.load_external, f.load_motor, f.viscous_Nms_rad
    load_at_rest, motor_at_rest, stribeck_Nm = f.load_external_stribeck, f.load_motor_stribeck, f.stribeck_Nm
    load_square, motor_square = f.load_external_square_1_Nm, f.load_motor_square_1_Nm
    stribeck_rad_s, exponent, e_to = f.stribeck_rad_s, f.stribeck_exponent, exp

    def most_Nm(motor_Nm: float, load_Nm: float, speed_rad_s: float) -> float:
        fast_rad_s = abs(speed_rad_s)
        at_rest_Nm = abs(load_at_rest * load_Nm - motor_at_rest * motor_Nm) + stribeck_Nm
        if load_Nm * motor_Nm < 0:
            if abs(load_Nm) < abs(motor_Nm):
                at_rest_Nm += load_square * load_Nm * load_Nm
            elif abs(load_Nm) > abs(motor_Nm):
                at_rest_Nm += motor_square * motor_Nm * motor_Nm
        fades = e_to(-((fast_rad_s / stribeck_rad_s) ** exponent))
        passed_Nm = coulomb_Nm + abs(load_share * load_Nm - motor_share * motor_Nm)
        return passed_Nm + fades * at_rest_Nm + viscous_Nms_rad * fast_rad_s

    return most_Nm


def stopped_Nm(inertia_kg_m2: float, speed_rad_s: float, driving_Nm: float, most_Nm: float, dt_s: float) -> float:
    """Return the friction torque of a sub-step: it brings to rest, with at most ``most_Nm``."""
    wanted = -(inertia_kg_m2 * speed_rad_s / dt_s + driving_Nm)
    return max(-most_Nm, min(most_Nm, wanted))


class ServoLaw:
    """One servo; ``link_kg_m2`` is the inertia that it turns (of the link alone), for the flanks' sake only."""

    def __init__(
        self, figures: Figures, position_rad: float, link_kg_m2: float, battery: Battery | None = None
    ) -> None:
        self.battery = battery or Battery(figures.voltage_V, 0.0)
        self.become(figures)
        self.torque_Nm = self.friction_Nm = self.motor_Nm = self.duty = 0.0
        self.rotor_rad, self.rotor_rad_s = position_rad, 0.0
        self.link_armature_kg_m2 = 0.0 if figures.backlash_rad > 0 else figures.armature_kg_m2
        self._link_kg_m2 = link_kg_m2
        self._goal_rad, self._late = position_rad, deque[tuple[float, float, float | None]]()
        self._most: float | None = None
        self._told: tuple[float, float | None] = (position_rad, None)
        self._time_s = 0.0

    def become(self, figures: Figures) -> None:
        """Be a servo of other figures from now on."""
        self.figures, self._most_Nm = figures, friction_law(figures)

    def step(
        self, goal_rad: float, most: float | None, position_rad: float, speed_rad_s: float, load_Nm: float, dt_s: float
    ) -> None:
        """Advance by a sub-step from where the link is: ``most`` is the duty's limit 0 .. 1, None without torque.

        ``load_Nm`` is the torque of gravity, ground and the like on the link; it only matters without play.
        """
        self._time_s += dt_s
        self._hear(goal_rad, most)
        self.duty = self._wanted_duty(position_rad)
        if self.figures.backlash_rad > 0:
            self._step_rotor(position_rad, speed_rad_s, dt_s)
            return
        self.rotor_rad, self.rotor_rad_s = position_rad, speed_rad_s
        self.torque_Nm = self.motor_Nm = self._drive_Nm(speed_rad_s)
        self.friction_Nm = self._most_Nm(self.torque_Nm, load_Nm, speed_rad_s)

    def _hear(self, goal_rad: float, most: float | None) -> None:
        """Take the commands whose delay is over."""
        if self.figures.delay_s <= 0:
            self._goal_rad, self._most = goal_rad, most
            return
        if (goal_rad, most) != self._told:
            self._told = goal_rad, most
            self._late.append((self._time_s + self.figures.delay_s, goal_rad, most))
        while self._late and self._late[0][0] <= self._time_s + 1e-9:
            _, self._goal_rad, self._most = self._late.popleft()

    def _wanted_duty(self, position_rad: float) -> float:
        """Return the duty of the servo's P law, in its steps of position and of duty."""
        if self._most is None:
            return 0.0
        f = self.figures
        seen_rad = round(position_rad * f.counts_per_rad) / f.counts_per_rad if f.counts_per_rad else position_rad
        duty = max(-self._most, min(self._most, f.duty_per_rad * (self._goal_rad - seen_rad)))
        return round(duty * f.pwm_steps) / f.pwm_steps if f.pwm_steps else duty

    def _drive_Nm(self, speed_rad_s: float) -> float:
        """Return the motor's torque, and take its current from the battery; without torque its bridge is open."""
        if self._most is None:
            return 0.0
        f, battery = self.figures, self.battery
        share = self.duty * battery.voltage_V / f.voltage_V - speed_rad_s / f.no_load_rad_s
        battery.draw(self.duty * share * f.stall_A)
        return f.motor_stall_Nm * share

    def _step_rotor(self, link_rad: float, link_rad_s: float, dt_s: float) -> None:
        """Advance the rotor between its flanks."""
        f = self.figures
        self.motor_Nm = motor_Nm = self._drive_Nm(self.rotor_rad_s)
        flank_Nm = self._flank_Nm(self.rotor_rad - link_rad, self.rotor_rad_s - link_rad_s, dt_s)
        driving_Nm = motor_Nm - flank_Nm
        most_Nm = self._most_Nm(motor_Nm, -flank_Nm, self.rotor_rad_s)
        driving_Nm += stopped_Nm(f.armature_kg_m2, self.rotor_rad_s, driving_Nm, most_Nm, dt_s)
        self.rotor_rad_s += driving_Nm / f.armature_kg_m2 * dt_s
        self.rotor_rad += self.rotor_rad_s * dt_s
        self.torque_Nm, self.friction_Nm = flank_Nm, 0.0

    def _flank_Nm(self, apart_rad: float, apart_rad_s: float, dt_s: float) -> float:
        """Return a flank's torque: a stiff spring that only pushes, stepped implicitly to stay stable."""
        deep_rad = abs(apart_rad) - self.figures.backlash_rad / 2
        if deep_rad <= 0:
            return 0.0
        rotor, link = self.figures.armature_kg_m2, self._link_kg_m2
        damping = 2 * FLANK_DAMPING * sqrt(FLANK_NM_RAD * rotor * link / (rotor + link))
        into_rad_s = copysign(apart_rad_s, apart_rad * apart_rad_s)
        softer = 1.0 + (dt_s * damping + dt_s**2 * FLANK_NM_RAD) * (1 / rotor + 1 / link)
        push = (FLANK_NM_RAD * (deep_rad + dt_s * into_rad_s) + damping * into_rad_s) / softer
        return copysign(max(0.0, push), apart_rad)


class Stood:
    """A link on its servo, held by nothing else, for the law's trust tests and the stand."""

    def __init__(self, law: ServoLaw, inertia_kg_m2: float, position_rad: float) -> None:
        self.law, self.inertia_kg_m2 = law, inertia_kg_m2
        self.position_rad, self.speed_rad_s = position_rad, 0.0

    def step(self, goal_rad: float, most: float | None, load_Nm: float, dt_s: float) -> None:
        """Advance by a sub-step under a load."""
        law = self.law
        law.step(goal_rad, most, self.position_rad, self.speed_rad_s, load_Nm, dt_s)
        inertia = self.inertia_kg_m2 + law.link_armature_kg_m2
        driving_Nm = law.torque_Nm + load_Nm
        driving_Nm += stopped_Nm(inertia, self.speed_rad_s, driving_Nm, law.friction_Nm, dt_s)
        self.speed_rad_s += driving_Nm / inertia * dt_s
        self.position_rad += self.speed_rad_s * dt_s
