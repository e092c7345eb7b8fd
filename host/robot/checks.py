"""Checks that need more than one value of a robot file: symmetry, reach, stance, scales, related values.

Each check yields its complaints as (key, value, what is allowed).
"""

from collections.abc import Iterator
from itertools import pairwise
from math import degrees

from sim2d.model import least_inertia_kgm2

from .actuators import Bldc, CanBus, Servo
from .crawl_tuning import crawl_complaints
from .drives import joint_drives
from .gait_names import gait_names
from .joint_units import Board
from .model import JOINT_NAMES, LEG_NAMES, Robot
from .poses import leg_to_rad
from .scale import BRAD_PER_RAD, LARGEST_GAIN, LARGEST_SPEED, Q12, Q16, YAW18
from .thermistor import refusal
from .trot_tuning import trot_complaints

Complaint = tuple[str, object, str]

SYMMETRY_M = 1e-6
SHORTEST_LEG_M = 0.05
LONGEST_LEG_M = 1.0
FARTHEST_FOOT_LU = 1 << 17
HOST_CURRENT_HZ = 400  # at 200 Hz the robot falls in the simulator (caramelo joints compare)
STEP_S = 0.001  # time step of the plane and of the simulated bus
BUSES = {"servo": ("dynamixel", "none"), "bldc": ("can",), "pd": ("none",)}  # allowed for each kind of actuator
CURRENT_LOOP_PER_BANDWIDTH = 20  # at least: with one step of delay, more bandwidth loses the phase margin


def complaints(robot: Robot) -> Iterator[Complaint]:
    """Yield everything that is wrong with a robot, the most basic first."""
    yield from hips_are_symmetric(robot)
    yield from legs_have_a_usable_length(robot)
    yield from masses_are_physical(robot)
    yield from feet_fit_the_integers(robot)
    yield from changes_fit_the_integers(robot)
    yield from gains_fit_the_integers(robot)
    yield from gaits_exist(robot)
    yield from crawl_complaints(robot.crawl, robot.geometry.leg_m)
    yield from trot_complaints(robot.trot)
    yield from poses_are_reachable(robot)
    if isinstance(robot.actuator, Servo):
        yield from servo_is_consistent(robot.actuator)
    elif isinstance(robot.actuator, Bldc):
        yield from joint_is_consistent(robot.actuator)
    yield from bus_suits_the_actuator(robot)
    yield from calf_suits_the_actuator(robot)
    yield from simulators_can_step(robot)


def hips_are_symmetric(robot: Robot) -> Iterator[Complaint]:
    """Left mirrors right and rear mirrors front, with front x > 0 and left y > 0."""
    x_m, y_m = robot.hip_m(LEG_NAMES.index("FL"))
    if x_m <= 0 or y_m <= 0:
        yield "geometry.hips_m.FL", [x_m, y_m], "x and y both above 0: front left of the middle"
        return
    for leg, name in enumerate(LEG_NAMES):
        wanted = (x_m if name[0] == "F" else -x_m, y_m * robot.side(leg))
        found = robot.hip_m(leg)
        if max(abs(found[0] - wanted[0]), abs(found[1] - wanted[1])) > SYMMETRY_M:
            yield f"geometry.hips_m.{name}", list(found), f"{list(wanted)}: the hips must mirror FL = {[x_m, y_m]}"


def legs_have_a_usable_length(robot: Robot) -> Iterator[Complaint]:
    """The leg's length is one that the integer core was tested with."""
    geometry = robot.geometry
    if not SHORTEST_LEG_M <= geometry.leg_m <= LONGEST_LEG_M:
        allowed = f"thigh_m + calf_m within {SHORTEST_LEG_M:g} .. {LONGEST_LEG_M:g} m, not {geometry.leg_m:g}"
        yield "geometry.calf_m", geometry.calf_m, allowed


def masses_are_physical(robot: Robot) -> Iterator[Complaint]:
    """No moment of inertia of a real body exceeds the sum of the other two."""
    for name in ("trunk", *JOINT_NAMES):
        inertia = getattr(robot.links, name).inertia_kg_m2
        if 2 * max(inertia) > sum(inertia) * (1 + 1e-9):
            allowed = "no moment above the sum of the other two (are all in kg m2?)"
            yield f"links.{name}.inertia_kg_m2", list(inertia), allowed


def feet_fit_the_integers(robot: Robot) -> Iterator[Complaint]:
    """Every foot position in the body stays within 17 bits of the core's length unit."""
    unit_m = 2.0**-robot.length_shift
    largest_m = FARTHEST_FOOT_LU * unit_m - robot.geometry.reach_m
    position = robot.hip_m(LEG_NAMES.index("FL"))
    if max(position) > largest_m:
        allowed = f"at most {largest_m:.3g} m each: hip and leg within 2^17 units of 2^-{robot.length_shift} m"
        yield "geometry.hips_m.FL", list(position), allowed


