"""The library's Robot: what it refuses and in which words, what it does when something goes wrong, what it records."""

import pickle
import sys
import threading
import traceback
from fractions import Fraction
from math import degrees, inf, nan

import numpy as np
import pytest

import caramelo
from caramelo import BadValue, Error, Fault, NotAchieved, Robot
from host.bus.base import JOINTS
from host.library.errors import own_words
from host.records.recorder import Recorder
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from host.util.errors import UserError
from tests.host.library.places import prompt
from tests.waiting import PATIENCE_S, wait_until


def bus_of(robot):
    return robot._place.hardware.bus


def test_all_that_is_named_is_there():
    assert all(hasattr(caramelo, name) for name in caramelo.__all__)
    assert caramelo.robot_names() == sorted(caramelo.robot_names())
    assert len(caramelo.JOINT_NAMES) == JOINTS


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"place": "moon"}, "place 'moon': allowed sim, space, servos, can"),
        ({"place": None}, "place None: allowed sim"),
        ({"honest": "no"}, "honest 'no': allowed True, False or None"),
        ({"gait": ""}, "gait '': allowed "),
        ({"gait": ["trot"]}, r"gait \['trot'\]: allowed "),
        ({"place": "can", "robot": "parallel", "port": 5}, "port 5: allowed a path as text"),
        ({"record": "a\0.mcap"}, "record .*: allowed a path as text"),
        ({"robot": "caramel"}, 'robot "caramel": unknown, did you mean caramelo?'),
        ({"robot": "none.toml"}, "none.toml: no such file"),
        ({"gait": "gallop"}, "gait 'gallop': allowed "),
        ({"place": "can"}, "place 'can': the joints of caramelo are 'servos'"),
        ({"place": "servos", "robot": "parallel"}, "the joints of parallel are 'can'"),
        ({"place": "servos", "robot": "pupper"}, "place 'servos': pupper is only for sim and space"),
        ({"port": "/dev/ttyUSB0"}, "port, calibration and imu are only for servos and can"),
        ({"place": "can", "robot": "parallel", "port": "can0"}, "port can0: for joints on CAN give INTERFACE:CHANNEL"),
        ({"place": "can", "robot": "parallel", "port": "virtual:x", "imu": "usb"}, "imu usb: allowed: i2c"),
        ({"place": "servos", "calibration": "/none.toml"}, "/none.toml: no calibration yet"),
    ],
)
def test_a_wrong_argument_is_named_in_the_librarys_words(arguments, words):
    with pytest.raises(Error, match=words.replace("?", r"\?")) as raised:
        Robot(**arguments)
    assert "--" not in str(raised.value)


def test_a_traceback_calls_errors_as_they_are_imported():
    for kind in (Error, BadValue, Fault, NotAchieved):
        line = traceback.format_exception_only(kind("no"))[-1]
        assert line == f"caramelo.{kind.__name__}: no\n"
        assert type(pickle.loads(pickle.dumps(kind("no")))) is kind
        assert issubclass(kind, Error)


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ("--log /none/x.mcap: can't be written", "record /none/x.mcap: can't be written"),
        ("--bus-delay 3: allowed 0 .. 0.5 s", "bus_delay 3: allowed 0 .. 0.5 s"),
        ("no servo answers: find it with: caramelo servos scan --all-bauds",) * 2,
        ("ttyUSB1: no such port; name yours with --port", "ttyUSB1: no such port; name yours with port"),
    ],
)
def test_options_are_called_as_arguments_and_commands_stay_as_they_are_typed(told, words):
    with pytest.raises(Error) as raised, own_words():
        raise UserError(told)
    assert str(raised.value) == words


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda r: r.walk(5.0, seconds=1), r"vx_m_s 5\.0: allowed -\d.* \.\. \d.* m/s by "),
        (lambda r: r.walk(nan, seconds=1), "vx_m_s nan: allowed"),
        (lambda r: r.walk("fast", seconds=1), "vx_m_s 'fast': allowed a number within -"),
        (lambda r: r.walk(np.zeros((9, 9)), seconds=1), r"vx_m_s array\(.*: allowed a number within -"),
        (lambda r: r.walk(10**5000, seconds=1), "vx_m_s inf: allowed -"),
        (lambda r: r.walk(0.05), "give either seconds or distance_m"),
        (lambda r: r.walk(0.05, seconds=1, distance_m=1), "give either seconds or distance_m"),
        (lambda r: r.walk(0.05, seconds=-1), "seconds -1: allowed 0 .. 3600 s"),
        (lambda r: r.walk(distance_m=1), "distance_m: only straight"),
        (lambda r: r.walk(0.05, 0, 0.1, distance_m=1), "distance_m: only straight"),
        (lambda r: r.turn(inf), "deg inf: allowed -3600 .. 3600 deg"),
        (lambda r: r.turn(10, wz_rad_s=9), r"wz_rad_s 9: allowed 0.01 .. "),
        (lambda r: r.pose(z_m=1), r"z_m 1: allowed -0.04 .. 0.04 m"),
        (lambda r: r.pose(roll_deg=True), "roll_deg True: allowed -20 .. 20 deg"),
        (lambda r: r.stream(hz=1000), "hz 1000: allowed 5 .. 50 Hz"),
        (lambda r: r.stream(hz=1), "hz 1: allowed 5 .. 50 Hz"),
        (lambda r: r.stream(joint_rad_s=100), "joint_rad_s 100: allowed 0 .. 5.76 rad/s"),
        (lambda r: setattr(r, "gait", "gallop"), "gait 'gallop': allowed "),
    ],
)
def test_a_wrong_wish_is_refused_before_anything_moves(robot, call, words):
    written = len(bus_of(robot).written)
    with pytest.raises(BadValue, match=words):
        call(robot)
    assert len(bus_of(robot).written) == written


