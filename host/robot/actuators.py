"""The actuators and the bus of a robot file: position servos (paper A), brushless joints (paper B), foreign joints.

Foreign joints and servos without a bus can be simulated but not driven.
"""

from math import inf, pi
from typing import Annotated, Literal

from .values import Table, number, one_of, text, whole


class SupplyPoint(Table):
    """A servo's torque and speed at one supply voltage."""

    voltage_V: Annotated[float, number(3.0, 60.0, "V")]
    stall_Nm: Annotated[float, number(0.01, 200.0, "N m")]
    no_load_rpm: Annotated[float, number(0.1, 1000.0, "rpm")]

    @property
    def no_load_rad_s(self) -> float:
        """No-load speed."""
        return self.no_load_rpm * 2 * pi / 60


class Friction(Table):
    """A servo's friction beyond ``coulomb_Nm``: the M6 model of Duclusaud et al., ICRA 2025 (arXiv 2410.08650).

    All zero is dry friction alone. ``motor``: share of the motor's torque; ``external``: of the load's; ``stribeck``:
    at rest, fading as exp(-(speed / stribeck_rad_s)^stribeck_exponent). host/sim/servos/law.py uses them.
    """

    stribeck_Nm: Annotated[float, number(0.0, 10.0, "N m")] = 0.0
    stribeck_rad_s: Annotated[float, number(0.01, 20.0, "rad/s")] = 0.5
    stribeck_exponent: Annotated[float, number(0.5, 10.0)] = 1.0
    viscous_Nms_rad: Annotated[float, number(0.0, 10.0, "N m s/rad")] = 0.0
    load_motor: Annotated[float, number(0.0, 0.6)] = 0.0
    load_external: Annotated[float, number(0.0, 0.6)] = 0.0
    load_motor_stribeck: Annotated[float, number(0.0, 0.3)] = 0.0
    load_external_stribeck: Annotated[float, number(0.0, 0.3)] = 0.0
    load_motor_square_1_Nm: Annotated[float, number(0.0, 0.1, "1/(N m)")] = 0.0
    load_external_square_1_Nm: Annotated[float, number(0.0, 0.1, "1/(N m)")] = 0.0


class Servo(Table):
    """A position servo with its own controller; the figures are those at the servo's own shaft."""

    kind: Literal["servo"]
    model: Annotated[str, text(r"[\x20-\x7e]{1,60}", "1 .. 60 printable characters")]
    counts_per_turn: Annotated[int, whole(256, 65536, "counts")]
    p_gain: Annotated[int, whole(0, 16383)] = 0  # registers, only for servos on a bus
    i_gain: Annotated[int, whole(0, 16383)] = 0
    d_gain: Annotated[int, whole(0, 16383)] = 0
    duty_per_rad: Annotated[float, number(0.05, 200.0, "1/rad")]
    armature_kg_m2: Annotated[float, number(0.0, 1.0, "kg m2")]
    coulomb_Nm: Annotated[float, number(0.0, 10.0, "N m")]
    nominal_voltage_V: Annotated[float, number(3.0, 60.0, "V")]
    low_voltage_V: Annotated[float, number(3.0, 60.0, "V")]
    hot_C: Annotated[float, number(30.0, 120.0, "degrees C")]
    # Values that few servos' data give; 0 leaves an effect out.
    friction: Friction = Friction()
    backlash_deg: Annotated[float, number(0.0, 10.0, "deg")] = 0.0
    pwm_steps: Annotated[int, whole(0, 65536, "steps")] = 0
    stall_A: Annotated[float, number(0.0, 100.0, "A")] = 0.0
    supply_ohm: Annotated[float, number(0.0, 5.0, "ohm")] = 0.0
    supply: tuple[SupplyPoint, ...]

    @property
    def fastest_rad_s(self) -> float:
        """Its highest speed: the no-load speed at the nominal voltage."""
        return self.nominal.no_load_rad_s

    @property
    def nominal(self) -> SupplyPoint:
        """The supply point of the nominal voltage."""
        return next(point for point in self.supply if point.voltage_V == self.nominal_voltage_V)

    @property
    def step_rad(self) -> float:
        """The resolution of its goals and readings."""
        return 2 * pi / self.counts_per_turn

    @property
    def supply_V(self) -> float:
        """The nominal supply voltage."""
        return self.nominal_voltage_V

    @property
    def least_V(self) -> float:
        """The lowest supply voltage at which it is known to work."""
        return self.supply[0].voltage_V

    @property
    def low_V(self) -> float:
        """The robot sits down below this voltage."""
        return self.low_voltage_V

    @property
    def sit_C(self) -> float:
        """The robot sits down above this temperature."""
        return self.hot_C


