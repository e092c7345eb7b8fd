"""What a joint's integers stand for: the data behind them, the units that fit, and what is refused.

Current loop: kp = L w and ki = R w. No bandwidth may exceed a twentieth of its loop's rate, nor the PWM ripple the
current limit; the voltage's unit is the finest for which no product of the current step reaches 2^30.
"""

from dataclasses import dataclass
from math import pi, sqrt

from ..util.errors import UserError
from .actuators import Bldc

MOTION_HZ = 1000  # motion_tick
RATE_PER_RAD_S = 16384 / (2 * pi) / MOTION_HZ * 256  # rate units per rad/s of the rotor
WORD = 1 << 30
AXIS_MOST_VU = 23170  # 2^14.5: the squares of both axes add up to less than 2^30


@dataclass(frozen=True)
class Board:
    """The controller board's own data; assumed where the paper gives none."""

    adc_volt: float = 3.3
    timer_hz: float = 168e6  # STM32F405, TIM1
    bus_divider: float = 13.0  # assumed: 42.9 V full scale
    dead_time_s: float = 100e-9  # DRV8323 default
    duty_delay_steps: float = 1.0  # from the samples to the update event that applies their duties (docs/joint.md)
    rotor_age_steps: float = 1.0  # of the rotor's reading at the samples: an answer comes with the next read
    settling_s: float = 2.5e-6  # shunt amplifier, low side on that long before a sample
    shortest_pulse_s: float = 0.5e-6  # assumed
    thermistor_pull_up_ohm: float = 1000.0  # assumed: to the ADC's supply, thermistor to ground
    mcu_cal1: int = 943  # typical readings at 30 and 110 degrees C; the board puts its own in
    mcu_cal2: int = 1194


@dataclass(frozen=True)
class JointSetup:
    """What differs from joint to joint."""

    lower_rad: float
    upper_rad: float
    inertia_kg_m2: float = 0.01  # leg about the joint (assumed)
    has_joint_encoder: bool = True
    sign: int = 1  # joint angle over rotor count
    stop_rad: float | None = None  # where the mechanical stop is; default: the nearer limit
    stop_towards: int = -1  # direction in which homing searches the stop
    continuous_A: float | None = None  # current that may flow forever; default: the current limit
    peak_s: float = 10.0  # time at the limit until only continuous_A is allowed


@dataclass(frozen=True)
class Units:
    """SI per integer unit of one joint."""

    ampere_per_cu: float
    volt_per_vu: float
    rad_per_rc: float  # of the joint
    rad_s_per_rate: float  # of the joint
    newton_metre_per_cu: float  # at the joint, ideal gear
    gear: float


def check_bandwidths(bldc: Bldc) -> None:
    """Refuse a bandwidth above a twentieth of its loop's rate, or loops that are not nested."""
    d = bldc.drive
    rows = (
        ("current", d.current_bandwidth_hz, d.current_loop_hz),
        ("velocity", d.velocity_bandwidth_hz, MOTION_HZ),
        ("position", d.position_bandwidth_hz, MOTION_HZ),
    )
    for name, bandwidth, rate in rows:
        if bandwidth > rate / 20:
            raise UserError(
                f"actuator.drive.{name}_bandwidth_hz {bandwidth:g}: at most {rate / 20:g}, "
                f"a twentieth of the {name} loop's {rate:g} Hz; lower it"
            )
    if d.position_bandwidth_hz > d.velocity_bandwidth_hz / 2:
        raise UserError(
            f"actuator.drive.position_bandwidth_hz {d.position_bandwidth_hz:g}: at most half of "
            f"velocity_bandwidth_hz {d.velocity_bandwidth_hz:g}; lower it"
        )


def ripple_A(bldc: Bldc) -> float:
    """Return the PWM ripple V / (4 L f), peak to peak at half duty."""
    return bldc.drive.bus_voltage_V / (4 * bldc.motor.inductance_H * bldc.drive.pwm_hz)


