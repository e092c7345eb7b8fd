"""The robots' files load, say their units and sources, and every kind of bad file gives exactly one line."""

import math
import re
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from host.robot.actuators import Bldc, CanBus, Servo
from host.robot.checks import complaints, reachable_heights
from host.robot.file import FOLDER, RobotFileError, driven_names, load_robot, robot_names
from host.robot.kinematics_si import leg_forward, leg_inverse
from host.robot.model import KNEE_CONFIGURATIONS, LEG_NAMES

UNIT_OF_SUFFIX = {
    "m": "m", "deg": "deg", "rad": "rad", "kg": "kg", "s": "s", "hz": "Hz", "V": "V", "A": "A", "W": "W",
    "C": "degrees C", "Nm": "N m", "ohm": "ohm", "H": "H", "K": "K", "g": "g", "rpm": "rpm", "kg_m2": "kg m2",
    "m_s": "m/s", "m_s2": "m/s2", "rad_s": "rad/s", "rad_s2": "rad/s2", "deg_s": "deg/s", "1_s": "1/s",
    "per_rad": "1/rad", "J_K": "J/K", "K_W": "K/W", "Nm_A": "N m/A", "Nm_rad": "N m/rad", "bits": "bits",
    "Nms_rad": "N m s/rad", "1_Nm": "1/(N m)", "N_m": "N/m", "per_g": "counts per g",
    "per_deg_s": "counts per deg/s",
}  # fmt: skip
SOURCES = (
    "paper", "configuration", "urdf", "menagerie", "datasheet", "measured", "simulated", "assumed", "chosen", "derived",
    "derived from the paper",
)  # fmt: skip


def changed(tmp_path: Path, old: str, new: str, robot: str = "caramelo") -> Path:
    """Write a robot's file with one replacement and return its path."""
    text = (FOLDER / f"{robot}.toml").read_text()
    assert old in text
    path = tmp_path / "my.toml"
    path.write_text(text.replace(old, new, 1))
    return path


def refusal(path: Path) -> str:
    """Return the line that refuses a file."""
    with pytest.raises(RobotFileError) as caught:
        load_robot(str(path))
    assert caught.value.exit_code == 2
    line = str(caught.value)
    assert "\n" not in line
    return line


@pytest.mark.parametrize("name", robot_names())
def test_robots_load_and_are_named_like_their_file(name):
    robot = load_robot(name)
    assert robot.name == name
    assert not list(complaints(robot))


def test_the_robots_are_there():
    assert driven_names() == ["caramelo", "parallel"]
    others = ["mini-cheetah", "pupper", "solo12", "spotmicro", "unitree-a1"]
    assert [name for name in robot_names() if name not in driven_names()] == others
    assert isinstance(load_robot("caramelo").actuator, Servo)
    assert isinstance(load_robot("parallel").actuator, Bldc)
    assert isinstance(load_robot("parallel").bus, CanBus)


def unit_complaints(text: str) -> list[str]:
    """Return the lines of a robot file whose comment lacks the key's unit or a source."""
    wrong = []
    for line in text.splitlines():
        if not line.strip() or line.startswith(("#", "[")):
            continue
        match = re.fullmatch(r"([\w-]+) = .+?  +# \[([^]]+)\] .*\(([^()]+)\)", line)
        if match is None or not match[3].endswith(SOURCES):
            wrong.append(line)
            continue
        key, unit = match[1], match[2]
        suffixes = [suffix for suffix in UNIT_OF_SUFFIX if key == suffix or key.endswith("_" + suffix)]
        wanted = UNIT_OF_SUFFIX[max(suffixes, key=len)] if suffixes and key not in LEG_NAMES else None
        if wanted is not None and wanted != unit:
            wrong.append(line)
    return wrong


@pytest.mark.parametrize("name", robot_names())
def test_every_line_of_a_robot_file_has_its_unit_and_source(name):
    assert unit_complaints((FOLDER / f"{name}.toml").read_text()) == []


