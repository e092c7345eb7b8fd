"""Turns a brushless joint's SI data into its integer blocks: gains from bandwidths, scales, limits.

Velocity loop: kp = J w / kt, ki = kp w / 4. Position loop: kp = w. The current loop's gains, the units and
refusals are in joint_units.py, heat in joint_heat.py. Every value is checked once, here, so that no product in
shared/joint reaches 2^30.
"""

from dataclasses import dataclass, field
from math import exp, pi

from shared.joint.commutation import fill_sine, set_commutation
from shared.joint.current import set_loop, set_offsets
from shared.joint.layout import CurrentLoop, JointIo, JointSettings, JointState, LoopSettings
from shared.record import pack

from ..util.errors import UserError
from .actuators import Bldc
from .drives import joint_model
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
from .thermistor import curve, part_of, refusal

CURRENT_SHARE = 0.98  # of the limit can be commanded: noise and overshoot of the current loop need the rest (chosen)


@dataclass(frozen=True)
class JointBlocks:
    """The integer blocks of one joint, ready for joint_reset, and their units."""

    loop: CurrentLoop
    loop_settings: LoopSettings
    settings: JointSettings
    curve: list[int]
    units: Units
    state: JointState = field(default_factory=JointState)
    io: JointIo = field(default_factory=JointIo)

    def stored(self) -> list[int]:
        """Return the values of the parameters from current_kp on, by their ids (firmware/joint_store.py)."""
        return [*pack(self.loop_settings), *self.curve, *pack(self.settings)]


def joint_blocks(bldc: Bldc, setup: JointSetup, board: Board | None = None) -> JointBlocks:
    """Return the blocks of one joint; UserError with one line if its data do not fit the integers."""
    board = board or Board()
    check_bandwidths(bldc)
    check_ripple(bldc)
    if why := refusal(bldc, board):
        raise UserError(f"actuator.thermal.thermistor_25C_ohm {bldc.thermal.thermistor_25C_ohm:g}: use {why}")
    units = choose_units(bldc, board)
    loop_settings = _loop(bldc, board, units)
    loop = CurrentLoop()
    fill_sine(loop)
    set_loop(loop, loop_settings)
    settings = JointSettings()
    for part in (_electrical, _mechanics, _wire, _cascade, _protection, heat_places, _states, _commission):
        for name, value in part(bldc, setup, board, units).items():
            setattr(settings, name, value)
    _check_ranges(settings)
    set_commutation(loop, settings)
    set_offsets(loop, 2048 << 4, 2048 << 4, 2048 << 4)
    return JointBlocks(loop, loop_settings, settings, list(curve(part_of(bldc, board))), units)


def impedance_gains(bldc: Bldc) -> tuple[int, int]:
    """Return stiffness and damping of a set-point in impedance mode, 1/16 A/turn and 1/256 A/(turn/s).

    Those of the position and velocity bandwidths on the rotor's inertia, as drives.joint_model has them at the joint.
    """
    law, Nm_A = joint_model(bldc, 1.0), bldc.motor.torque_constant_Nm_A * bldc.gear.ratio
    stiffness, damping = (2 * pi * value / Nm_A for value in (law.stiffness_Nm_rad, law.damping_Nms_rad))
    gains = round(16 * stiffness), round(256 * damping)
    if max(gains) > 32767:
        raise UserError(
            f"actuator.drive.velocity_bandwidth_hz {bldc.drive.velocity_bandwidth_hz:g}: gives a stiffness of "
            f"{stiffness:.0f} A/turn and a damping of {damping:.0f} A/(turn/s); the bus carries 2047 and 127: lower it"
        )
    return gains


def _loop(bldc: Bldc, board: Board, units: Units) -> LoopSettings:
    loop_settings = LoopSettings()
    period = round(board.timer_hz / (2 * bldc.drive.pwm_hz))
    if not 500 <= period <= 7000:
        low, high = board.timer_hz / 14000, board.timer_hz / 1000
        raise UserError(f"actuator.drive.pwm_hz {bldc.drive.pwm_hz}: allowed {low:.0f} .. {high:.0f} with this timer")
    loop_settings.pwm_period = period
    loop_settings.pwm_half = period * 8 + 8
    loop_settings.pwm_pulse = round(board.shortest_pulse_s * board.timer_hz / 2)
    loop_settings.pwm_window = round(board.settling_s * board.timer_hz)  # the sample is taken in the middle
    loop_settings.pwm_span = (period - 2 * max(loop_settings.pwm_pulse, loop_settings.pwm_window) - 1) * 16
    loop_settings.current_kp, loop_settings.current_ki = step_gains(bldc, units.ampere_per_cu, units.volt_per_vu)
    loop_settings.trip_square = round(trip_A(bldc, board) / units.ampere_per_cu) ** 2
    return loop_settings


