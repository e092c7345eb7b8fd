"""The guided set-up of new servos: in this process, through a pseudo-terminal, and as a user runs it."""

import pytest

from host.bus.base import JOINT_LABELS
from host.bus.dynamixel import table as t
from host.bus.dynamixel.calibration.data import nominal
from host.bus.dynamixel.calibration.person import FromFile
from host.bus.dynamixel.link import Link, ServoError
from host.bus.dynamixel.port import ServoPort
from host.bus.dynamixel.setup import SETTINGS, Setup
from host.sim.servos.process import Emulator
from host.sim.servos.tray import Tray, plug
from host.util.errors import UserError

from .rig import CARAMELO

IDS, BAUD = nominal(CARAMELO).ids, CARAMELO.bus.baud


class Hands:
    """Someone who plugs in what ``plugs`` says, time by time, and answers as ``answers`` say."""

    there = True

    def __init__(self, plugs=(), **answers):
        self.plugs, self.answers, self.heard, self.asked = list(plugs), answers, [], []

    def say(self, text):
        self.heard.append(text)

    def ask(self, key, question, choices):
        self.asked.append(key)
        if key.endswith("plugged"):
            self.plugs.pop(0)()
            return ""
        return self.answers[key.rpartition(" ")[2]]

    def refuse(self, key, reason):
        self.heard.append(reason)


@pytest.fixture
def tray():
    return Tray(CARAMELO)


def put(tray, joint, **registers):
    """Set registers of a joint's servo from inside."""
    for name, value in registers.items():
        tray.bus.servos[joint].put(t.REGISTERS[name], value)


def setup(tray, person=None, keep=None):
    hands = None if person else tray.plug
    return Setup(CARAMELO, tray.link, person or FromFile({"resume": "yes"}, "answers"), IDS, BAUD, keep, hands)


def as_wanted(servo, number):
    """Say whether a servo is as its joint needs it, its protocol left out."""
    return (servo.id, t.BAUDS[servo.get(t.BAUD)]) == (number, BAUD) and all(
        servo.get(register) == value for register, value in SETTINGS.values()
    )


def test_twelve_new_servos_get_ids_rate_and_settings_and_nothing_else_is_written(tray):
    done = setup(tray).run(range(12))
    assert all(as_wanted(servo, number) for servo, number in zip(tray.bus.servos, IDS, strict=True))
    assert {(one.found_id, one.found_baud, one.written) for one in done.values()} == {(1, 57600, 1)}
    assert [servo.get(t.LED) for servo in tray.bus.servos] == [0] * 11 + [1]
    again = setup(tray)
    again.one(4)
    assert (again.done[4].found_id, again.done[4].written) == (5, 0)


def test_a_servo_is_found_whatever_it_was_set_to(tray):
    for baud in range(len(t.BAUDS)):
        for number in (0, 1, 7, 252):
            put(tray, 0, ID=number, BAUD=baud, SHADOW_ID=3, OPERATING_MODE=1, HOMING_OFFSET=-300, PWM_LIMIT=400,
                MAX_POSITION=3000, MIN_POSITION=100, RETURN_DELAY=9, SHUTDOWN=0, TORQUE_ENABLE=1)
            done = setup(tray).run([0])[0]
            assert (done.found_id, done.found_baud, done.written) == (number, t.BAUDS[baud], 8)
            assert as_wanted(tray.bus.servos[0], 1)