@pytest.mark.parametrize(
    "line",
    [
        "thigh_m = 0.12",
        "thigh_m = 0.12  # L2 (paper)",
        "thigh_m = 0.12  # [mm] L2 (paper)",
        "thigh_m = 0.12  # [m] L2",
        "kd_s = 0.12  # [1/s] (guess)",
    ],
)
def test_the_check_of_units_and_sources_can_fail(line):
    assert unit_complaints(line) == [line]


def test_mass_and_servo_figures_of_caramelo():
    robot = load_robot("caramelo")
    servo = robot.actuator
    assert isinstance(servo, Servo)
    assert robot.mass_kg == pytest.approx(2.204)
    assert servo.nominal.stall_Nm * servo.duty_per_rad == pytest.approx(12.23, abs=0.01)
    assert servo.nominal.no_load_rad_s == pytest.approx(5.76, abs=0.01)
    assert math.degrees(1 / servo.duty_per_rad) == pytest.approx(11.7, abs=0.05)
    assert reachable_heights(robot).startswith("within 0.109")
    assert robot.length_shift == 17


def test_torque_of_a_parallel_joint():
    joint = load_robot("parallel").actuator
    assert isinstance(joint, Bldc)
    assert joint.torque_limit_Nm == pytest.approx(3.0, rel=0.03)


@pytest.mark.parametrize("name", robot_names())
@pytest.mark.parametrize("knees", KNEE_CONFIGURATIONS)
def test_every_knee_configuration_loads_and_mirrors_its_limits(tmp_path, name, knees):
    own = load_robot(name).geometry.knee_configuration
    robot = load_robot(str(changed(tmp_path, f'"{own}"', f'"{knees}"', name)))
    front, rear = {"full-elbow": (-1, -1), "full-knee": (1, 1), "elbow-knee": (-1, 1), "knee-elbow": (1, -1)}[knees]
    assert [robot.knee_sign(leg) for leg in range(4)] == [front, front, rear, rear]
    for leg in range(4):
        _, thigh, calf = robot.joint_limits_rad(leg)
        expected = [math.radians(a) for a in robot.joint_limits.calf_deg]
        assert list(calf) == (expected if robot.knee_sign(leg) < 0 else [-expected[1], -expected[0]])
        assert (thigh[0] + thigh[1]) * robot.knee_sign(leg) < 0
        foot = robot.foot_m(leg, robot.stance.rest_height_m)
        joints = leg_inverse(robot.geometry.links_m, robot.side(leg), robot.knee_sign(leg), foot)
        knee_x_m = -robot.geometry.thigh_m * math.sin(joints[1])
        assert knee_x_m * robot.knee_sign(leg) > 0  # elbow: behind the hip, knee: in front


def test_right_hips_mirror_left_ones(tmp_path):
    robot = load_robot(str(changed(tmp_path, "hip_deg = [-45, 45]", "hip_deg = [-30, 45]")))
    assert robot.joint_limits_rad(LEG_NAMES.index("FL"))[0] == (math.radians(-30), math.radians(45))
    assert robot.joint_limits_rad(LEG_NAMES.index("FR"))[0] == (math.radians(-45), math.radians(30))


def test_a_robot_does_not_change():
    robot = load_robot("caramelo")
    with pytest.raises(ValueError, match="frozen"):
        robot.balance.kp = 1.0


@settings(max_examples=200)
@given(
    side=st.sampled_from((-1, 1)),
    knee=st.sampled_from((-1, 1)),
    hip=st.floats(-1.2, 1.2),
    thigh=st.floats(-0.7, 0.7),
    bend=st.floats(0.1, 2.4),
)
def test_float_leg_inverse_finds_the_foot_again(side, knee, hip, thigh, bend):
    links = (0.048, 0.12, 0.13)
    joints = (hip, thigh - knee * bend / 2, knee * bend)
    foot = leg_forward(links, side, joints)
    assert leg_inverse(links, side, knee, foot) == pytest.approx(joints, abs=1e-9)


