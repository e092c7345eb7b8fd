"""A brushless joint's SI data become its integer blocks: gains from bandwidths, scales, limits.

Velocity loop: kp = J w / kt, ki = kp w / 4. Position loop: kp = w. The current loop's gains, the units and what is
refused are in joint_units.py, heat in joint_heat.py. Every value is checked here, once, so that no product in
shared/joint reaches 2^30.
"""

from dataclasses import dataclass, field
from math import exp, pi

from shared.joint import layout as j
from shared.joint.calibration import set_commutation
from shared.joint.current import set_offsets
from shared.joint.layout import Foc, JointConfig, JointIo, JointState
from shared.joint.sine import fill_sine

from .errors import UserError
from .joint_heat import heat_places
from .joint_units import (
    AXIS_MOST_VU,
    MOTION_HZ,
    RATE_PER_RAD_S,
    Board,
    JointSetup,
    Units,
    bus_most_V,
    check_bandwidths,
    check_ripple,
    choose_units,
    rotor_inertia,
    step_gains,
    trip_A,
)
from .robot_actuators import Bldc
from .thermistor import curve, part_of, refusal

CURRENT_SHARE = 0.98  # of the limit may be asked for: noise and overshoot of the current loop need the rest (chosen)


@dataclass(frozen=True)
class JointBlocks:
    """The integer blocks of one joint, ready for joint_reset, and their units."""

    foc: list[int]
    cfg: list[int]
    curve: list[int]
    units: Units
    state: list[int] = field(default_factory=lambda: JointState())
    io: list[int] = field(default_factory=lambda: JointIo())


def joint_blocks(bldc: Bldc, setup: JointSetup, board: Board | None = None) -> JointBlocks:
    """Return the blocks of one joint; UserError with one line if its data cannot be served."""
    board = board or Board()
    check_bandwidths(bldc)
    check_ripple(bldc)
    if why := refusal(bldc, board):
        raise UserError(f"actuator.thermal.thermistor_25C_ohm {bldc.thermal.thermistor_25C_ohm:g}: use {why}")
    units = choose_units(bldc, board)
    foc = _foc(bldc, board, units)
    cfg = JointConfig()
    for part in (_electrical, _mechanics, _wire, _cascade, _protection, heat_places, _states, _calibration):
        for place, value in part(bldc, setup, board, units).items():
            cfg[place] = value
    _check_ranges(cfg)
    set_commutation(foc, cfg)
    set_offsets(foc, 2048 << 4, 2048 << 4, 2048 << 4)
    return JointBlocks(foc, cfg, list(curve(part_of(bldc, board))), units)


def _foc(bldc: Bldc, board: Board, units: Units) -> list[int]:
    foc = Foc()
    period = round(board.timer_hz / (2 * bldc.drive.pwm_hz))
    if not 500 <= period <= 7000:
        low, high = board.timer_hz / 14000, board.timer_hz / 1000
        raise UserError(f"actuator.drive.pwm_hz {bldc.drive.pwm_hz}: {low:.0f} .. {high:.0f} on this timer")
    fill_sine(foc)
    foc.period = period
    foc.half_period = period * 8 + 8
    foc.pulse = round(board.shortest_pulse_s * board.timer_hz / 2)
    foc.window = round(board.settling_s * board.timer_hz)  # the sample is taken in the middle
    foc.span_max = (period - 2 * max(foc.pulse, foc.window) - 1) * 16
    foc.kp, foc.ki = step_gains(bldc, units.ampere_per_cu, units.volt_per_vu)
    foc.trip_square = round(trip_A(bldc, board) / units.ampere_per_cu) ** 2
    return foc


