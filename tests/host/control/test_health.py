"""`caramelo health`: the verdict on each part, from a drive that runs, from a simulation, from parts that fail."""

import pytest

from host.control.hardware import Hardware
from host.control.health import findings
from host.control.telemetry import Extra, about, status
from host.teleop import look
from tests.host.control.rig import Rig
from tests.host.teleop.web.rig import Teleop

BUSY = ("loop", "deadlines", "IMU")  # they tell of the machine, too: a slow one comes to fewer readings
LINES = ["robot", "loop", "deadlines", "bus", "IMU", "battery", "heat", "versions"]


@pytest.fixture(scope="module")
def seen():
    """What a simulated robot tells that has come to rest, over two seconds."""
    rig = Rig()
    constant = about(rig.robot, Hardware(rig.bus, None, simulated=True))
    rig.run(4.0)
    first = status(rig.loop, Extra())
    rig.run(2.0)
    return constant, first, status(rig.loop, Extra())


def verdicts(seen, constant=(), **changed):
    """Return name -> (verdict, found) with some values of the last status changed."""
    told, first, last = seen
    lines = list(findings({**told, **dict(constant)}, first, {**last, **changed}))
    assert [line.name for line in lines] == LINES
    return {line.name: (line.verdict, line.found) for line in lines}


def test_a_robot_that_is_well(seen):
    lines = verdicts(seen)
    assert {verdict for verdict, _ in lines.values()} == {"ok"}
    assert lines["robot"][1] == "caramelo, simulated: disarmed"
    assert lines["loop"][1] == "50.0 of 50 Hz in the last 2.0 s"
    assert lines["battery"][1] == "12.0 V; the robot sits down below 10.2"


def timing(seen, **changed):
    return {"timing": {**seen[2]["timing"], **changed}}


def test_every_part_can_be_bad_and_says_why(seen):
    lost = [0] * 12
    lost[2], lost[5], lost[11] = 30, 4, 1
    heat_C = [30.0] * 12
    heat_C[4] = 80.0
    for name, changes, verdict, words in (
        ("robot", {"fault": "FR hip is hot"}, "bad", "FR hip is hot"),
        ("robot", {"stop": "web 1"}, "note", "emergency stop by web 1"),
        ("loop", timing(seen, ticks=50), "bad", "of 50 Hz"),
        ("deadlines", timing(seen, missed=1, ticks=999), "note", "1 missed of 1000 ticks"),
        ("deadlines", timing(seen, missed=20, ticks=980), "bad", "20 missed of 1000 ticks"),
        ("bus", {"bus_asked": 1000, "bus_errors": 35, "lost_by_joint": lost}, "bad", "FR calf 30, FL calf 4"),
        ("bus", {"bus_asked": 10000, "bus_errors": 35, "lost_by_joint": lost}, "note", "35 errors in 10000 answers"),
        ("bus", {"silent": [3, 4]}, "bad", "no answer from FL hip, FL thigh"),
        ("IMU", {"attitude_rad": None, "attitude_note": "no sensor at 0x68"}, "bad", "no sensor at 0x68"),
        ("IMU", {"readings_missed": 3}, "note", "3 readings missed"),
        ("battery", {"battery_V": 10.0}, "bad", "10.0 V"),
        ("battery", {"battery_V": 10.5}, "note", "10.5 V"),
        ("battery", {"battery_V": None}, "bad", "no joint reports a voltage"),
        ("heat", {"temperature_C": heat_C}, "bad", "hottest FL thigh: 80 degrees C; the robot sits down above 75"),
        ("heat", {"temperature_C": [66.0] * 12}, "note", "66 degrees C"),
    ):
        found = verdicts(seen, **changes)[name]
        assert found[0] == verdict, (name, changes, found)
        assert words in found[1]


def test_an_answer_that_came_late_after_all_is_no_error_below_nothing(seen):
    told, first, last = seen
    began = {**first, **timing(seen, ticks=0), "bus_errors": 12, "lost_by_joint": [1] * 12}
    changed = {"bus_asked": began["bus_asked"] + 1000, "bus_errors": 0, "lost_by_joint": [0] * 12}
    lines = verdicts((told, began, last), **changed)
    assert lines["bus"] == ("ok", "0 errors in 1000 answers")