def test_float_leg_inverse_says_when_there_is_none():
    assert leg_inverse((0.05, 0.1, 0.1), 1, -1, (0.0, 0.05, -0.21)) is None
    assert leg_inverse((0.05, 0.1, 0.12), 1, -1, (0.0, 0.05, -0.01)) is None
    assert leg_inverse((0.05, 0.1, 0.1), 1, -1, (0.1, 0.01, -0.01)) is None


BAD_VALUES = [
    # old text, new text, key as it must appear, words that must appear
    ("thigh_m = 0.120", "thigh_m = -0.120", "geometry.thigh_m: value -0.12:", "0.01 .. 1 m"),
    ("thigh_m = 0.120", "thigh_m = nan", "geometry.thigh_m: value nan:", "0.01 .. 1 m"),
    ("thigh_m = 0.120", "thigh_m = inf", "geometry.thigh_m: value inf:", "0.01 .. 1 m"),
    ("thigh_m = 0.120", 'thigh_m = "0.120"', 'geometry.thigh_m: value "0.120":', "a number"),
    ("thigh_m = 0.120", "thigh_m = true", "geometry.thigh_m: value true:", "a number"),
    ("thigh_m = 0.120", "", "geometry.thigh_m: value missing:", "must be there"),
    ("thigh_m = 0.120", "thigh_mm = 120", "geometry.thigh_mm: value 120:", "did you mean thigh_m?"),
    ("[geometry]", "[geometry]\nthigh_mm = 120", "geometry.thigh_mm: value 120:", "did you mean thigh_m?"),
    ("[geometry]", "colour = 'brown'\n[geometry]", 'colour: value "brown":', "unknown key"),
    ("p_gain = 850", "p_gian = 850\np_gain = 850", "actuator.p_gian: value 850:", "did you mean p_gain?"),
    ("stall_Nm = 2.3", "stall = 1\nstall_Nm = 2.3", "actuator.supply.0.stall: value 1:", "did you mean stall_Nm?"),
    ("p_gain = 850", "p_gain = 850.5", "actuator.p_gain: value 850.5:", "a whole number within 0 .. 16383"),
    ("mass_kg = 1.284", "mass_kg = -1.284", "links.trunk.mass_kg: value -1.284:", "0.001 .. 100 kg"),
    ("mass_kg = 0.035", "mass_kg = 0", "links.calf.mass_kg: value 0:", "0.001 .. 100 kg"),
    ("com_m = [0.0015, 0.0, 0.003]", "com_m = [0.0015, 0.0]", "links.trunk.com_m: value [0.0015, 0.0]:", "3 numbers"),
    ("7.19e-3]", "9e-3]", "links.trunk.inertia_kg_m2: value [0.00327, 0.0046, 0.009]:", "sum of the other two"),
    ("FR = [0.11455, -0.070]", "FR = [0.11455, -0.060]", "geometry.hips_m.FR: value [0.11455, -0.06]:", "mirror FL"),
    ("RL = [-0.11455,", "RL = [-0.2,", "geometry.hips_m.RL: value [-0.2, 0.07]:", "mirror FL"),
    ("FL = [0.11455,", "FL = [-0.11455,", "geometry.hips_m.FL: value [-0.11455, 0.07]:", "front left"),
    ("calf_m = 0.120", "calf_m = 0.950", "geometry.calf_m: value 0.95:", "0.05 .. 1 m"),
    ("thigh_m = 0.120", "thigh_m = 0.065", "stance.rest_height_m: value 0.17:", "needs its"),
    ("rest_height_m = 0.170", "rest_height_m = 0.5", "stance.rest_height_m: value 0.5:", "0.109 .. 0.213 m"),
    ("sit_height_m = 0.115", "sit_height_m = 0.09", "stance.sit_height_m: value 0.09:", "calf at -136.0 deg"),
    ("sit_height_m = 0.115", "sit_height_m = 0.18", "stance.sit_height_m: value 0.18:", "below rest_height_m"),
    ("foot_forward_m = 0.0", "foot_forward_m = 0.4", "stance.rest_height_m: value 0.17:", "no height is reachable"),
    ("thigh_deg = [-15, 105]", "thigh_deg = [105, -15]", "joint_limits.thigh_deg: value [105, -15]:", "lowest <"),
    ("calf_deg = [-126, -54]", "calf_deg = [-126, 54]", "joint_limits.calf_deg: value [-126, 54]:", "-175 .. 0 deg"),
    ('"full-elbow"', '"full-elbows"', 'geometry.knee_configuration: value "full-elbows":', '"elbow-knee"'),
    ("rate_hz = 50 ", "rate_hz = 10 ", "control.rate_hz: value 10:", "20 .. 500 Hz"),
    ("wz_rad_s2 = 2.0", "wz_rad_s2 = 0.001", "speed_limits.wz_rad_s2: value 0.001:", "0.009537 .. 5000 at 50 Hz"),
    ("vx_m_s = 0.30", "vx_m_s = 1.0", "speed_limits.vx_m_s: value 1.0:", "1.49e-06 .. 0.7812 at 50 Hz"),
    ("ki_1_s = 7.5", "ki_1_s = 60", "balance.ki_1_s: value 60.0:", "at most 25 at 50 Hz"),
    ("kd_s = 0.006", "kd_s = 0.3", "balance.kd_s: value 0.3:", "at most 0.16 at 50 Hz"),
    ("nominal_voltage_V = 12.0", "nominal_voltage_V = 13", "actuator.nominal_voltage_V: value 13.0:", "11.1, 12.0,"),
    ("voltage_V = 14.8", "voltage_V = 11.8", "actuator.supply: value [11.1, 12.0, 11.8]:", "rising"),
    ("stall_Nm = 2.5 ", "stall_Nm = 2.0 ", "actuator.supply: value [2.3, 2.0, 3.1]:", "no less stall_Nm"),
    ('kind = "servo"', 'kind = "stepper"', 'actuator.kind: value "stepper":', '"servo", "bldc", "pd"'),
    ('kind = "servo"', "# no kind", "actuator.kind: value missing:", '"servo", "bldc", "pd"'),
    ("p_gain = 850", "p_gain = 0", "actuator.p_gain: value 0:", "above 0 on a dynamixel bus"),
    ("baud = 4000000", "baud = 4000001", "bus.baud: value 4000001:", "4000000"),
    ('axes = ["+x", "+y", "+z"]', 'axes = ["+x", "+y", "-z"]', "imu.axes: value ['+x', '+y', '-z']:", "right-handed"),
    ('name = "caramelo" ', 'name = "My Robot" ', 'name: value "My Robot":', "lower-case"),
    ('default = "trot"', 'default = "gallop"', 'gait.default: value "gallop":', "one of paper-trot, trot, crawl"),
    ('default = "trot"', 'default = "Trot!"', 'gait.default: value "Trot!":', "a gait's name"),
    ("crawl = 0.019", "crawls = 0.008", 'gait.advised_m_s: value "crawls":', "one of paper-trot, trot, crawl"),
    ("crawl = 0.019", "crawl = -0.008", "gait.advised_m_s.crawl: value -0.008:", "0.001 .. 3 m/s"),
    ("crawl = 0.019", "paper-trot = 0.008", 'gait.advised_m_s: value "paper-trot":', "gait.not_advised does not name"),
    ("\npaper-trot = ", '\ngallop = "fast" #', 'gait.not_advised: value "gallop":', "one of paper-trot, trot, crawl"),
    ("\npaper-trot = ", '\npaper-trot = "two\\nlines" #', 'gait.not_advised.paper-trot: value "two', "one line"),
    ("\npaper-trot = ", '\npaper-trot = "\\u001b[31m" #', "gait.not_advised.paper-trot: value", "one line"),
    ('default = "trot"', 'default = "adaptive"', "gait.default:", "gait 'adaptive' is now called 'trot'"),
    ("crawl = 0.019", "climb = 0.008", "gait.advised_m_s:", "gait 'climb' is now called 'crawl'"),
    ("\n[imu]", "\n[climb]\nmargin_m = 0.03\n[imu]", "table climb:", "gait 'climb' is now called 'crawl'"),
    ("\n[imu]", "\n[crawl]\nmargn_m = 0.03\n[imu]", "crawl.margn_m: value 0.03:", "did you mean margin_m?"),
    ("\n[imu]", "\n[crawl]\nmargin_m = 0.3\n[imu]", "crawl.margin_m: value 0.3:", "0.007 .. 0.056"),
    ("\n[imu]", "\n[crawl]\nsettle_s = true\n[imu]", "crawl.settle_s: value true:", "a number within"),
    ("\n[imu]", "\n[crawl]\ngoal_lag_s = 0.07\n[imu]", "crawl.goal_lag_s: value 0.07:", "0.015 .. 0.062"),
    ("\n[imu]", "\n[trot]\nlift = 0.1\n[imu]", "trot.lift: value 0.1:", "the keys are low_lift, high_lift,"),
    ("\n[imu]", "\n[trot]\nlow_lift = 0.3\n[imu]", "trot.low_lift: value 0.3:", "0.03 .. 0.25, usually 0.08"),
    ("crawl = 0.019", '"Crawl!" = 0.008', 'gait.advised_m_s.Crawl!: value "Crawl!":', "a gait's name"),
]

