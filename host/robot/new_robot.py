"""Writes a new robot's file: puts a person's answers into the text of a known robot with the same kind of joints.

The file's own validators check the answers. Values that follow from the answers are derived here. All others stay as
in the known robot's file, with comments and units, and the end of each such line says so.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from math import floor, hypot, inf
from typing import Annotated, Any, get_type_hints

from pydantic import TypeAdapter, ValidationError

from ..util.errors import UserError
from ..util.files import parse_toml, read_text
from .ability import FLAT_FROUDE, ability
from .actuators import Servo, SupplyPoint
from .file import checked, explain, find, load_robot, robot_names
from .model import CalfDrive, Geometry, Mass, PositiveLength, Robot
from .scale import most_sag_compensation
from .toml_text import Change, Changes, changed, shown
from .trot_tuning import GAIT, SIDE_SHARE, TURN_SHARE
from .values import Table, number, one_of

Answer = str | float
Answers = Mapping[str, Answer]

OTHER, DONOR = "other", "spotmicro"  # servos that no known robot has, and the robot whose file serves as their template
REST_SHARE, SIT_SHARE = 0.7, 0.48  # of the leg: hip above foot (Caramelo: 0.71 and 0.48)
ROD_RADIUS_M, SERVO_M = 0.012, 0.04  # of a link as a uniform rod, for its inertia along it; a servo's edge
TRUNK_BEYOND_M, TRUNK_HEIGHT_M = 0.06, 0.07  # the trunk's box: longer than from hip to hip, and its height
TRIED = {"gait.advised_m_s", "gait.not_advised", "crawl", "trot"}  # tables of what was tried on the other robot
NOT_TOGETHER = "these answers do not go together"
# Caramelo's, for servos that nobody has measured: dry friction per stall torque, and the rotor's inertia per damping,
# which is the time constant of the servo alone.
COULOMB_SHARE, ROTOR_S = 0.06 / 2.5, 0.0032 / (2.5 / 5.76)


def joints_like() -> dict[str, str]:
    """Return the possible answers to the question about the joints, each with its description."""
    robots = [load_robot(name) for name in robot_names()]
    # Foreign joints are left out: their stiffness was chosen for their robot, and they can't be driven.
    known = {each.name: each.description.partition(";")[0] for each in robots if each.actuator.kind != "pd"}
    known[OTHER] = "servos of another type: simulated only; on a bus, this software drives the MX-28(2.0)"
    return known


@dataclass(frozen=True)
class Question:
    """``name`` is the option and the key of its answer; ``allowed`` is the type with which pydantic checks it.

    ``usual``: the default, or how it follows from earlier answers.
    """

    name: str
    text: str
    usual: Answer | Callable[[Answers], Answer]
    allowed: Any
    asked: Callable[[Answers], bool] = lambda answers: True

    def default(self, answers: Answers) -> Answer:
        """Return what to offer after these answers."""
        return self.usual(answers) if callable(self.usual) else self.usual

    def check(self, value: object) -> Answer:
        """Return the answer if the file may hold it, as a number if one is wanted; UserError if not."""
        wanted = number_of(value) if isinstance(value, str) and not isinstance(self.default({}), str) else value
        try:
            answer: Answer = TypeAdapter(self.allowed).validate_python(wanted)
        except ValidationError as error:
            sentence = explain({**error.errors()[0], "loc": (self.name,)}, {})
            raise UserError(sentence + self._hint(wanted)) from None
        return answer

    def _hint(self, value: object) -> str:
        """Return the answer converted from millimetres or grams, if it may have been given in them."""
        if not isinstance(value, float) or isinstance(self.default({}), str):
            return ""
        try:
            return f" ({value:g} mm or g are {self.check(value / 1000):g})" if 1 < value < inf else ""
        except UserError:
            return ""


def number_of(text: str) -> object:
    """Return a text as a number if it is one, else as it is."""
    try:
        return float(text)
    except ValueError:
        return text


def _rest_height(answers: Answers) -> float:
    return round(REST_SHARE * (_number(answers, "thigh", 0.12) + _number(answers, "calf", 0.12)), 3)


def _is_unknown(answers: Answers) -> bool:
    return answers.get("joints") == OTHER


def _number(answers: Answers, name: str, otherwise: float | None = None) -> float:
    value = answers[name] if otherwise is None else answers.get(name, otherwise)
    assert isinstance(value, float)
    return value


def _as_in(table: type[Table], key: str) -> Any:
    """Return the type of a key of the robot file."""
    return get_type_hints(table, include_extras=True)[key]


@cache
def questions() -> tuple[Question, ...]:
    """Return the questions in their order; made only once, because it reads every known robot.

    Defaults are Caramelo's, or follow from earlier answers.
    """
    like = Annotated[str, one_of(*joints_like())]
    return (
        Question("name", "name of the robot", "mine", _as_in(Robot, "name")),
        Question("front_rear", "from front to rear hip axes, m", 0.229, Annotated[float, number(0.04, 3.0, "m")]),
        Question("left_right", "from left to right hip axes, m", 0.14, Annotated[float, number(0.02, 3.0, "m")]),
        Question("hip_offset", "hip axis to the plane of the leg, m", 0.048, _as_in(Geometry, "hip_offset_m")),
        Question("thigh", "thigh joint to knee, m", 0.12, PositiveLength),
        Question("calf", "knee to the middle of the foot, m", 0.12, PositiveLength),
        Question("foot_radius", "radius of the round foot, m", 0.012, _as_in(Geometry, "foot_radius_m")),
        Question("knees", "knees: full-elbow (all behind the hips), full-knee, elbow-knee, knee-elbow", "full-elbow",
                 _as_in(Geometry, "knee_configuration")),
        Question("height", "hip axis above the foot when it stands, m", _rest_height, PositiveLength),
        Question("trunk_mass", "body without legs, with hip motors and battery, kg", 1.284, Mass),
        Question("hip_mass", "one hip, between hip axis and thigh joint, kg", 0.077, Mass),
        Question("thigh_mass", "one thigh, kg", 0.118, Mass),
        Question("calf_mass", "one calf with its foot, kg", 0.035, Mass),
        Question("calf_motor", "calf motor on the thigh, or on the body with a rod", "thigh",
                 _as_in(CalfDrive, "motor_on")),
        Question("joints", "joints like those of which robot", "caramelo", like),
        Question("model", "the servo's name", "my servo", _as_in(Servo, "model"), _is_unknown),
        Question("volts", "its supply voltage, V", 12.0, _as_in(SupplyPoint, "voltage_V"), _is_unknown),
        Question("stall", "its stall torque at that supply, N m", 2.5, _as_in(SupplyPoint, "stall_Nm"), _is_unknown),
        Question("rpm", "its speed without load at that supply, rpm", 55.0, _as_in(SupplyPoint, "no_load_rpm"),
                 _is_unknown),
    )  # fmt: skip


def new_file(answers: Answers) -> str:
    """Return the text of the robot file; UserError if the answers do not go together."""
    donor = DONOR if answers["joints"] == OTHER else str(answers["joints"])
    changes = {"gait.default": Change(shown(GAIT), "chosen"), "gait.sag_compensation": Change("0.0", "chosen")}
    for part in (_names, _geometry, _lengths, _masses, _drives):
        changes |= part(answers)
    of_donor, header = read_text(find(donor)), HEADER.format(**answers, donor=donor)
    robot = checked(parse_toml(changed(of_donor, changes, TRIED, donor, header)), NOT_TOGETHER)
    text = changed(of_donor, {**changes, **_speeds(robot), **_sag(robot)}, TRIED, donor, header)
    checked(parse_toml(text), NOT_TOGETHER)
    return text


def _geometry(answers: Answers) -> Changes:
    """Return the lengths that the answers give."""
    x_m, y_m = _number(answers, "front_rear") / 2, _number(answers, "left_right") / 2
    changes = {
        f"geometry.hips_m.{name}": Change(shown([x * x_m, y * y_m]), "yours")
        for name, x, y in (("FR", 1, -1), ("FL", 1, 1), ("RR", -1, -1), ("RL", -1, 1))
    }
    for key in ("hip_offset", "thigh", "calf", "foot_radius"):
        changes[f"geometry.{key}_m"] = Change(shown(answers[key]), "yours")
    changes["geometry.knee_configuration"] = Change(shown(answers["knees"]), "yours")
    changes["stance.rest_height_m"] = Change(shown(answers["height"]), "yours")
    return changes


def _lengths(answers: Answers) -> Changes:
    """Return the values that follow from the legs' length; shares are Caramelo's."""
    leg_m = _number(answers, "thigh") + _number(answers, "calf")
    size_m = [_number(answers, "front_rear") + TRUNK_BEYOND_M, _number(answers, "left_right"), TRUNK_HEIGHT_M]
    return {
        "stance.sit_height_m": Change(shown(SIT_SHARE * leg_m), "derived"),
        "stance.foot_forward_m": Change("0.0", "chosen"),
        "stance.foot_outward_m": Change("0.0", "chosen"),
        "joint_limits.hip_deg": Change("[-45, 45]", "assumed"),
        "joint_limits.thigh_deg": Change("[-30, 110]", "assumed", "pitch"),
        "joint_limits.calf_deg": Change("[-145, -30]", "assumed", "pitch"),
        "links.trunk.size_m": Change(shown(size_m), "derived"),
        **{f"body_limits.{axis}_m": Change(shown(leg_m / 6), "derived") for axis in "xyz"},
        "speed_limits.stride_m": Change(shown(leg_m / 2), "derived"),
    }


def _masses(answers: Answers) -> Changes:
    """Return the masses, with the inertias of a uniform box, a cube of a servo's size and uniform rods."""
    length_m, width_m = _number(answers, "front_rear") + TRUNK_BEYOND_M, _number(answers, "left_right")
    thigh_m, calf_m = _number(answers, "thigh"), _number(answers, "calf")
    changes: dict[str, Change] = {}
    for name, shape, com_z_m, inertia in (
        ("trunk", "a uniform box", 0.0, _box(length_m, width_m, TRUNK_HEIGHT_M)),
        ("hip", "a cube of a servo's size", 0.0, _box(SERVO_M, SERVO_M, SERVO_M)),
        ("thigh", "a uniform rod", -thigh_m / 2, _rod(thigh_m)),
        ("calf", "a uniform rod", -calf_m / 2, _rod(calf_m)),
    ):
        mass_kg = _number(answers, f"{name}_mass")
        meaning = f"about the centre of mass, x y z: {shape}"
        changes[f"links.{name}.mass_kg"] = Change(shown(mass_kg), "yours")
        changes[f"links.{name}.inertia_kg_m2"] = Change(shown([mass_kg * each for each in inertia]), "derived", meaning)
        changes[f"links.{name}.com_m"] = Change(shown([0.0, 0.0, com_z_m]), "assumed")
    return changes