def check_ripple(bldc: Bldc) -> None:
    """Refuse a motor whose PWM ripple exceeds the current limit."""
    if ripple_A(bldc) > bldc.drive.current_limit_A:
        raise UserError(
            f"actuator.motor.inductance_H {bldc.motor.inductance_H:g}: the PWM ripple of {ripple_A(bldc):.2g} A "
            f"exceeds current_limit_A {bldc.drive.current_limit_A:g}; raise pwm_hz or add inductance"
        )


def current_gains(bldc: Bldc) -> tuple[float, float]:
    """Return kp = L w in V/A and ki = R w in V/(A s) of the current loop."""
    w = 2 * pi * bldc.drive.current_bandwidth_hz
    return bldc.motor.inductance_H * w, bldc.motor.resistance_ohm * w


def rotor_inertia(bldc: Bldc, setup: JointSetup) -> float:
    """Return the inertia that the motor turns, seen at the rotor, in kg m2."""
    return bldc.motor.rotor_inertia_kg_m2 + setup.inertia_kg_m2 / bldc.gear.ratio**2


def trip_A(bldc: Bldc, board: Board) -> float:
    """Return the current at which the step trips: 2.5 times the limit, or 0.85 of the shunts' range."""
    return min(2.5 * bldc.drive.current_limit_A, 0.85 * full_scale_A(bldc, board))


def choose_units(bldc: Bldc, board: Board) -> Units:
    """Return the joint's units: vu is the finest 2^-k V for which the current step cannot overflow."""
    ampere = full_scale_A(bldc, board) / 2048 / 6
    gear = bldc.gear.ratio
    if not 1 <= gear <= 63.9:
        raise UserError(f"actuator.gear.ratio {gear:g}: allowed 1 .. 63.9, which fit a joint's integers")
    if bldc.drive.current_limit_A > 0.6 * full_scale_A(bldc, board):
        raise UserError(
            f"actuator.drive.current_limit_A {bldc.drive.current_limit_A:g}: at most 60 % of the "
            f"{full_scale_A(bldc, board):.3g} A that shunt_ohm and amplifier_gain can read"
        )
    for shift in range(11, 3, -1):
        if _fits(bldc, board, ampere, 2.0**-shift):
            return Units(
                ampere_per_cu=ampere,
                volt_per_vu=2.0**-shift,
                rad_per_rc=2 * pi / 16384 / gear,
                rad_s_per_rate=1 / RATE_PER_RAD_S / gear,
                newton_metre_per_cu=ampere * bldc.motor.torque_constant_Nm_A * gear,
                gear=gear,
            )
    raise UserError("actuator.drive.current_bandwidth_hz: kp = L w does not fit the integers; lower it")


def step_gains(bldc: Bldc, ampere: float, volt: float) -> tuple[int, int]:
    """Return current_kp and current_ki (Q13) for units of ``ampere`` and ``volt``."""
    kp, ki = current_gains(bldc)
    scale = ampere / volt * 8192
    return round(kp * scale), round(ki / bldc.drive.current_loop_hz * scale)


def _fits(bldc: Bldc, board: Board, ampere: float, volt: float) -> bool:
    """Return whether the sums of current_step stay in range: largest error, integral at its limits, feed-forward."""
    kp, ki = step_gains(bldc, ampere, volt)
    error = (trip_A(bldc, board) + bldc.drive.current_limit_A) / ampere
    longest = bus_most_V(board) / sqrt(3) / volt
    total = (kp + ki) * error + 2 * longest * 8192
    fine = bldc.drive.bus_voltage_V / volt >= 2500  # so that a duty is no coarser than the timer makes it
    return fine and total < WORD and total / 8192 + longest < AXIS_MOST_VU and kp > 64 and ki > 8


def full_scale_A(bldc: Bldc, board: Board) -> float:
    """Current at half of the ADC's range."""
    return board.adc_volt / 2 / (bldc.drive.shunt_ohm * bldc.drive.amplifier_gain)


def bus_most_V(board: Board) -> float:
    """Return the supply voltage at which the board's ADC ends."""
    return board.adc_volt * board.bus_divider