def changes_fit_the_integers(robot: Robot) -> Iterator[Complaint]:
    """Every speed and acceleration is at least one of the core's units per tick, and at most the largest that fits."""
    rate = robot.control.rate_hz
    length = 2.0**robot.length_shift
    speed, body = robot.speed_limits, robot.body_limits
    for key, value, units_per_tick in (
        ("speed_limits.vx_m_s", speed.vx_m_s, 256 * length / rate),
        ("speed_limits.vy_m_s", speed.vy_m_s, 256 * length / rate),
        ("speed_limits.wz_rad_s", speed.wz_rad_s, YAW18 / rate),
        ("speed_limits.vx_m_s2", speed.vx_m_s2, 256 * length / rate**2),
        ("speed_limits.vy_m_s2", speed.vy_m_s2, 256 * length / rate**2),
        ("speed_limits.wz_rad_s2", speed.wz_rad_s2, YAW18 / rate**2),
        ("body_limits.shift_m_s", body.shift_m_s, length / rate),
        ("body_limits.turn_deg_s", body.turn_deg_s, 65536 / 360 / rate),
        ("stand.joint_rad_s", robot.stand.joint_rad_s, BRAD_PER_RAD / rate),
    ):
        low, high = 1 / units_per_tick, LARGEST_SPEED / units_per_tick
        if not low <= value <= high:
            yield key, value, f"{low:.4g} .. {high:.4g} at {rate} Hz: 1 .. {LARGEST_SPEED} of the core's units per tick"


def gains_fit_the_integers(robot: Robot) -> Iterator[Complaint]:
    """The gains of balance, which include the tick's length, fit the core's 15 bits."""
    rate = robot.control.rate_hz
    for key, value, largest in (
        ("balance.ki_1_s", robot.balance.ki_1_s, LARGEST_GAIN * rate / Q16),
        ("balance.kd_s", robot.balance.kd_s, LARGEST_GAIN / rate / Q12),
    ):
        if value > largest:
            yield key, value, f"at most {largest:.3g} at {rate} Hz: more does not fit the core's gain"


def gaits_exist(robot: Robot) -> Iterator[Complaint]:
    """The robot knows the gaits named, and no gait is both advised and not advised."""
    own = robot.gait
    for key, named in (("default", [own.default]), ("advised_m_s", own.advised_m_s), ("not_advised", own.not_advised)):
        for name in named:
            if name not in gait_names(robot):
                yield f"gait.{key}", name, "one of " + ", ".join(gait_names(robot))
    for name in own.advised_m_s:
        if name in own.not_advised:
            yield "gait.advised_m_s", name, "a gait that gait.not_advised does not name"


def poses_are_reachable(robot: Robot) -> Iterator[Complaint]:
    """At rest and sitting, all four feet are within reach and joint limits; sitting is lower."""
    stance = robot.stance
    for key, height_m in (("rest_height_m", stance.rest_height_m), ("sit_height_m", stance.sit_height_m)):
        for leg, name in enumerate(LEG_NAMES):
            reason = why_unreachable(robot, leg, height_m)
            if reason:
                yield f"stance.{key}", height_m, f"{reachable_heights(robot)}: leg {name} {reason}"
                return
    if stance.sit_height_m >= stance.rest_height_m:
        yield "stance.sit_height_m", stance.sit_height_m, f"below rest_height_m = {stance.rest_height_m:g} m"


def why_unreachable(robot: Robot, leg: int, height_m: float) -> str:
    """Return why a standing leg can't have its hip ``height_m`` above its foot, or "" if it can."""
    joints = leg_to_rad(robot, leg, robot.foot_m(leg, height_m))
    if joints is None:
        return "does not reach the ground there"
    for name, angle, (low, high) in zip(JOINT_NAMES, joints, robot.joint_limits_rad(leg), strict=True):
        if not low - 1e-9 <= angle <= high + 1e-9:
            return f"needs its {name} at {degrees(angle):.1f} deg, allowed {degrees(low):g} .. {degrees(high):g} deg"
    return ""


def reachable_heights(robot: Robot) -> str:
    """Return in words the heights at which all four legs can stand, to the millimetre."""
    millimetres = range(1, int(robot.geometry.reach_m * 1000) + 1)
    good = [mm for mm in millimetres if not any(why_unreachable(robot, leg, mm / 1000) for leg in range(4))]
    if not good:
        return "no height is reachable with these links, feet and joint limits"
    return f"within {good[0] / 1000:.3f} .. {good[-1] / 1000:.3f} m"


def servo_is_consistent(servo: Servo) -> Iterator[Complaint]:
    """The supply points rise, with no less torque or speed at more voltage, and one has the nominal voltage."""
    voltages = [point.voltage_V for point in servo.supply]
    if not voltages:
        yield "actuator.supply", [], "at least one [[actuator.supply]] table"
        return
    if any(later <= earlier for earlier, later in pairwise(voltages)):
        yield "actuator.supply", voltages, "tables in order of rising voltage_V"
    elif servo.nominal_voltage_V not in voltages:
        yield "actuator.nominal_voltage_V", servo.nominal_voltage_V, f"one of the supply's voltages {voltages}"
    for key in ("stall_Nm", "no_load_rpm"):
        values = [getattr(point, key) for point in servo.supply]
        if values != sorted(values):
            yield "actuator.supply", values, f"no less {key} at more voltage_V"