BAD_JOINTS = [
    ("thigh_encoder = false", "thigh_encoder = 0", "actuator.gear.thigh_encoder: value 0:", "true, false"),
    ("current_bandwidth_hz = 450", "current_bandwidth_hz = 600", "actuator.drive.current_bandwidth_hz: value 600.0:",
     "at most 500 Hz"),
    ("velocity_bandwidth_hz = 30", "velocity_bandwidth_hz = 460", "actuator.drive.velocity_bandwidth_hz: value 460.0:",
     "below current_bandwidth_hz"),
    ("under_voltage_V = 18.0", "under_voltage_V = 25", "actuator.drive.under_voltage_V: value 25.0:", "below bus"),
    ("winding_derate_C = 80", "winding_derate_C = 120", "actuator.thermal.winding_derate_C: value 120.0:", "below"),
    ("thermistor_25C_ohm = 1000", "thermistor_25C_ohm = 100000", "actuator.thermal.thermistor_25C_ohm: value 100000.0:",
     "220 .. 22000 ohm"),
    ("resistance_ohm = 1.2", "resistance_ohm = 0", "actuator.motor.resistance_ohm: value 0:", "0.005 .. 50 ohm"),
    ("amplifier_gain = 40", "amplifier_gain = 30", "actuator.drive.amplifier_gain: value 30:", "40"),
    ("rate_hz = 200", "rate_hz = 40", "bus.rate_hz: value 40:", "at least control.rate_hz = 50"),
    ("[actuator.gear] ", "[actuator.gears] ", "actuator.gears: value {", "did you mean gear?"),
]  # fmt: skip