def test_versions_that_differ_are_noted(seen):
    own = seen[0]["versions"]
    assert verdicts(seen, {"versions": {**own, "joints": "1.0.0, 1.1.0"}})["versions"][0] == "note"
    verdict, words = verdicts(seen, {"versions": {**own, "caramelo": "0.0.1"}})["versions"]
    assert verdict == "note"
    assert "restart the service" in words


def test_a_simulated_robot(run_json):
    code, value, err = run_json("health", "--robot", "parallel", "--sim")
    assert err == ""
    assert value["source"] == "simulation"
    assert [line["name"] for line in value["lines"]] == LINES
    assert code == (0 if value["ok"] else 1)
    steady = [line for line in value["lines"] if line["name"] not in BUSY]
    assert all(line["verdict"] == "ok" for line in steady), steady


def test_a_simulated_robot_has_come_to_rest_before_it_is_looked_at(run_json):
    """Its sensor was bad, because it had moved: three times in four."""
    _, value, _ = run_json("health", "--sim", "--direct")
    lines = {line["name"]: line for line in value["lines"]}
    assert lines["IMU"]["found"].startswith("roll "), lines["IMU"]


@pytest.fixture
def briefly(monkeypatch):
    """Return the options to look for less than two seconds: at a drive whose sensor has found out where up is."""
    monkeypatch.setattr("host.commands.health.LOOK_S", 0.1)
    return "--seconds", "0.1"


def test_a_drive_that_runs(run, run_json, tmp_path, briefly):
    with Teleop(tmp_path) as teleop:
        code, value, _ = run_json("health", "--socket", str(tmp_path / "teleop.sock"))
        assert [line["name"] for line in value["lines"]] == LINES
        assert value["lines"][0]["found"] == "caramelo, simulated: disarmed"
        assert code == (0 if value["ok"] else 1)
        teleop.say(type="stop")
        teleop.wait(lambda status: status["stop"])
        _, out, _ = run("health", "--socket", str(tmp_path / "teleop.sock"), *briefly)
        assert "emergency stop by script" in out
        assert len(out.splitlines()) == len(LINES)


def test_without_a_drive_the_services_socket_is_looked_for(run_json, tmp_path, monkeypatch, briefly):
    with Teleop(tmp_path):
        monkeypatch.setattr(look, "SERVICE", str(tmp_path / "teleop.sock"))
        assert run_json("health", *briefly)[1]["source"] == str(tmp_path / "teleop.sock")


def test_hardware_that_can_not_be_opened(run_json, tmp_path, monkeypatch):
    monkeypatch.setattr(look, "SERVICE", str(tmp_path / "none.sock"))
    code, value, _ = run_json("health", "--calibration", str(tmp_path / "none.toml"))
    assert code == 1
    assert [(line["name"], line["verdict"]) for line in value["lines"]] == [
        ("joints", "bad"), ("IMU", "bad"), ("versions", "ok"),
    ]  # fmt: skip
    assert "no calibration yet" in value["lines"][0]["found"]


def test_a_port_without_servos(run_json, tmp_path, monkeypatch):
    """The joints fail their check; the sensor is looked at all the same."""
    monkeypatch.setattr(look, "SERVICE", str(tmp_path / "none.sock"))
    calm = tmp_path / "rest.csv"
    calm.write_text("".join(f"0,0,{at},0,0,16384\n" for at in range(50)))
    code, value, _ = run_json("health", "--robot", "parallel", "--port", "virtual:health", "--imu", str(calm))
    lines = {line["name"]: line for line in value["lines"]}
    assert code == 1
    assert lines["joints"]["verdict"] == "bad"
    assert (lines["IMU"]["verdict"], lines["IMU"]["found"]) == ("ok", "recorded answers")


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("--seconds", "0"), 2, "--seconds 0: allowed 2 .. 600 s"),
        (("--robot", "pupper"), 2, "can only be simulated, not driven: add --sim"),
        (("--direct",), 2, "--direct: only with --sim"),
        (("--sim", "--socket", "x"), 2, "--sim: not with --socket"),
        (("--imu", "tin can"), 2, "--imu tin can: allowed"),
        (("--socket", "/nowhere.sock"), 1, "no drive answers there"),
        (("--socket", "65536"), 1, "port must be 0-65535"),
    ],
)
def test_wrong_use_is_one_line(refused, arguments, code, words):
    assert words in refused("health", *arguments, code=code)