@pytest.mark.parametrize(
    ("registers", "plugged", "words"),
    [
        ({}, (), "no servo answers on emulated at any rate: check its power and its cable"),
        ({}, (0, 1), "the answers of id 1 are damaged, as if two servos with that id talked at once: leave one"),
        ({"ID": 9}, (0, 1), r"2 servos answer \(id 1 at 57600 baud, id 9 at 57600 baud\): leave one plugged in"),
        ({"ID": 2, "BAUD": 6}, (0, 1), r"\(id 1 at 57600 baud, id 2 at 4000000 baud\): leave one plugged in"),
        ({"MODEL_NUMBER": 12}, (1,), r"servo id 1 is not an MX-28\(2.0\) but model 12$"),
        ({"MODEL_NUMBER": 29}, (1,), r"is not an MX-28\(2.0\) but MX-28 \(old firmware\); update its firmware"),
        ({"FIRMWARE": 37}, (1,), "servo id 1 has firmware 37, but needs 38 or newer: update it with Dynamixel Wizard"),
        ({"HARDWARE_ERROR": 32}, (1,), "servo id 1 has tripped: overload; switch its power off and on"),
    ],
)
def test_what_can_not_be_set_up_is_one_sentence_and_nothing_is_written(tray, registers, plugged, words):
    tray.bus.servos[0].put(t.PRESENT_TEMPERATURE, 31)
    plug(tray.bus, plugged)
    put(tray, 1, **registers)
    before = [bytes(servo.memory) for servo in tray.bus.servos]
    with pytest.raises(ServoError, match=words):
        Setup(CARAMELO, tray.link, FromFile({}, "answers"), IDS, BAUD).run([1])
    eeprom = slice(0, t.TORQUE_ENABLE.address)
    assert [bytes(servo.memory)[eeprom] for servo in tray.bus.servos] == [memory[eeprom] for memory in before]


def test_a_servo_that_talks_the_other_protocol_is_told():
    tray = Tray(CARAMELO, 1.0)
    run = Setup(CARAMELO, Link(tray.link.port, 2.0), FromFile({}, "answers"), IDS, BAUD, None, tray.plug)
    with pytest.raises(ServoError, match=r"protocol 1.0, but caramelo needs 2.0: set its Protocol Type to 2 with"):
        run.run([0])


def test_a_servo_that_forgets_is_told(tray):
    servo = tray.bus.servos[0]
    keep = servo.put
    servo.put = lambda register, value: None if register is t.RETURN_DELAY else keep(register, value)
    with pytest.raises(ServoError, match="servo id 1 did not keep RETURN_DELAY: plug it in again, or use another"):
        setup(tray).run([0])


@pytest.mark.parametrize("register", [t.RETURN_DELAY, t.PWM_LIMIT, t.ID, t.BAUD], ids=["delay", "pwm", "id", "baud"])
@pytest.mark.parametrize("arrived", [False, True])
def test_power_lost_while_a_register_is_written_is_told_and_made_good(tray, register, arrived):
    servo = tray.bus.servos[6]
    put(tray, 6, PWM_LIMIT=300)
    write = servo.write

    def cut(address, data):
        if address == register.address and cuts:
            cuts.pop()
            servo.missing = True
            return write(address, data) if arrived else 0
        return write(address, data)

    servo.write, cuts = cut, [1]
    tray.bus._collide = lambda answers: [] if servo.missing else answers
    person = Hands([lambda: tray.plug(6), lambda: tray.plug(6)])
    setup(tray, person).run([6])
    assert not cuts
    assert len(person.heard) == 2
    assert "answer" in person.heard[0]
    assert as_wanted(servo, 7)


def test_the_servo_before_that_is_still_plugged_in_is_not_set_up_again(tray):
    person = Hands([lambda: tray.plug(0), lambda: None, lambda: tray.plug(1)], another="no")
    setup(tray, person).run([0, 1])
    assert [servo.id for servo in tray.bus.servos[:2]] == [1, 2]
    assert person.heard[1] == "then unplug it, and plug in the servo of FR thigh"
    put(tray, 2, ID=1, BAUD=6)  # a used one, set as that of FR hip by chance
    person = Hands([lambda: tray.plug(0), lambda: tray.plug(2)], another="yes")
    setup(tray, person).run([0, 2])
    assert tray.bus.servos[2].id == 3


def test_goes_on_where_it_stopped(tray, tmp_path):
    keep = tmp_path / "unfinished"
    with pytest.raises(KeyboardInterrupt):
        setup(tray, Hands([lambda: tray.plug(0), lambda: tray.plug(1), _interrupt]), keep).run(range(12))
    person = Hands([lambda joint=joint: tray.plug(joint) for joint in range(2, 12)], resume="yes")
    done = setup(tray, person, keep).run(range(12))
    assert len(done) == 12
    assert all(as_wanted(servo, number) for servo, number in zip(tray.bus.servos, IDS, strict=True))
    assert not keep.exists()