class Motor(Table):
    """A brushless motor, and the resolution of its rotor encoder."""

    power_W: Annotated[float, number(1.0, 5000.0, "W")]
    pole_pairs: Annotated[int, whole(1, 50, "pole pairs")]
    resistance_ohm: Annotated[float, number(0.005, 50.0, "ohm")]
    inductance_H: Annotated[float, number(1e-6, 0.1, "H")]
    torque_constant_Nm_A: Annotated[float, number(0.001, 5.0, "N m/A")]
    rotor_inertia_kg_m2: Annotated[float, number(1e-8, 0.01, "kg m2")]
    coulomb_Nm: Annotated[float, number(0.0, 1.0, "N m")]
    encoder_bits: Annotated[int, whole(8, 20, "bits")]


class Gear(Table):
    """From the rotor to the joint."""

    ratio: Annotated[float, number(1.0, 500.0)]
    efficiency: Annotated[float, number(0.1, 1.0)]
    backlash_deg: Annotated[float, number(0.0, 5.0, "deg")]
    stiffness_Nm_rad: Annotated[float, number(1.0, 1e6, "N m/rad")]
    encoder_bits: Annotated[int, whole(8, 20, "bits")]
    thigh_encoder: Annotated[bool, one_of(True, False)]


class Drive(Table):
    """The motor's board: supply, sensing, limits and the loops' bandwidths."""

    bus_voltage_V: Annotated[float, number(6.0, 60.0, "V")]
    under_voltage_V: Annotated[float, number(5.0, 60.0, "V")]
    over_voltage_V: Annotated[float, number(6.0, 70.0, "V")]
    pwm_hz: Annotated[int, whole(5000, 100000, "Hz")]
    current_loop_hz: Annotated[int, whole(1000, 50000, "Hz")]
    current_limit_A: Annotated[float, number(0.1, 100.0, "A")]
    speed_limit_rad_s: Annotated[float, number(0.1, 200.0, "rad/s")]
    shunt_ohm: Annotated[float, number(0.0001, 0.1, "ohm")]
    amplifier_gain: Annotated[float, one_of(5.0, 10.0, 20.0, 40.0)]
    current_bandwidth_hz: Annotated[float, number(10.0, 5000.0, "Hz")]
    velocity_bandwidth_hz: Annotated[float, number(1.0, 500.0, "Hz")]
    position_bandwidth_hz: Annotated[float, number(0.2, 100.0, "Hz")]


class Thermal(Table):
    """The winding's sensor, and how heat flows from winding to housing to air."""

    thermistor: Annotated[Literal["ntc", "ptc"], one_of("ntc", "ptc")]
    thermistor_25C_ohm: Annotated[float, number(10.0, 1e6, "ohm")]
    thermistor_beta_K: Annotated[float, number(100.0, 10000.0, "K")]
    winding_J_K: Annotated[float, number(0.1, 10000.0, "J/K")]
    housing_J_K: Annotated[float, number(0.1, 10000.0, "J/K")]
    winding_to_housing_K_W: Annotated[float, number(0.01, 100.0, "K/W")]
    housing_to_air_K_W: Annotated[float, number(0.01, 100.0, "K/W")]
    winding_derate_C: Annotated[float, number(30.0, 200.0, "degrees C")]
    winding_cutoff_C: Annotated[float, number(30.0, 200.0, "degrees C")]
    board_derate_C: Annotated[float, number(30.0, 150.0, "degrees C")]
    board_cutoff_C: Annotated[float, number(30.0, 150.0, "degrees C")]