def _names(answers: Answers) -> Changes:
    parts = [_number(answers, f"{name}_mass") for name in ("trunk", "hip", "thigh", "calf")]
    joints = answers.get("model") or f"as {answers['joints']}"
    text = f"{parts[0] + 4 * sum(parts[1:]):.2g} kg, joints: {joints}"
    return {"name": Change(shown(answers["name"]), "yours"), "description": Change(shown(text), "derived")}


def _box(x_m: float, y_m: float, z_m: float) -> list[float]:
    """Return the moments of a box per mass, m2."""
    squares = x_m**2, y_m**2, z_m**2
    return [(sum(squares) - squares[axis]) / 12 for axis in range(3)]


def _rod(length_m: float) -> list[float]:
    """Return the moments of an upright rod per mass, m2."""
    across = (3 * ROD_RADIUS_M**2 + length_m**2) / 12
    return [across, across, ROD_RADIUS_M**2 / 2]


def _drives(answers: Answers) -> Changes:
    """Return where the calf's motor is, and the servo if no known robot has it."""
    meaning = "thigh: the motor sets the knee's angle; body: thigh + calf"
    changes = {"calf_drive.motor_on": Change(shown(answers["calf_motor"]), "yours", meaning)}
    if answers["joints"] != OTHER:
        return changes
    stall_Nm, rpm, volts = (_number(answers, name) for name in ("stall", "rpm", "volts"))
    damping = stall_Nm / SupplyPoint(voltage_V=volts, stall_Nm=stall_Nm, no_load_rpm=rpm).no_load_rad_s
    return changes | {
        "calf_drive.ratio": Change("1.0", "assumed", "calf angle per motor angle"),
        "actuator.model": Change(shown(answers["model"]), "yours"),
        "actuator.armature_kg_m2": Change(shown(ROTOR_S * damping), "assumed"),
        "actuator.coulomb_Nm": Change(shown(COULOMB_SHARE * stall_Nm), "assumed"),
        "actuator.nominal_voltage_V": Change(shown(volts), "yours"),
        "actuator.low_voltage_V": Change(shown(0.85 * volts), "assumed"),
        "actuator.supply.voltage_V": Change(shown(volts), "yours"),
        "actuator.supply.stall_Nm": Change(shown(stall_Nm), "yours"),
        "actuator.supply.no_load_rpm": Change(shown(rpm), "yours"),
    }