def _interrupt():
    raise KeyboardInterrupt


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ('robot = "spot"', "begun for another robot"),
        ("robot = ", "can't go on from this file"),
        ('robot = "caramelo"\n"FR nose" = { id = 1 }', "can't go on from this file"),
        ('robot = "caramelo"\n"FR hip" = { id = 1 }', "whole numbers only"),
        ('robot = "caramelo"\n"FR hip" = { id = 3, baud = 4000000, firmware = 45, found_id = 1, found_baud = 57600, '
         "written = 1 }", "begun with other ids or another rate; delete the file"),
    ],
)  # fmt: skip
def test_a_spoilt_unfinished_file_is_refused(tray, tmp_path, content, words):
    (tmp_path / "unfinished").write_text(content)
    with pytest.raises(UserError, match=words):
        setup(tray, None, tmp_path / "unfinished").run(range(12))


class PatientHands(Hands):
    """Plugs in each joint's servo, again if it is asked for again: an emulated servo may answer too late."""

    def __init__(self, emulator):
        super().__init__()
        self.emulator = emulator

    def ask(self, key, question, choices):
        self.asked.append(key)
        assert len(self.asked) < 20, self.heard
        self.emulator.ask("plug", joints=[("FR hip", "FR thigh").index(key.removesuffix(" plugged"))])
        return ""


def test_through_a_pseudo_terminal(tmp_path, monkeypatch):
    monkeypatch.setattr("host.bus.dynamixel.setup.SLOW", 1)  # the other rates are searched above, where no time passes
    with Emulator("--plant", "bench", "--new") as emulator:
        port = ServoPort(emulator.port, BAUD)
        port.open()
        done = Setup(CARAMELO, Link(port), PatientHands(emulator), IDS, BAUD, tmp_path / "unfinished").run([0, 1])
        port.closePort()
        assert [(one.id, one.baud, one.found_id, one.found_baud) for one in done.values()] == [
            (1, BAUD, 1, 57600), (2, BAUD, 1, 57600)]  # fmt: skip
        assert not any(emulator.ask("state")["torque"])


def test_the_command_prints_a_table_or_one_object(run, run_json, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "answers.toml").write_text("")
    code, found, err = run_json("servos", "setup", "--sim", "--answers", "answers.toml")
    assert (code, err) == (0, "")
    assert [row["joint"] for row in found["servos"]] == list(JOINT_LABELS)
    code, out, _ = run("servos", "setup", "--sim", "--answers", "answers.toml", "--joint", "rl calf")
    assert code == 0
    assert [line.split()[:3] for line in out.splitlines()[1:]] == [["RL", "calf", "12"]]


def test_questions_do_not_spoil_the_object_and_an_end_of_input_keeps_what_is_done(run, run_json, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines = [""] * 5
    monkeypatch.setattr("builtins.input", lambda prompt: lines.pop() if lines else _end())
    code, out, err = run("servos", "setup", "--sim", "--json")
    assert (code, out) == (2, "")
    assert err.endswith("caramelo: the input ended; what is done so far is kept: run the command again to go on\n")
    (tmp_path / "answers.toml").write_text('resume = "yes"')
    monkeypatch.setattr("host.sim.servos.tray.unpack", lambda bus: plug(bus, ()))  # the five keep what they have
    code, found, _ = run_json("servos", "setup", "--sim", "--answers", "answers.toml")
    assert code == 0
    assert [row["written"] for row in found["servos"]] == [1] * 12


def _end():
    raise EOFError


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--joint", "nose"), "--joint nose: allowed FR hip, FR thigh"),
        (("--robot", "parallel"), "no servo bus"),
        (("--port", "/dev/ttyUSB97"), "no such port"),
        (("--calibration", "no.toml"), "no.toml: no calibration yet"),
        (("--answers", "no.toml"), "no.toml: can't be read"),
        (("--answers", "a", "--record", "b"), "--record: not with --answers"),
    ],
)
def test_errors_are_one_line(refused, arguments, words):
    assert words in refused("servos", "setup", *arguments)