class Bldc(Table):
    """A brushless joint with its own controller board; all twelve alike."""

    kind: Literal["bldc"]
    motor: Motor
    gear: Gear
    drive: Drive
    thermal: Thermal

    @property
    def fastest_rad_s(self) -> float:
        """Its highest speed: its board's limit."""
        return self.drive.speed_limit_rad_s

    @property
    def torque_limit_Nm(self) -> float:
        """Torque at the joint at the current limit, with an ideal gear."""
        return self.motor.torque_constant_Nm_A * self.drive.current_limit_A * self.gear.ratio

    @property
    def step_rad(self) -> float:
        """The resolution of its readings."""
        return 2 * pi / 2**self.gear.encoder_bits

    @property
    def supply_V(self) -> float:
        """The nominal supply voltage."""
        return self.drive.bus_voltage_V

    @property
    def least_V(self) -> float:
        """The lowest supply voltage at which it works."""
        return self.drive.under_voltage_V

    @property
    def low_V(self) -> float:
        """The robot sits down below this voltage."""
        return self.drive.under_voltage_V

    @property
    def sit_C(self) -> float:
        """The robot sits down above this temperature."""
        return self.thermal.winding_derate_C


class PdJoint(Table):
    """A foreign joint: its board holds a goal with a stiffness and a damping, within its torque.

    torque = clip(stiffness x error - damping x speed, +-torque). Stiffness and damping are those of a joint, the same
    for all; torque, speed and armature are those at the shaft of the motor's gear.
    """

    kind: Literal["pd"]
    model: Annotated[str, text(r"[\x20-\x7e]{1,60}", "1 .. 60 printable characters")]
    torque_Nm: Annotated[float, number(0.01, 1000.0, "N m")]
    no_load_rad_s: Annotated[float, number(0.1, 200.0, "rad/s")]
    stiffness_Nm_rad: Annotated[float, number(0.1, 1e5, "N m/rad")]
    damping_Nms_rad: Annotated[float, number(0.001, 1000.0, "N m s/rad")]
    armature_kg_m2: Annotated[float, number(0.0, 1.0, "kg m2")]
    coulomb_Nm: Annotated[float, number(0.0, 10.0, "N m")]
    encoder_bits: Annotated[int, whole(8, 20, "bits")]
    voltage_V: Annotated[float, number(3.0, 100.0, "V")]

    @property
    def fastest_rad_s(self) -> float:
        """Its highest speed."""
        return self.no_load_rad_s

    @property
    def step_rad(self) -> float:
        """The resolution of its readings."""
        return 2 * pi / 2**self.encoder_bits

    @property
    def supply_V(self) -> float:
        """The nominal supply voltage."""
        return self.voltage_V

    @property
    def least_V(self) -> float:
        """The lowest supply voltage at which it is known to work: the nominal one."""
        return self.voltage_V

    @property
    def low_V(self) -> float:
        """Unknown: no supply voltage counts as too low."""
        return 0.0

    @property
    def sit_C(self) -> float:
        """Unknown: no temperature counts as too hot."""
        return inf


USUAL_DELAY_S = 0.020  # (assumed: one 50 Hz tick)
Delay = Annotated[float, number(0.0, 0.5, "s")]  # from sending a goal until it acts, and from measuring until known


class ServoBus(Table):
    """The servos' serial bus. The ids of the joints are calibration data, not part of the robot file."""

    kind: Literal["dynamixel"]
    port: Annotated[str, text(r"\S{1,200}", "a device name without spaces")]
    baud: Annotated[int, one_of(9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000, 4500000)]
    protocol: Annotated[float, one_of(1.0, 2.0)]
    delay_s: Delay = USUAL_DELAY_S


class CanBus(Table):
    """The joints' CAN bus or buses, and what holds a position: a spring in the joint, a cascade in it, or the host."""

    kind: Literal["can"]
    interface: Annotated[str, text(r"[a-z0-9_]{1,40}", "the name of a python-can interface, such as socketcan")]
    channel: Annotated[str, text(r"[^\s,]{1,99}(,[^\s,]{1,99})?", "a channel name without spaces, or two with a comma")]
    bitrate: Annotated[int, one_of(125000, 250000, 500000, 1000000)]
    rate_hz: Annotated[int, whole(20, 1000, "Hz")]
    loops: Annotated[
        Literal["impedance", "joint", "host-velocity", "host-current"],
        one_of("impedance", "joint", "host-velocity", "host-current"),
    ]
    delay_s: Delay = USUAL_DELAY_S

    @property
    def channels(self) -> tuple[str, ...]:
        """One bus, or two: one for the front legs and one for the rear legs."""
        return tuple(self.channel.split(","))


class NoBus(Table):
    """No bus: this software can simulate the robot but not drive it."""

    kind: Literal["none"]
    delay_s: Delay = USUAL_DELAY_S