def _electrical(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    motor, drive = bldc.motor, bldc.drive
    if drive.over_voltage_V > 0.95 * bus_most_V(board):
        raise UserError(
            f"actuator.drive.over_voltage_V {drive.over_voltage_V:g}: the board reads up to {bus_most_V(board):.3g} V"
        )
    volt_s = motor.torque_constant_Nm_A / 1.5  # V per rad/s of the rotor on the q axis
    henry = motor.inductance_H * motor.pole_pairs * units.ampere_per_cu / units.volt_per_vu
    brad_per_step = 4 * motor.pole_pairs / 256 * 65536 * MOTION_HZ / drive.current_loop_hz  # and rate, Q16
    return {
        j.K_POLE_PAIRS: motor.pole_pairs,
        j.K_DIRECTION: 1,
        j.K_BUS_GAIN: round(bus_most_V(board) / 4096 / units.volt_per_vu * 4096),
        j.K_BUS_LEAST: max(64, round(drive.bus_voltage_V / 4 / units.volt_per_vu)),
        j.K_BEMF: round(volt_s / RATE_PER_RAD_S * 8 / units.volt_per_vu * 65536),
        j.K_OMEGA_L: round(henry / RATE_PER_RAD_S * 8 * 65536 * 4096),
        j.K_ADVANCE: round(brad_per_step * (board.duty_delay_steps + 0.5)),  # to the middle of the step they act
        j.K_AGE: round(brad_per_step * board.rotor_age_steps),
        j.K_DEAD: round(4 / pi * board.dead_time_s * drive.pwm_hz * 32768),
        j.K_DEAD_ZONE: max(1, round(0.1 / units.ampere_per_cu)),
    }


def _mechanics(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    pole = exp(-2 * pi * 4 * bldc.drive.velocity_bandwidth_hz / MOTION_HZ)  # tracking four times as fast
    return {
        j.K_GEAR_Q8: round(units.gear * 256),
        j.K_JOINT_SIGN: setup.sign,
        j.K_HAS_JOINT_ENCODER: int(setup.has_joint_encoder),
        j.K_JOINT_ENCODER_SIGN: 1,
        j.K_DISAGREE: 6000,  # rc: 0.73 of half a rotor turn, 6.0 deg at 22:1
        j.K_DISAGREE_TICKS: 5,
        j.K_TRACK_1: round((1 - pole * pole) * 4096),
        j.K_TRACK_2: round((1 - pole) ** 2 * 4096),
        j.K_GLITCH_STEPS: max(2, bldc.drive.current_loop_hz // MOTION_HZ // 2),
        j.K_BAD_TICKS: 3,
        j.K_HOME_TOLERANCE: 4096,  # a quarter of a rotor turn
    }


def _wire(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    rate = units.gear * 16384 * 256 / 4096 / MOTION_HZ
    return {
        j.K_RATE_Q8: round(rate * 256),
        j.K_WIRE_RATE_Q16: round(65536 / rate),
        j.K_CURRENT_Q14: round(16384 / 4096 / units.ampere_per_cu),
        j.K_WIRE_CURRENT_Q12: round(units.ampere_per_cu * 4096 * 4096),
        j.K_TURN18_Q14: round(16 / units.gear * 16384),
        j.K_WIRE_BUS_Q12: round(units.volt_per_vu * 16 * 4096),
    }


def _cascade(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    drive = bldc.drive
    ampere_per_rad_s2 = rotor_inertia(bldc, setup) / bldc.motor.torque_constant_Nm_A
    w = 2 * pi * drive.velocity_bandwidth_hz
    kp = ampere_per_rad_s2 * w / RATE_PER_RAD_S / units.ampere_per_cu
    accel = 0.6 * drive.current_limit_A / ampere_per_rad_s2
    return {
        j.K_POSITION_P: round(2 * pi * drive.position_bandwidth_hz / MOTION_HZ * 256 * 64),
        j.K_VELOCITY_P: round(kp * 4096),
        j.K_VELOCITY_I: round(kp * w / 4 / MOTION_HZ * 65536),
        j.K_INERTIA: round(ampere_per_rad_s2 * MOTION_HZ / RATE_PER_RAD_S / units.ampere_per_cu * 256),
        j.K_RATE_MAX: round(drive.speed_limit_rad_s * units.gear * RATE_PER_RAD_S),
        j.K_ACCEL: min(65535, round(accel * RATE_PER_RAD_S / MOTION_HZ)),
        j.K_POSITION_MIN: round(setup.lower_rad / units.rad_per_rc),
        j.K_POSITION_MAX: round(setup.upper_rad / units.rad_per_rc),
        j.K_CURRENT_MAX: round(CURRENT_SHARE * drive.current_limit_A / units.ampere_per_cu),
        j.K_DAMP: round(kp / 2 * 4096),
        j.K_DAMP_CURRENT: round(drive.current_limit_A / 2 / units.ampere_per_cu),
        j.K_EXTRAPOLATE_TICKS: 10,
    }


def _protection(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    drive = bldc.drive
    low = drive.under_voltage_V + (drive.bus_voltage_V - drive.under_voltage_V) / 4
    high = drive.over_voltage_V - (drive.over_voltage_V - drive.bus_voltage_V) / 4
    return {
        j.K_UNDER: round(drive.under_voltage_V / units.volt_per_vu),
        j.K_OVER: round(drive.over_voltage_V / units.volt_per_vu),
        j.K_UNDER_START: round(low / units.volt_per_vu),
        j.K_OVER_START: round(high / units.volt_per_vu),
        j.K_BUS_TICKS: 5,
        j.K_RATE_TRIP: round(1.3 * drive.speed_limit_rad_s * units.gear * RATE_PER_RAD_S),
        j.K_POSITION_MARGIN: round(0.1 / units.rad_per_rc),
        j.K_STALL_RATE: round(0.05 / units.rad_s_per_rate),
        j.K_STALL_TICKS: 1000,
        j.K_SUM_LIMIT: 60,  # counts: 0.24 A at 5 mOhm and 40 V/V
        j.K_SUM_TICKS: 10,
    }


def _states(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    return {
        j.K_WATCHDOG_TICKS: 100,
        j.K_FRESH_TICKS: 50,
        j.K_NEAR: round(0.1 / units.rad_per_rc),
        j.K_DAMP_TICKS: 500,
        j.K_QUICK_TICKS: 500,
    }


def _calibration(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    nearer = setup.lower_rad if setup.stop_towards < 0 else setup.upper_rad
    stop = nearer if setup.stop_rad is None else setup.stop_rad
    return {
        j.K_STOP: round(stop / units.rad_per_rc),
        j.K_HOME_RATE: setup.stop_towards * round(0.3 / units.rad_s_per_rate),
        j.K_HOME_CURRENT: round(0.4 * bldc.drive.current_limit_A / units.ampere_per_cu),
        j.K_HOME_TICKS: 200,
        j.K_HOME_LIMIT_TICKS: 30000,
        j.K_OFFSET_SPREAD: 250,
        j.K_CAL_CURRENT: round(0.5 * bldc.drive.current_limit_A / units.ampere_per_cu),
        j.K_CAL_BUS_LEAST: round(bldc.drive.under_voltage_V / units.volt_per_vu),
        j.K_CAL_BUS_MOST: round(bldc.drive.over_voltage_V / units.volt_per_vu),
        j.K_VERIFY: 2731,  # 15 electrical degrees
    }


_RANGES = {
    j.K_BUS_GAIN: (1, 1 << 17, "bus divider"),
    j.K_BEMF: (0, 16383, "actuator.motor.torque_constant_Nm_A"),
    j.K_OMEGA_L: (0, 16383, "actuator.motor.inductance_H"),
    j.K_ADVANCE: (0, 2047, "actuator.motor.pole_pairs"),
    j.K_AGE: (0, 2047, "actuator.motor.pole_pairs"),
    j.K_POSITION_P: (1, 4095, "actuator.drive.position_bandwidth_hz"),
    j.K_VELOCITY_P: (4, 8191, "actuator.drive.velocity_bandwidth_hz"),
    j.K_VELOCITY_I: (1, 8191, "actuator.drive.velocity_bandwidth_hz"),
    j.K_INERTIA: (0, 16383, "leg inertia"),
    j.K_RATE_MAX: (1, 262143, "actuator.drive.speed_limit_rad_s"),
    j.K_ACCEL: (16, 65535, "leg inertia"),
    j.K_RATE_TRIP: (1, 524287, "actuator.drive.speed_limit_rad_s"),
    j.K_POSITION_MIN: (-(1 << 21), 1 << 21, "joint limits"),
    j.K_POSITION_MAX: (-(1 << 21), 1 << 21, "joint limits"),
    j.K_CURRENT_MAX: (1, 12288, "actuator.drive.current_limit_A"),
    j.K_HEAT: (1, 2047, "actuator.thermal.winding_J_K"),
    j.K_WINDING_LEAK: (1, 16383, "actuator.thermal.winding_to_housing_K_W"),
    j.K_HOUSING_GAIN: (1, 16383, "actuator.thermal.winding_to_housing_K_W"),
    j.K_HOUSING_LEAK: (1, 16383, "actuator.thermal.housing_to_air_K_W"),
    j.K_CURRENT_Q14: (1, 32767, "actuator.drive.shunt_ohm"),
    j.K_OVER: (1, AXIS_MOST_VU, "actuator.drive.over_voltage_V"),
}


def _check_ranges(cfg: list[int]) -> None:
    for place, (low, high, name) in _RANGES.items():
        if not low <= cfg[place] <= high:
            raise UserError(f"{name}: gives {cfg[place]} in the joint's integers, {low} .. {high} is allowed")
    if cfg.position_min >= cfg.position_max:
        raise UserError("joint limits: the lower one must be below the upper one")