def _speeds(robot: Robot) -> Changes:
    """Return the speed limits: the speed that every robot should walk on level ground, or less if its legs can't."""
    x_m, y_m = robot.hip_m(1)
    vx_m_s = max(0.01, floor(100 * ability(robot).flat_m_s) / 100)
    turn_rad_s = TURN_SHARE * vx_m_s / hypot(x_m, y_m + robot.geometry.hip_offset_m)
    meaning = f"forward and backward: {FLAT_FROUDE:g} of sqrt g h, or what its legs can"
    return {
        "speed_limits.vx_m_s": Change(shown(vx_m_s), "derived", meaning),
        "speed_limits.vy_m_s": Change(shown(SIDE_SHARE * vx_m_s), "derived"),
        "speed_limits.wz_rad_s": Change(shown(turn_rad_s), "derived"),
    }


def _sag(robot: Robot) -> Changes:
    """Return how much of the joints' sag is fed forward: all of it, or what the core can hold if they are too soft."""
    most = floor(100 * most_sag_compensation(robot)) / 100
    return {"gait.sag_compensation": Change("1.0", "chosen") if most >= 1 else Change(shown(most), "derived")}


HEADER = """\
# {name}: made by caramelo robots new from your answers and from the file of {donor}, whose joints are like yours.
#
# Frame: x forward, y left, z up. Legs FR, FL, RR, RL. An angle of 0 is a leg straight down; thigh > 0 puts the
# knee behind the hip, calf < 0 is an elbow. After each value: [unit] meaning (source). Sources: yours (your answer),
# derived (follows from your answers), assumed (measure it), as {donor} (copied), datasheet, chosen (yours to tune).
# Before your own robot moves, measure joint_limits: where its links touch. Gaits are advised once they were tried.
# docs/robot-files.md explains every table. Try a change with: caramelo robots check FILE
"""


def unanswered(answers: Answers) -> Iterator[Question]:
    """Yield the open questions one by one, taking into account the answers given meanwhile."""
    for question in questions():
        if question.name not in answers and question.asked(answers):
            yield question