def joint_is_consistent(joint: Bldc) -> Iterator[Complaint]:
    """Voltages, temperatures and bandwidths of a brushless joint are in order."""
    drive, heat = joint.drive, joint.thermal
    rate = drive.current_loop_hz
    for key, value, low, high, why in (
        ("drive.under_voltage_V", drive.under_voltage_V, 0.0, drive.bus_voltage_V, "below bus_voltage_V"),
        ("drive.over_voltage_V", drive.over_voltage_V, drive.bus_voltage_V, 1e9, "above bus_voltage_V"),
        ("thermal.winding_derate_C", heat.winding_derate_C, 0.0, heat.winding_cutoff_C, "below winding_cutoff_C"),
        ("thermal.board_derate_C", heat.board_derate_C, 0.0, heat.board_cutoff_C, "below board_cutoff_C"),
        ("drive.position_bandwidth_hz", drive.position_bandwidth_hz, 0.0, drive.velocity_bandwidth_hz,
         "below velocity_bandwidth_hz"),
        ("drive.velocity_bandwidth_hz", drive.velocity_bandwidth_hz, 0.0, drive.current_bandwidth_hz,
         "below current_bandwidth_hz"),
    ):  # fmt: skip
        if not low < value < high:
            yield f"actuator.{key}", value, why
    if why := refusal(joint, Board()):
        yield "actuator.thermal.thermistor_25C_ohm", heat.thermistor_25C_ohm, why
    if drive.current_bandwidth_hz * CURRENT_LOOP_PER_BANDWIDTH > rate:
        allowed = f"at most {rate / CURRENT_LOOP_PER_BANDWIDTH:g} Hz, a twentieth of current_loop_hz"
        yield "actuator.drive.current_bandwidth_hz", drive.current_bandwidth_hz, allowed


def bus_suits_the_actuator(robot: Robot) -> Iterator[Complaint]:
    """Servos need a servo bus or none, brushless joints a CAN bus as fast as the planner, foreign joints none."""
    wanted = BUSES[robot.actuator.kind]
    if robot.bus.kind not in wanted:
        allowed = " or ".join(f'"{kind}"' for kind in wanted)
        yield "bus.kind", robot.bus.kind, f'{allowed} for actuator.kind = "{robot.actuator.kind}"'
    elif robot.bus.kind == "can":
        yield from can_bus_is_usable(robot.bus, robot.control.rate_hz)
    elif isinstance(robot.actuator, Servo) and robot.bus.kind == "dynamixel" and robot.actuator.p_gain == 0:
        yield "actuator.p_gain", 0, "above 0 on a dynamixel bus: with 0 the servo holds nothing"


def calf_suits_the_actuator(robot: Robot) -> Iterator[Complaint]:
    """Brushless joints turn the calf one to one: their boards know only the gear's ratio."""
    if isinstance(robot.actuator, Bldc) and robot.calf_drive.ratio != 1.0:
        yield "calf_drive.ratio", robot.calf_drive.ratio, '1 for actuator.kind = "bldc"; the gear has its own ratio'


def simulators_can_step(robot: Robot) -> Iterator[Complaint]:
    """Within the simulators' step, a drive's damping never reverses the motion that it brakes (sim2d/model.py)."""
    actuator = robot.actuator
    if isinstance(actuator, Bldc):
        return
    volts = [point.voltage_V for point in actuator.supply] if isinstance(actuator, Servo) else [actuator.voltage_V]
    _, thigh, calf = joint_drives(robot)
    for name, link, servo, ratio in (
        ("thigh", robot.links.thigh, thigh, 1.0), ("calf", robot.links.calf, calf, robot.calf_drive.ratio),
    ):  # fmt: skip
        damping = max(servo.at_voltage(voltage_V).damping_Nms_rad for voltage_V in volts)
        least = (least_inertia_kgm2(damping, STEP_S) - link.inertia_kg_m2[1]) * ratio**2
        if actuator.armature_kg_m2 < least:
            why = f"with less, the {name}'s damping overshoots within the simulator's step of {STEP_S:g} s"
            allowed = f"at least {least * 1.005:.3g}: {why}"
            yield "actuator.armature_kg_m2", actuator.armature_kg_m2, allowed


def can_bus_is_usable(bus: CanBus, control_hz: int) -> Iterator[Complaint]:
    """One bus or two, at least as fast as the planner, and fast enough for loops on the host."""
    if len(bus.channels) > 2 or not all(bus.channels):
        yield "bus.channel", bus.channel, "one channel, or two with a comma between: front legs, rear legs"
    if bus.rate_hz < control_hz:
        yield "bus.rate_hz", bus.rate_hz, f"at least control.rate_hz = {control_hz}"
    if bus.loops == "host-current" and bus.rate_hz < HOST_CURRENT_HZ:
        yield "bus.rate_hz", bus.rate_hz, f"at least {HOST_CURRENT_HZ} with host-current: below it the legs oscillate"