def test_what_needs_an_open_robot_says_so():
    robot = Robot(prompt())
    for call in (robot.stand, robot.sit, robot.stop, lambda: robot.sensed, lambda: robot.walk(0.05, seconds=1)):
        with pytest.raises(Error, match="not open: write `with Robot"):
            call()
    with robot, pytest.raises(Error, match="already open"):
        robot.open()


def test_who_does_not_stand_does_not_walk():
    with Robot(prompt()) as robot:
        for call in (lambda: robot.walk(0.05, seconds=1), lambda: robot.turn(10), robot.pose):
            with pytest.raises(Error, match=r"does not stand, it is disarmed: call stand\(\) first"):
                call()


def test_a_distance_is_walked_and_an_angle_turned():
    """Requirement: by its own odometry it arrives, and stops within the way of one more cycle of steps."""
    with Robot("sim") as robot:
        robot.stand()
        robot.walk(0.05, distance_m=0.2)
        assert 0.2 <= robot.odometry.x_m < 0.26
        robot.turn(deg=-15)
        assert -18 < degrees(robot.odometry.yaw_rad) < -12


def test_the_fastest_turn_is_not_taken_for_being_lifted():
    """Its legs brake their swings with as much as the robot weighs."""
    with Robot("sim") as robot:
        robot.stand()
        robot.walk(0.08, distance_m=0.2)
        robot.turn(deg=90)
        assert 85 < degrees(robot.odometry.yaw_rad) < 95


def test_a_distance_that_is_not_walked_is_told(robot, monkeypatch):
    """Joints that do not follow: the feet stay where they are."""
    monkeypatch.setattr("host.library.robot.Robot._stands", lambda self, now: True)
    bus_of(robot).holds = False
    with pytest.raises(NotAchieved, match=r"walk 0.1 m: not within 30 s: .*; the robot walked -?0.0\d\d m"):
        robot.walk(0.05, distance_m=0.1)


def test_a_gait_is_chosen_by_name(robot):
    for gait in robot.gaits:
        robot.gait = gait
        robot.walk(robot._fastest()[0] / 2, seconds=0.1)
        assert robot._opened.supervisor.driver.command.gait == gait


def test_the_pose_is_kept_while_it_walks(robot):
    robot.pose(z_m=0.01)
    robot.walk(0.05, seconds=0.2)
    assert robot._opened.supervisor.driver.command.pose[2] == 0.01


def test_a_stop_lets_go_and_stays_until_it_is_reset(robot):
    robot.stop()
    assert bus_of(robot).stops >= 1
    assert not bus_of(robot).holds
    with pytest.raises(Fault, match="emergency stop"):
        robot.walk(0.05, seconds=1)
    robot.reset()
    robot.stand()
    robot.reset()  # nothing is left to forget
    robot.health(0.1)
    assert robot.sensed.state == "standing"


def test_a_tripped_joint_ends_the_walk_and_is_named(robot):
    bus_of(robot).error[4] = "overload"
    with pytest.raises(Fault, match="FL thigh: overload"):
        robot.walk(0.05, seconds=1)
    with pytest.raises(Fault, match="FL thigh: overload"):
        robot.reset()
    bus_of(robot).error[4] = ""
    robot.reset()
    assert robot.sensed.fault == ""


def test_it_tells_how_it_is_and_a_fault_is_a_line_of_it(robot):
    lines = {line.name: (line.verdict, line.found) for line in robot.health(1.0)}
    assert lines["robot"] == ("ok", "caramelo: standing")
    assert lines["loop"][1].startswith("50.0 of 50 Hz in the last ")
    assert lines["IMU"][0] == "bad"
    bus_of(robot).error[4] = "overload"
    told = next(line for line in robot.health(0.1) if line.name == "robot")
    assert told.verdict == "bad"
    assert "FL thigh: overload" in told.found
    with pytest.raises(BadValue, match=r"seconds -1: allowed 0 \.\. 3600 s"):
        robot.health(-1)


class Mine(Exception):
    """What goes wrong in a user's own program."""