BAD_OTHERS = [
    ("no_load_rad_s = 21.0", "no_load_rad_s = 0", "actuator.no_load_rad_s: value 0:", "0.1 .. 200 rad/s"),
    ("stiffness_Nm_rad = 100.0", "stifness_Nm_rad = 100.0", "actuator.stifness_Nm_rad: value 100.0:", "did you mean"),
    ("armature_kg_m2 = 0.01", "armature_kg_m2 = 1e-4", "actuator.armature_kg_m2: value 0.0001:", "overshoots"),
    ('kind = "none"', 'kind = "can"', "bus.interface: value missing:", "must be there"),
]


@pytest.mark.parametrize(
    ("robot", "old", "new", "start", "words"),
    [("caramelo", *bad) for bad in BAD_VALUES]
    + [("parallel", *bad) for bad in BAD_JOINTS]
    + [("unitree-a1", *bad) for bad in BAD_OTHERS],
)
def test_a_bad_value_is_refused_in_one_line(tmp_path, robot, old, new, start, words):
    path = changed(tmp_path, old, new, robot)
    line = refusal(path)
    assert line.startswith(f"{path}: {start}")
    assert words in line


def test_hips_too_far_out_for_the_integers(tmp_path):
    text = (FOLDER / "caramelo.toml").read_text().replace("0.11455", "1.9")
    path = tmp_path / "long.toml"
    path.write_text(text)
    assert f"{path}: geometry.hips_m.FL: value [1.9, 0.07]: allowed: at most 0.755 m each" in refusal(path)


