"""`caramelo robots new`: what it asks, what it refuses, and that what it writes passes the check and walks."""

import io
import json

import pytest

from host.robot.actuators import Servo
from host.robot.file import load_robot
from host.robot.new_robot import DONOR, OTHER, joints_like, questions
from host.robot.toml_text import Change, changed
from host.sim.walk import WalkSpec, run_walk
from sim2d import metrics

from . import test_robot_file

BIG = {
    "name": "big", "front-rear": 0.4, "left-right": 0.2, "hip-offset": 0.06, "thigh": 0.18, "calf": 0.2,
    "foot-radius": 0.02, "knees": "full-knee", "height": 0.27, "trunk-mass": 2.5, "hip-mass": 0.15, "thigh-mass": 0.25,
    "calf-mass": 0.1, "calf-motor": "body", "joints": "other", "model": "XM540-W270", "volts": 12, "stall": 10.6,
    "rpm": 30,
}  # fmt: skip


def options(answers):
    """Return answers as command line options."""
    return [word for name, value in answers.items() for word in (f"--{name}", str(value))]


@pytest.fixture
def new(run, monkeypatch, tmp_path):
    """Run the command with options and with what a person types; return exit code, stdout, stderr and the file."""

    def call(*arguments, typed=()):
        monkeypatch.setattr("sys.stdin", io.StringIO("".join(f"{line}\n" for line in typed)))
        path = tmp_path / "new.toml"
        return *run("robots", "new", str(path), *arguments), path

    return call


@pytest.mark.parametrize("joints", joints_like())
def test_what_it_writes_passes_the_check_and_walks(new, joints):
    """The joints bring their bus."""
    code, out, err, path = new("--joints", joints, "--defaults")
    assert (code, err) == (0, "")
    assert f"wrote {path}" in out.replace("\n", "")
    robot, donor = load_robot(str(path)), load_robot(DONOR if joints == OTHER else joints)
    assert (robot.actuator.kind, robot.bus) == (donor.actuator.kind, donor.bus)
    walk = run_walk(WalkSpec(robot, robot.gait.default, speed_m_s=0.1, distance_m=0.5))
    assert walk.outcome.kind == "arrived"
    assert metrics.mean_speed_m_s(walk) > 0.07


def test_every_answer_is_in_the_file(new):
    code, out, _, path = new(*options(BIG), "--json")
    assert code == 0
    assert json.loads(out)["ok"]
    robot = load_robot(str(path))
    assert robot.name == "big"
    assert robot.hip_m(1) == (0.2, 0.1)
    assert robot.geometry.links_m == (0.06, 0.18, 0.2)
    assert robot.geometry.foot_radius_m == 0.02
    assert robot.geometry.knee_configuration == "full-knee"
    assert robot.stance.rest_height_m == 0.27
    assert robot.mass_kg == pytest.approx(2.5 + 4 * 0.5)
    assert robot.calf_drive.motor_on == "body"
    assert isinstance(robot.actuator, Servo)
    assert robot.actuator.model == "XM540-W270"
    assert [(p.voltage_V, p.stall_Nm, p.no_load_rpm) for p in robot.actuator.supply] == [(12, 10.6, 30)]
    assert robot.bus.kind == "none"
    assert robot.gait.advised_m_s == {}  # nothing has been tried


def test_the_options_are_the_questions():
    assert {name.replace("-", "_") for name in BIG} == {question.name for question in questions()}


@pytest.mark.parametrize("joints", joints_like())
def test_every_line_has_its_unit_and_source(new, monkeypatch, joints):
    path = new("--joints", joints, "--defaults")[-1]
    own = ("yours", "derived", "assumed", "chosen", "datasheet", *(f"as {name}" for name in joints_like()))
    own += tuple(f"derived for {name}" for name in joints_like())
    monkeypatch.setattr(test_robot_file, "SOURCES", own)
    text = path.read_text()
    assert test_robot_file.unit_complaints(text) == []
    assert "(paper)" not in text  # of the other robot


def test_it_asks_and_asks_again(new):
    typed = ["Big Dog", "dog", "", "", "", "120", "much", "0.15"]
    code, _, err, path = new(typed=[*typed, *[""] * 20])
    assert code == 0
    told = [line for line in err.splitlines() if "allowed" in line]
    assert len(told) == 3
    assert 'name: value "Big Dog": allowed: lower-case' in told[0]
    assert told[1].endswith("thigh: value 120.0: allowed: a number within 0.01 .. 1 m (120 mm or g are 0.12)")
    assert told[2].endswith('thigh: value "much": allowed: a number within 0.01 .. 1 m')
    robot = load_robot(str(path))
    assert robot.name == "dog"
    assert robot.geometry.thigh_m == 0.15
    assert robot.stance.rest_height_m == pytest.approx(0.7 * 0.27)


