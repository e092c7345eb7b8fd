"""A brushless joint's SI data become its integer blocks: gains from bandwidths, scales, limits, curves.

Current loop: kp = L w, ki = R w. Velocity loop: kp = J w / kt, ki = kp w / 4. Position loop: kp = w. No
bandwidth may exceed a twentieth of its loop's rate. Every scale is chosen and checked here, once, so
that no product in shared/joint reaches 2^30.
"""

from array import array
from dataclasses import dataclass, field
from math import exp, log, pi, sqrt

from shared.joint import layout as j
from shared.joint.calibration import set_commutation
from shared.joint.current import set_offsets
from shared.joint.sine import fill_sine
from shared.joint.thermal import CURVE_SIZE

from .errors import UserError
from .robot_actuators import Bldc

MOTION_HZ = 1000  # motion_tick
SLOW_HZ = 10  # slow_tick
RATE_PER_RAD_S = 16384 / (2 * pi) / MOTION_HZ * 256  # rate units per rad/s of the rotor
WORD = 1 << 30
AXIS_MOST_VU = 23170  # 2^14.5: the squares of both axes add up to less than 2^30
CURRENT_SHARE = 0.98  # of the limit may be asked for: noise and overshoot of the current loop need the rest (chosen)
PTC_PER_K = 0.0078  # silicon sensor, per K at 25 degrees C (typical datasheet value)


@dataclass(frozen=True)
class Board:
    """The controller board's own data; assumed where the paper gives none."""

    adc_volt: float = 3.3
    timer_hz: float = 168e6  # STM32F405, TIM1
    bus_divider: float = 13.0  # assumed: 42.9 V full scale
    dead_time_s: float = 100e-9  # DRV8323 default
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
    stop_rad: float | None = None  # where the mechanical stop is; the nearer limit if not given
    stop_towards: int = -1  # direction in which the stop is looked for
    continuous_A: float | None = None  # current that may flow for ever; the current limit if not given
    peak_s: float = 10.0  # time at the limit until only that is left


@dataclass(frozen=True)
class Units:
    """SI per integer unit of one joint."""

    ampere_per_cu: float
    volt_per_vu: float
    rad_per_rc: float  # of the joint
    rad_s_per_rate: float  # of the joint
    newton_metre_per_cu: float  # at the joint, ideal gear
    gear: float


@dataclass(frozen=True)
class JointBlocks:
    """The integer blocks of one joint, ready for joint_reset, and their units."""

    foc: array
    cfg: array
    curve: array
    units: Units
    state: array = field(default_factory=lambda: array("i", [0] * j.STATE_SIZE))
    io: array = field(default_factory=lambda: array("i", [0] * j.IO_SIZE))


def joint_blocks(bldc: Bldc, setup: JointSetup, board: Board | None = None) -> JointBlocks:
    """Return the blocks of one joint; UserError with one line if its data cannot be served."""
    board = board or Board()
    check_bandwidths(bldc)
    check_ripple(bldc)
    units = choose_units(bldc, board)
    foc = _foc(bldc, board, units)
    cfg = array("i", [0] * j.CFG_SIZE)
    for part in (_electrical, _mechanics, _wire, _cascade, _protection, _thermal, _states, _calibration):
        for place, value in part(bldc, setup, board, units).items():
            cfg[place] = value
    _check_ranges(cfg)
    set_commutation(foc, cfg)
    set_offsets(foc, 2048 << 4, 2048 << 4, 2048 << 4)
    return JointBlocks(foc, cfg, thermistor_curve(bldc, board), units)


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
    """Return the inertia the motor turns, seen at the rotor, in kg m2."""
    return bldc.motor.rotor_inertia_kg_m2 + setup.inertia_kg_m2 / bldc.gear.ratio**2


def trip_A(bldc: Bldc, board: Board) -> float:
    """Return the current at which the step trips: 2.5 times the limit, or 0.85 of what the shunts can read."""
    return min(2.5 * bldc.drive.current_limit_A, 0.85 * _full_scale_A(bldc, board))