def test_servos_do_not_hang_on_can(tmp_path):
    text = (FOLDER / "caramelo.toml").read_text()
    can = (FOLDER / "parallel.toml").read_text()
    start, end = "[bus]", "[control]"
    text = text[: text.index(start)] + can[can.index(start) : can.index(end)] + text[text.index(end) :]
    path = tmp_path / "mixed.toml"
    path.write_text(text)
    assert refusal(path) == f'{path}: bus.kind: value "can": allowed: "dynamixel" or "none" for actuator.kind = "servo"'


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"thigh_m = 0,12", "line 1, column"),
        (b"[a]\nb = 1\nb = 2\n", "given twice"),
        (b"[a]\nb = 1\n[a]\nc = 2\n", "given twice"),
        (b"name = 'x", "end of document"),
        (b"a = " + b"[" * 5000 + b"]" * 5000, "allowed: TOML as in"),
        (b"a = " + b"9" * 5000, "allowed: TOML as in"),
        (b"[geometry]\nthigh_m = " + b"9" * 400, "geometry.thigh_m: value 999"),
        (b"name = '\xff'", "is not UTF-8"),
        (b"", "name: value missing"),
        (b"geometry = 3", "geometry: value 3: allowed: a table"),
    ],
)
def test_what_is_not_a_robot_file_is_refused_in_one_line(tmp_path, content, words):
    path = tmp_path / "bad.toml"
    path.write_bytes(content)
    line = refusal(path)
    assert line.startswith(f"{path}: ")
    assert words in line


@pytest.mark.parametrize(
    ("table", "value"), [("geometry", "3"), ("actuator", '"servo"'), ("links", "[1]"), ("bus", "{}")]
)
def test_a_value_where_a_table_belongs(tmp_path, table, value):
    text = (FOLDER / "caramelo.toml").read_text()
    pattern = rf"(?ms)^\[\[?{table}[.\]].*?(?=^\[(?!\[?{table}[.\]])|\Z)"
    assert re.search(pattern, text)
    path = tmp_path / "bad.toml"
    path.write_text(f"{table} = {value}\n" + re.sub(pattern, "", text))
    assert refusal(path).startswith(f"{path}: {table}")


def test_a_file_that_is_not_there_lists_the_known_robots(tmp_path):
    path = tmp_path / "none.toml"
    assert refusal(path) == f"{path}: no such file; robots known by name are {', '.join(robot_names())}"


def test_a_folder_is_not_a_file(tmp_path):
    path = tmp_path / "folder.toml"
    path.mkdir()
    assert "can't be read: Is a directory" in refusal(path)


def test_an_unknown_name_is_answered_with_the_nearest():
    assert refusal(Path("caramello")) == (
        f'robot "caramello": unknown, did you mean caramelo?: allowed: {", ".join(robot_names())}, '
        "or the path of a file ending in .toml"
    )