def test_only_what_is_missing_is_asked(new):
    given = {name: value for name, value in BIG.items() if name != "rpm"}
    code, _, err, path = new(*options(given), typed=["40"])
    assert (code, err.strip()) == (0, "its speed without load at that supply, rpm [55.0]:")
    actuator = load_robot(str(path)).actuator
    assert isinstance(actuator, Servo)
    assert actuator.nominal.no_load_rpm == 40


def test_answers_that_do_not_go_together_are_told_and_asked_again_with_what_was_said(new):
    height = next(at for at, each in enumerate(questions()) if each.name == "height")
    first = ["dog", *[""] * (height - 1), "0.3", *[""] * 6]
    code, _, err, path = new(typed=[*first, *[""] * height, "0.17", *[""] * 6])
    assert code == 0
    told = [line for line in err.splitlines() if "caramelo: " in line]
    assert len(told) == 1
    assert "do not go together: stance.rest_height_m: value 0.3: allowed: within" in told[0]
    robot = load_robot(str(path))
    assert (robot.name, robot.stance.rest_height_m) == ("dog", 0.17)


def test_nobody_answers(new):
    code, _, err, path = new(typed=["dog"])
    assert code == 2
    assert "stopped: no answer" in err
    assert not path.exists()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"thigh": "inf"}, "--thigh: value inf: allowed: a number within 0.01 .. 1 m"),
        ({"thigh": 120}, "--thigh: value 120.0: allowed: a number within 0.01 .. 1 m (120 mm or g are 0.12)"),
        ({"hip-mass": 0}, "--hip-mass: value 0.0: allowed: a number within 0.001 .. 100 kg"),
        ({"joints": "solo12"}, '--joints: value "solo12": allowed: one of "caramelo", "parallel"'),
        ({"knees": "both"}, '--knees: value "both": allowed: one of "full-elbow"'),
        ({"height": 0.5}, "these answers do not go together: stance.rest_height_m: value 0.5: allowed: within"),
    ],
)
def test_wrong_options_are_one_line_and_write_nothing(refused, tmp_path, change, words):
    path = tmp_path / "new.toml"
    assert words in refused("robots", "new", str(path), *options(BIG | change))
    assert not path.exists()


def test_joints_too_soft_for_their_whole_sag_get_the_share_that_the_core_holds(new):
    """No question asks for that share, so the command must not refuse the answers because of it."""
    heavy = {"joints": "other", "thigh": 0.13, "calf": 0.14, "trunk-mass": 3.5}
    code, _, _, path = new(*options(heavy), "--defaults")
    assert code == 0
    assert load_robot(str(path)).gait.sag_compensation == 0.88


@pytest.mark.parametrize("trunk_kg", [6, 90])
def test_a_robot_too_weak_is_written_and_told(new, trunk_kg):
    weak = {"joints": "other", "trunk-mass": trunk_kg, "stall": 2.8}
    code, out, _, path = new(*options(weak), "--defaults")
    assert code == 1
    assert "raise actuator.supply.stall_Nm" in " ".join(out.split())
    assert load_robot(str(path)).name == "mine"


def test_a_file_that_is_there_stays(new, refused, tmp_path):
    path = tmp_path / "new.toml"
    path.write_text("mine\n")
    line = refused("robots", "new", str(path), "--defaults")
    assert line == f"caramelo: {path}: the file exists: name another, or overwrite it with --force\n"
    assert path.read_text() == "mine\n"
    assert new("--defaults", "--force")[0] == 0
    assert load_robot(str(path)).name == "mine"


def test_a_name_that_is_no_file_for_a_robot(refused, tmp_path):
    line = refused("robots", "new", str(tmp_path / "new.txt"), "--defaults")
    assert line.endswith("new.txt: give a file that ends in .toml\n")


def test_a_model_that_would_break_the_file(new):
    code, _, _, path = new(*options(BIG | {"model": 'a "b" \\ c'}))
    assert code == 0
    actuator = load_robot(str(path)).actuator
    assert isinstance(actuator, Servo)
    assert actuator.model == 'a "b" \\ c'


def test_changed_text_keeps_comments_and_leaves_out_tables():
    text = "# old\n\na = 1  # [m] first; it was 1 (paper)\n\n[t]\nb = 2  # [m] second (paper)\n"
    text += "\n[u]\nc = 3  # [m] x (paper)\n"
    new = changed(text, {"t.b": Change("5", "yours", "new")}, {"u"}, "other", "# head\n")
    lines = [" ".join(line.split()) for line in new.splitlines() if line]
    assert lines == ["# head", "a = 1 # [m] first; it was 1 (as other)", "[t]", "b = 5 # [m] new (yours)"]