def _electrical(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    motor, drive = bldc.motor, bldc.drive
    if drive.over_voltage_V > 0.95 * bus_most_V(board):
        raise UserError(
            f"actuator.drive.over_voltage_V {drive.over_voltage_V:g}: the board reads up to {bus_most_V(board):.3g} V"
        )
    volt_s = motor.torque_constant_Nm_A / 1.5  # V per rad/s of the rotor on the q axis
    henry = motor.inductance_H * motor.pole_pairs * units.ampere_per_cu / units.volt_per_vu
    brad_per_step = 4 * motor.pole_pairs / 256 * 65536 * MOTION_HZ / drive.current_loop_hz  # and rate, Q16
    return {
        "pole_pairs": motor.pole_pairs,
        "direction": 1,
        "bus_gain": round(bus_most_V(board) / 4096 / units.volt_per_vu * 4096),
        "bus_least": max(64, round(drive.bus_voltage_V / 4 / units.volt_per_vu)),
        "bemf": round(volt_s / RATE_PER_RAD_S * 8 / units.volt_per_vu * 65536),
        "omega_l": round(henry / RATE_PER_RAD_S * 8 * 65536 * 4096),
        "advance": round(brad_per_step * (board.duty_delay_steps + 0.5)),  # to the middle of the step they act
        "age": round(brad_per_step * board.rotor_age_steps),
        "dead": round(4 / pi * board.dead_time_s * drive.pwm_hz * 32768),
        "dead_zone": max(1, round(0.1 / units.ampere_per_cu)),
    }


def _mechanics(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    pole = exp(-2 * pi * 4 * bldc.drive.velocity_bandwidth_hz / MOTION_HZ)  # tracking four times as fast
    return {
        "gear_q8": round(units.gear * 256),
        "joint_sign": setup.sign,
        "has_joint_encoder": int(setup.has_joint_encoder),
        "joint_encoder_sign": 1,
        "disagree": 6000,  # rc: 0.73 of half a rotor turn, 6.0 deg at 22:1
        "disagree_ticks": 5,
        "track_1": round((1 - pole * pole) * 4096),
        "track_2": round((1 - pole) ** 2 * 4096),
        "glitch_steps": max(2, bldc.drive.current_loop_hz // MOTION_HZ // 2),
        "bad_ticks": 3,
        "home_tolerance": 4096,  # a quarter of a rotor turn
    }


def _wire(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    rate = units.gear * 16384 * 256 / 4096 / MOTION_HZ
    return {
        "rate_q8": round(rate * 256),
        "wire_rate_q16": round(65536 / rate),
        "current_q14": round(16384 / 4096 / units.ampere_per_cu),
        "wire_current_q12": round(units.ampere_per_cu * 4096 * 4096),
        "turn18_q14": round(16 / units.gear * 16384),
        "wire_bus_q12": round(units.volt_per_vu * 16 * 4096),
    }


def _cascade(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    drive = bldc.drive
    ampere_per_rad_s2 = rotor_inertia(bldc, setup) / bldc.motor.torque_constant_Nm_A
    w = 2 * pi * drive.velocity_bandwidth_hz
    kp = ampere_per_rad_s2 * w / RATE_PER_RAD_S / units.ampere_per_cu
    accel = 0.6 * drive.current_limit_A / ampere_per_rad_s2
    return {
        "position_p": round(2 * pi * drive.position_bandwidth_hz / MOTION_HZ * 256 * 64),
        "velocity_p": round(kp * 4096),
        "velocity_i": round(kp * w / 4 / MOTION_HZ * 65536),
        "inertia": round(ampere_per_rad_s2 * MOTION_HZ / RATE_PER_RAD_S / units.ampere_per_cu * 256),
        "rate_max": round(drive.speed_limit_rad_s * units.gear * RATE_PER_RAD_S),
        "accel": min(65535, round(accel * RATE_PER_RAD_S / MOTION_HZ)),
        "position_min": round(setup.lower_rad / units.rad_per_rc),
        "position_max": round(setup.upper_rad / units.rad_per_rc),
        "current_max": round(CURRENT_SHARE * drive.current_limit_A / units.ampere_per_cu),
        "damp": round(kp / 2 * 4096),
        "damp_current": round(drive.current_limit_A / 2 / units.ampere_per_cu),
        "extrapolate_ticks": 10,
    }


def _protection(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    drive = bldc.drive
    low = drive.under_voltage_V + (drive.bus_voltage_V - drive.under_voltage_V) / 4
    high = drive.over_voltage_V - (drive.over_voltage_V - drive.bus_voltage_V) / 4
    return {
        "under": round(drive.under_voltage_V / units.volt_per_vu),
        "over": round(drive.over_voltage_V / units.volt_per_vu),
        "under_start": round(low / units.volt_per_vu),
        "over_start": round(high / units.volt_per_vu),
        "bus_ticks": 5,
        "rate_trip": round(1.3 * drive.speed_limit_rad_s * units.gear * RATE_PER_RAD_S),
        "position_margin": round(0.1 / units.rad_per_rc),
        "stall_rate": round(0.05 / units.rad_s_per_rate),
        "stall_ticks": 1000,
        "sum_limit": 60,  # counts: 0.24 A at 5 mOhm and 40 V/V
        "sum_ticks": 10,
    }


def _states(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    return {
        "watchdog_ticks": 100,
        "fresh_ticks": 50,
        "near": round(0.1 / units.rad_per_rc),
        "damp_ticks": 500,
        "quick_ticks": 500,
    }


def _commission(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[str, int]:
    nearer = setup.lower_rad if setup.stop_towards < 0 else setup.upper_rad
    stop = nearer if setup.stop_rad is None else setup.stop_rad
    return {
        "stop": round(stop / units.rad_per_rc),
        "home_rate": setup.stop_towards * round(0.3 / units.rad_s_per_rate),
        "home_current": round(0.4 * bldc.drive.current_limit_A / units.ampere_per_cu),
        "home_ticks": 200,
        "home_limit_ticks": 30000,
        "offset_spread": 250,
        "commission_current": round(0.5 * bldc.drive.current_limit_A / units.ampere_per_cu),
        "commission_bus_least": round(bldc.drive.under_voltage_V / units.volt_per_vu),
        "commission_bus_most": round(bldc.drive.over_voltage_V / units.volt_per_vu),
        "verify": 2731,  # 15 electrical degrees
        "current_w": round(2 * pi * bldc.drive.current_bandwidth_hz / bldc.drive.current_loop_hz * 4096),
        "velocity_w": round(2 * pi * bldc.drive.velocity_bandwidth_hz / MOTION_HZ * 65536),
    }


_RANGES = {
    "bus_gain": (1, 1 << 17, "bus divider"),
    "bemf": (0, 16383, "actuator.motor.torque_constant_Nm_A"),
    "omega_l": (0, 16383, "actuator.motor.inductance_H"),
    "advance": (0, 2047, "actuator.motor.pole_pairs"),
    "age": (0, 2047, "actuator.motor.pole_pairs"),
    "position_p": (1, 4095, "actuator.drive.position_bandwidth_hz"),
    "velocity_p": (4, 8191, "actuator.drive.velocity_bandwidth_hz"),
    "velocity_i": (1, 8191, "actuator.drive.velocity_bandwidth_hz"),
    "inertia": (0, 16383, "leg inertia"),
    "rate_max": (1, 262143, "actuator.drive.speed_limit_rad_s"),
    "accel": (16, 65535, "leg inertia"),
    "rate_trip": (1, 524287, "actuator.drive.speed_limit_rad_s"),
    "position_min": (-(1 << 21), 1 << 21, "joint limits"),
    "position_max": (-(1 << 21), 1 << 21, "joint limits"),
    "current_max": (1, 12288, "actuator.drive.current_limit_A"),
    "heat": (1, 2047, "actuator.thermal.winding_J_K"),
    "winding_leak": (1, 16383, "actuator.thermal.winding_to_housing_K_W"),
    "housing_gain": (1, 16383, "actuator.thermal.winding_to_housing_K_W"),
    "housing_leak": (1, 16383, "actuator.thermal.housing_to_air_K_W"),
    "current_q14": (1, 32767, "actuator.drive.shunt_ohm"),
    "over": (1, AXIS_MOST_VU, "actuator.drive.over_voltage_V"),
}


def _check_ranges(settings: JointSettings) -> None:
    for field_name, (low, high, name) in _RANGES.items():
        value = getattr(settings, field_name)
        if not low <= value <= high:
            raise UserError(f"{name}: gives {value} in the joint's integers, allowed {low} .. {high}")
    if settings.position_min >= settings.position_max:
        raise UserError("joint limits: the lower one must be below the upper one")