def test_an_error_in_the_block_sits_the_robot_down():
    robot = Robot(prompt())
    bus = bus_of(robot)

    def program():
        with robot:
            robot.stand()
            raise Mine

    with pytest.raises(Mine):
        program()
    assert bus.stops == 0, "it sat down instead"
    assert bus.written[-1] == pytest.approx(seated_pose_rad(load_robot("caramelo")), abs=0.002)
    assert not bus.holds


def test_a_bus_that_fails_is_let_go_of_at_once_and_the_first_cause_is_told():
    robot = Robot(prompt())

    def program():
        with robot:
            robot.stand()
            bus_of(robot).failure = UserError("the cable is out")
            robot.walk(0.05, seconds=1)

    with pytest.raises(Error, match="the cable is out"):
        program()
    assert bus_of(robot).stops == 1


def test_on_hardware_the_loop_goes_on_while_the_program_thinks():
    with Robot(prompt(real_time=True)) as robot:
        robot.stand()
        before = len(bus_of(robot).written)
        wait_until(lambda: len(bus_of(robot).written) > before + 10, "no ticks")
        robot.walk(0.05, seconds=0.2)
        robot.stop()
        assert bus_of(robot).stops >= 1
        robot.reset()
    assert not bus_of(robot).holds


def test_on_hardware_a_loop_that_fails_lets_go_and_is_told():
    robot = Robot(prompt(real_time=True)).open()
    robot.stand()
    bus_of(robot).failure = UserError("the cable is out")
    with pytest.raises(Error, match="the control loop has ended: the cable is out; the joints have been let go"):
        robot.walk(0.05, seconds=5)
    assert bus_of(robot).stops >= 1
    with pytest.raises(Error, match="the control loop has ended"):
        robot.close()
    robot.close()


def test_only_a_simulator_tells_the_truth(robot):
    with pytest.raises(Error, match="only a simulator knows"):
        print(robot.truth)
    with Robot("sim") as simulated:
        assert simulated.truth[1:] == (0.0, 0.0)


def test_a_simulated_walk_is_the_same_twice():
    def walked():
        with Robot("sim") as robot:
            robot.stand()
            robot.walk(0.05, seconds=1.0)
            return robot.truth, robot.sensed.joints_rad

    assert walked() == walked()


def test_a_record_holds_every_tick(tmp_path, run_json):
    """Made faster than time goes by: the disk is waited for, nothing is dropped."""
    path = tmp_path / "walk.mcap"
    with Robot("sim", record=path) as robot:
        robot.stand()
        robot.walk(0.05, seconds=20.0)
        loop = robot._opened.loop
    code, told, _ = run_json("log", "info", str(path))
    assert (code, told["messages"]["/joints"]) == (0, loop.pacer.ticks)
    with pytest.raises(Error, match=r"walk.mcap: the file exists"):
        Robot("sim", record=path).open()


def test_a_record_that_ends_early_is_told_once_the_robot_sits(tmp_path, monkeypatch):
    synced = []

    def full(recorder):
        synced.append(recorder)
        if len(synced) > 1:
            raise OSError(28, "No space left on device")

    monkeypatch.setattr(Recorder, "_force", full)
    robot = Robot("sim", record=tmp_path / "x.mcap").open()
    robot.stand()
    supervisor = robot._opened.supervisor
    with pytest.raises(Error, match=r"record .*x\.mcap: the record ends here: No space left on device: \d+ messages "):
        robot.close()
    assert not supervisor.armed


def test_records_of_one_second_get_names_of_their_own(tmp_path):
    for _ in range(3):
        with Robot("sim", record=tmp_path):
            pass
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.parametrize("kind", [np.float32, np.int64, Fraction])
def test_a_number_may_be_of_any_kind(robot, kind):
    robot.walk(kind(0), seconds=kind(1))
    assert robot.sensed.state == "standing"


@pytest.mark.parametrize("name", ["record", "calibration", "port", "imu"])
def test_a_path_that_is_none_is_told(name):
    with pytest.raises(BadValue, match=f"{name} True: allowed a path as text or Path, or None"):
        Robot("sim", **{name: True})


def test_what_is_not_installed_is_told(monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    for name in [name for name in sys.modules if name.startswith("host.sim.space")]:
        monkeypatch.delitem(sys.modules, name)
    with pytest.raises(Error, match="this needs mujoco, which is not installed: run "):
        Robot("space")


@pytest.mark.parametrize("real_time", [False, True])
def test_a_stop_from_another_thread_ends_a_walk(real_time):
    with Robot(prompt(real_time=real_time)) as robot:
        robot.stand()
        walks = threading.Event()

        def stop():
            walks.wait(PATIENCE_S)
            robot.stop()

        def walk():
            for _ in robot.stream():
                robot.set_speed(0.05)
                walks.set()

        other = threading.Thread(target=stop)
        other.start()
        with pytest.raises(Fault, match="emergency stop"):
            walk()
        other.join(PATIENCE_S)
        assert not bus_of(robot).holds