def choose_units(bldc: Bldc, board: Board) -> Units:
    """Return the joint's units: vu is the finest 2^-k V for which the current step cannot overflow."""
    ampere = _full_scale_A(bldc, board) / 2048 / 6
    gear = bldc.gear.ratio
    if not 1 <= gear <= 63.9:
        raise UserError(f"actuator.gear.ratio {gear:g}: a joint's integers serve 1 .. 63.9")
    if bldc.drive.current_limit_A > 0.6 * _full_scale_A(bldc, board):
        raise UserError(
            f"actuator.drive.current_limit_A {bldc.drive.current_limit_A:g}: at most 60 % of the "
            f"{_full_scale_A(bldc, board):.3g} A that shunt_ohm and amplifier_gain can read"
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
    """Return F_KP and F_KI (Q13) for units of ``ampere`` and ``volt``."""
    kp, ki = current_gains(bldc)
    scale = ampere / volt * 8192
    return round(kp * scale), round(ki / bldc.drive.current_loop_hz * scale)


def _fits(bldc: Bldc, board: Board, ampere: float, volt: float) -> bool:
    """Whether the sums of current_step stay in range: largest error, integral at both voltage limits, feed-forward."""
    kp, ki = step_gains(bldc, ampere, volt)
    error = (trip_A(bldc, board) + bldc.drive.current_limit_A) / ampere
    longest = _bus_most_V(board) / sqrt(3) / volt
    total = (kp + ki) * error + 2 * longest * 8192
    fine = bldc.drive.bus_voltage_V / volt >= 2500  # a duty is no coarser than the timer makes it
    return fine and total < WORD and total / 8192 + longest < AXIS_MOST_VU and kp > 64 and ki > 8


def _full_scale_A(bldc: Bldc, board: Board) -> float:
    """Current at half of the ADC's range."""
    return board.adc_volt / 2 / (bldc.drive.shunt_ohm * bldc.drive.amplifier_gain)


def _bus_most_V(board: Board) -> float:
    return board.adc_volt * board.bus_divider


def _foc(bldc: Bldc, board: Board, units: Units) -> array:
    foc = array("i", [0] * j.FOC_SIZE)
    period = round(board.timer_hz / (2 * bldc.drive.pwm_hz))
    if not 500 <= period <= 7000:
        low, high = board.timer_hz / 14000, board.timer_hz / 1000
        raise UserError(f"actuator.drive.pwm_hz {bldc.drive.pwm_hz}: {low:.0f} .. {high:.0f} on this timer")
    fill_sine(foc)
    foc[j.F_PERIOD] = period
    foc[j.F_HALF] = period * 8 + 8
    foc[j.F_PULSE] = round(board.shortest_pulse_s * board.timer_hz / 2)
    foc[j.F_WINDOW] = round(board.settling_s * board.timer_hz)  # the sample is taken in the middle
    foc[j.F_SPAN] = (period - 2 * max(foc[j.F_PULSE], foc[j.F_WINDOW]) - 1) * 16
    foc[j.F_KP], foc[j.F_KI] = step_gains(bldc, units.ampere_per_cu, units.volt_per_vu)
    foc[j.F_TRIP_SQUARE] = round(trip_A(bldc, board) / units.ampere_per_cu) ** 2
    return foc


def _electrical(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    motor, drive = bldc.motor, bldc.drive
    if drive.over_voltage_V > 0.95 * _bus_most_V(board):
        raise UserError(
            f"actuator.drive.over_voltage_V {drive.over_voltage_V:g}: the board reads up to {_bus_most_V(board):.3g} V"
        )
    volt_s = motor.torque_constant_Nm_A / 1.5  # V per rad/s of the rotor on the q axis
    henry = motor.inductance_H * motor.pole_pairs * units.ampere_per_cu / units.volt_per_vu
    steps = 1.5 * MOTION_HZ / drive.current_loop_hz
    return {
        j.K_POLE_PAIRS: motor.pole_pairs,
        j.K_DIRECTION: 1,
        j.K_BUS_GAIN: round(_bus_most_V(board) / 4096 / units.volt_per_vu * 4096),
        j.K_BUS_LEAST: max(64, round(drive.bus_voltage_V / 4 / units.volt_per_vu)),
        j.K_BEMF: round(volt_s / RATE_PER_RAD_S * 8 / units.volt_per_vu * 65536),
        j.K_OMEGA_L: round(henry / RATE_PER_RAD_S * 8 * 65536 * 4096),
        j.K_ADVANCE: round(4 * motor.pole_pairs * steps / 256 * 65536),
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


def _thermal(bldc: Bldc, setup: JointSetup, board: Board, units: Units) -> dict[int, int]:
    t, watt = bldc.thermal, 1.5 * bldc.motor.resistance_ohm * units.ampere_per_cu**2 * 256
    heat, heat_shift = _with_shift(watt / t.winding_J_K / SLOW_HZ * 16 * 16384, 2047, 24)
    leaks = [
        1 / (t.winding_J_K * t.winding_to_housing_K_W) / SLOW_HZ,
        1 / (t.housing_J_K * t.winding_to_housing_K_W) / SLOW_HZ,
        1 / (t.housing_J_K * t.housing_to_air_K_W) / SLOW_HZ,
    ]
    _, shift = _with_shift(max(leaks), 16383, 30)
    limit = bldc.drive.current_limit_A
    lasting = min(setup.continuous_A or limit, limit)
    most, least = limit / units.ampere_per_cu, lasting / units.ampere_per_cu
    return {
        j.K_OPEN_RAW: 4032,
        j.K_SHORT_RAW: 32,
        j.K_MCU_CAL1: board.mcu_cal1,
        j.K_MCU_CAL2: board.mcu_cal2,
        j.K_WINDING_DERATE: round(t.winding_derate_C * 16),
        j.K_WINDING_CUT: round(t.winding_cutoff_C * 16),
        j.K_MCU_DERATE: round(t.board_derate_C * 16),
        j.K_MCU_CUT: round(t.board_cutoff_C * 16),
        j.K_HEAT: heat,
        j.K_HEAT_SHIFT: heat_shift,
        j.K_WINDING_LEAK: round(leaks[0] * 2**shift),
        j.K_HOUSING_GAIN: round(leaks[1] * 2**shift),
        j.K_HOUSING_LEAK: round(leaks[2] * 2**shift),
        j.K_LEAK_SHIFT: shift,
        j.K_I2T_CURRENT: round(least),
        j.K_I2T_MAX: min(1 << 29, max(2, round((most**2 - least**2) / 256 * SLOW_HZ * setup.peak_s))),
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


def thermistor_curve(bldc: Bldc, board: Board) -> array:
    """Return CURVE_SIZE temperatures in 1/16 degree C over the ADC's range, -60 .. 250 degrees C."""
    step = 4096 // (CURVE_SIZE - 1)
    points = []
    for i in range(CURVE_SIZE):
        raw = min(max(i * step, 1), 4095)
        ohm = board.thermistor_pull_up_ohm * raw / (4096 - raw)
        points.append(round(16 * min(max(thermistor_C(bldc, ohm), -60.0), 250.0)))
    return array("i", points)


def thermistor_C(bldc: Bldc, ohm: float) -> float:
    """Return the temperature of a resistance: R25 exp(B (1/T - 1/T25)), or a silicon sensor's straight line."""
    t = bldc.thermal
    if t.thermistor == "ptc":
        return 25.0 + (ohm / t.thermistor_25C_ohm - 1) / PTC_PER_K
    inverse = 1 / 298.15 + log(ohm / t.thermistor_25C_ohm) / t.thermistor_beta_K
    return 1 / inverse - 273.15 if inverse > 1e-4 else 250.0


def _with_shift(value: float, most: int, shift_most: int) -> tuple[int, int]:
    """Return (mantissa, shift) with value = mantissa / 2^shift and the mantissa as large as ``most`` allows."""
    shift = 0
    while shift < shift_most and value * 2 ** (shift + 1) <= most:
        shift += 1
    return round(value * 2**shift), shift


_RANGES = {
    j.K_BUS_GAIN: (1, 1 << 17, "bus divider"),
    j.K_BEMF: (0, 16383, "actuator.motor.torque_constant_Nm_A"),
    j.K_OMEGA_L: (0, 16383, "actuator.motor.inductance_H"),
    j.K_ADVANCE: (0, 2047, "actuator.motor.pole_pairs"),
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


def _check_ranges(cfg: array) -> None:
    for place, (low, high, name) in _RANGES.items():
        if not low <= cfg[place] <= high:
            raise UserError(f"{name}: gives {cfg[place]} in the joint's integers, {low} .. {high} is allowed")
    if cfg[j.K_POSITION_MIN] >= cfg[j.K_POSITION_MAX]:
        raise UserError("joint limits: the lower one must be below the upper one")
