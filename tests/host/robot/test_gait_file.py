"""A gait file: what the core makes of it, one line for each mistake, and that command and library walk it."""

import json
import subprocess
import sys

import pytest

from host.library.robot import Robot
from host.records.reader import read_record
from host.records.replay import replay
from host.robot.file import load_robot
from host.robot.gait_advice import UNTRIED, WALKED_IN_SPACE, gait_advice
from host.robot.gait_file import with_gait
from host.util.errors import UserError
from shared.gait.gaits import GAIT_NAMES
from tests import ROOT

AMBLE = ROOT / "examples/amble.toml"
LEGS = {"FR": 1, "FL": 2, "RR": 4, "RL": 8}


def changed(tmp_path, old, new):
    """Return the path of the example with another text in it."""
    text = AMBLE.read_text()
    assert old in text
    path = tmp_path / "my.toml"
    path.write_text(text.replace(old, new))
    return str(path)


def test_the_example_is_the_table_it_describes():
    (own,) = with_gait(load_robot("caramelo"), str(AMBLE)).gait.own
    rows = [row for leg in ("RR", "FR", "RL", "FL") for row in ((240, LEGS[leg], 240), (160, 0, 160))]
    assert own.entry == ("amble", 0, ((60, 100, 100, 0), tuple(rows)))


def pace(tmp_path, right_at, left_at):
    """Return what the core makes of a gait whose legs of a side swing together."""
    path = tmp_path / "pace.toml"
    path.write_text(
        'name = "pace"\ncycle_s = 0.64\nduty = 0.625\nswing_height_m = 0.03\n'
        f"lifts_at = {{ FR = {right_at}, RR = {right_at}, FL = {left_at}, RL = {left_at} }}\n"
    )
    return with_gait(load_robot("caramelo"), str(path)).gait.own[0].entry


def test_legs_that_swing_together_are_one_row(tmp_path):
    right, left = LEGS["FR"] | LEGS["RR"], LEGS["FL"] | LEGS["RL"]
    rows = (240, right, 240), (80, 0, 80), (240, left, 240), (80, 0, 80)
    assert pace(tmp_path, 0.0, 0.5) == ("pace", 0, ((30, 100, 100, 0), rows))


def test_a_swing_of_two_over_the_end_of_the_cycle_moves_its_beginning(tmp_path):
    rows = pace(tmp_path, 0.8, 0.3)[2][1]
    assert sorted(rows) == [(80, 0, 80), (80, 0, 80), (240, 5, 240), (240, 10, 240)]
    assert not rows[0][1] & rows[-1][1], "no foot is in the air where the cycle begins"


def test_a_swing_over_the_end_of_the_cycle_moves_its_beginning(tmp_path):
    path = changed(tmp_path, "RR = 0.0, FR = 0.25, RL = 0.5, FL = 0.75", "RR = 0.9, FR = 0.15, RL = 0.4, FL = 0.65")
    rows = with_gait(load_robot("caramelo"), path).gait.own[0].entry[2][1]
    assert sorted(rows) == [(160, 0, 160)] * 4 + [(240, LEGS[leg], 240) for leg in ("FR", "FL", "RR", "RL")]
    assert not rows[0][1] & rows[-1][1], "no foot is in the air where the cycle begins"


MISTAKES = [
    ("cycle_s = 1.6 ", "cycle_s = 0.0 ", "cycle_s: value 0.0: allowed: a number within 0.2 .. 20 s"),
    ("duty = 0.85 ", "duty = 1.5 ", "duty: value 1.5: allowed: a number within 0.5 .. 0.95"),
    ("duty = ", "dutty = ", "dutty: value 0.85: unknown key, did you mean duty?"),
    ('name = "amble"', 'name = "trot"', "name: value 'trot': allowed: any name except paper-trot"),
    ("RL = 0.5", "RL = 7", "lifts_at.RL: value 7: allowed: a number within 0 .. 0.999"),
    ("RL = 0.5, ", "", "lifts_at.RL: value missing: it must be there; docs/gaits.md names what is allowed"),
    ("duty = 0.85 ", "duty = 0.6 ",
     "lifts_at: value (0.25, 0.75, 0.0, 0.5): allowed: feet that are all on the ground at some moment"),
    ("FR = 0.25, RL = 0.5, FL = 0.75", "FR = 0.0, RL = 0.0, FL = 0.0",
     "lifts_at: value (0.0, 0.0, 0.0, 0.0): allowed: feet of which at least one stands"),
    ("cycle_s = 1.6 ", "cycle_s = ", "allowed: TOML as in"),
]


@pytest.mark.parametrize(("old", "new", "told"), MISTAKES)
def test_a_mistake_is_one_line_with_key_value_and_what_is_allowed(tmp_path, old, new, told):
    path = changed(tmp_path, old, new)
    with pytest.raises(UserError) as error:
        with_gait(load_robot("caramelo"), path)
    assert str(error.value).startswith(path)
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_what_is_not_there_is_one_line():
    robot = load_robot("caramelo")
    with pytest.raises(UserError, match="no such file; gaits known by name are paper-trot"):
        with_gait(robot, "nowhere.toml")
    with pytest.raises(UserError, match="no such gait; there are paper-trot"):
        with_gait(robot, "gallop")


def test_the_robot_knows_it_begins_with_it_and_says_that_it_is_untried():
    robot = with_gait(load_robot("caramelo"), str(AMBLE))
    assert (tuple(gait_advice(robot)), robot.gait.default) == ((*GAIT_NAMES, "amble"), "amble")
    assert gait_advice(robot)["amble"] == UNTRIED


def test_a_robot_file_holds_one_likewise_and_advises_it(tmp_path):
    """Its table stands at the end, after the other keys of its own."""
    text = (ROOT / "host/robot/files/caramelo.toml").read_text()
    table = "[[gait.own]]\n" + AMBLE.read_text()
    path = tmp_path / "mine.toml"
    path.write_text(text.replace('default = "trot"', 'default = "amble"') + "\n" + table)
    robot = load_robot(str(path))
    assert (robot.gait.default, robot.gait.own[0].cycle_s) == ("amble", 1.6)
    path.write_text(path.read_text().replace("cycle_s = 1.6 ", "cycle_s = 0 "))
    with pytest.raises(UserError, match="cycle_s: value 0: allowed: a number within"):
        load_robot(str(path))


@pytest.mark.parametrize(("robot", "world"), [("parallel", "plane"), ("caramelo", "plane"), ("caramelo", "space")])
def test_the_command_walks_it(robot, world):
    if world == "space":
        pytest.importorskip("mujoco", reason="MuJoCo is not installed (extra space)")
    command = [sys.executable, "-m", "host.cli", "walk", "--robot", robot, "--in", world, "--distance", "0.2", "--json"]
    done = subprocess.run([*command, "--gait", str(AMBLE)], capture_output=True, text=True, cwd=ROOT, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    told = json.loads(done.stdout)
    assert told["reason"].startswith("arrived")
    assert (told["gait"], told["advice"]) == ("amble", WALKED_IN_SPACE if world == "space" else UNTRIED)


def test_the_library_walks_it_and_its_record_is_replayed(tmp_path):
    path = tmp_path / "amble.mcap"
    with Robot("sim", robot="parallel", gait=AMBLE, record=path) as robot:
        robot.stand()
        robot.walk(0.05, seconds=2.0)
        assert (robot.gait, "amble" in robot.gaits) == ("amble", True)
        assert robot.odometry.x_m > 0.03
    assert replay(read_record(path)).ok
