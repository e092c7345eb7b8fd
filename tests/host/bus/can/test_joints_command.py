"""`caramelo joints` against simulated joints: in this process, and behind a bus that another program shares."""

import json
import threading
from functools import partial

import pytest

from host.bus.can.adapter import AdapterPort
from host.protocol.dbc import parse
from host.robot.file import load_robot
from host.sim.joints.gateway import Gateway
from host.sim.joints.sim_robot import SimRobot, power_off
from host.util.errors import UserError
from shared.wire.names import HEARTBEAT_ID, PROTOCOL_HASH
from tests.waiting import PATIENCE_S


@pytest.fixture
def joints(run):
    """Run one of the commands; return exit code, stdout, stderr."""
    return partial(run, "joints")


def test_scan_lists_twelve_boards(run_json):
    code, found, _ = run_json("joints", "scan", "--sim")
    assert code == 0
    assert [board["node"] for board in found["boards"]] == list(range(1, 13))
    assert found["wrong"] == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("status", ("FR thigh (2)", "disabled", "0 lost to a full send buffer")),
        ("arm --seconds 0.3", ("disarmed",)),
        ("disarm", ()),
        ("clear", ()),
        ("set-id 0x27b2d3d6 1", ()),
        ("params set 5 gear_q8 21.5", ("gear_q8 is now 21.5 rotor turn/joint turn (raw 5504)",)),
        ("params diff 5", ("has_joint_encoder",)),
        ("params save 3", ()),
        ("params restore 3", ()),
    ],
)
def test_what_is_done_is_said(joints, words, said):
    code, out, _ = joints(*words.split(), "--sim")
    assert code == 0
    assert [sentence for sentence in said if sentence not in out] == []


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("set-id 0x27b2d3d6 5 --sim", "node 5 is taken"),
        ("params set 5 gear_q8 900 --sim", "gear_q8: 900: allowed 1 to 63"),
        ("params get 5 nonsense --sim", "no such parameter; caramelo joints params get NODE lists them"),
        ("scan --sim --channel can0", "--interface and --channel: not with --sim"),
        ("monitor --sim --plot smell", "--plot smell: allowed"),
        ("sim --robot caramelo --seconds 0.1", "no joints on CAN"),
    ],
)
def test_what_is_refused_is_said(refused, words, said):
    assert said in refused("joints", *words.split())


def test_parameters_are_read_in_their_units(run_json):
    code, found, _ = run_json("joints", "params", "get", "5", "node_id", "gear_q8", "--sim")
    assert (code, found["parameters"]) == (0, {"node_id": 5.0, "gear_q8": 22.0})


def test_parameters_go_to_a_file_and_back(joints, run_json, tmp_path):
    path = tmp_path / "joint5.json"
    code, out, _ = joints("params", "save", "5", "--file", str(path), "--sim")
    assert code == 0
    values = json.loads(path.read_text())
    assert values["parameters"]["has_joint_encoder"] == 0
    assert "node_id" not in values["parameters"]
    _, found, _ = run_json("joints", "params", "diff", "6", "--file", str(path), "--sim")
    different = {row["parameter"]: (row["raw"], row["wanted"]) for row in found["different"]}
    assert different["has_joint_encoder"] == (1, 0)
    code, out, _ = joints("params", "restore", "6", "--file", str(path), "--sim")
    assert code == 0
    assert f"{len(different)} changed" in " ".join(out.split())


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{}", "not a file of params save --file"),
        ('{"protocol": "0x0000", "parameters": {}}', "has protocol 0x0000"),
        ('{"protocol": "HASH", "parameters": {"melt": 3}}', "melt = 3"),
        ('{"protocol": "HASH", "parameters": {"gear_q8": 1}}', "gear_q8: 0.00390625: allowed 1 to"),
    ],
)
def test_a_parameter_file_that_is_wrong_is_named(refused, tmp_path, text, words):
    path = tmp_path / "wrong.json"
    path.write_text(text.replace("HASH", f"{PROTOCOL_HASH:#06x}"))
    assert words in refused("joints", "params", "restore", "6", "--file", str(path), "--sim")


def test_busload_prints_the_schedule(joints, run_json):
    code, found, _ = run_json("joints", "busload")
    assert code == 0
    assert found["buses"][0]["rows"][-1]["worst_share"] <= 0.40
    assert joints("busload", "--rate", "400")[0] == 1
    code, out, _ = joints("busload", "--rate", "400", "--buses", "2")
    assert code == 0
    assert [out.count(words) for words in ("nodes 1 to 6, 400 Hz", "nodes 7 to 12, 400 Hz", "total")] == [1, 1, 2]


def test_dbc_is_written_whole_to_the_terminal_or_a_file(joints, run_json, tmp_path):
    code, out, _ = joints("dbc")
    assert code == 0
    assert {m.name for m in parse(out)} > {"heartbeat_FR_hip", "setpoint_position_2", "e_stop"}
    path = tmp_path / "joints.dbc"
    assert run_json("joints", "dbc", "--out", str(path))[1]["bytes"] == len(out)
    assert path.read_text() == out
    assert joints("dbc", "--json")[0] == 2


def test_monitor_records(joints, refused, tmp_path):
    path = tmp_path / "joints.jsonl"
    code, out, _ = joints("monitor", "--sim", "--seconds", "0.3", "--out", str(path))
    assert (code, out.count("RL calf"), out[-1]) == (0, 1, "\n"), "in a file the last table alone"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert len(lines) >= 3
    assert len(lines[0]["joints"]) == 12
    before = path.read_bytes()
    line = refused("joints", "monitor", "--sim", "--seconds", "0.3", "--out", str(path))
    assert "the file exists: name another" in line
    assert path.read_bytes() == before, "a record is never overwritten"


@pytest.fixture
def shared_bus():
    sim = SimRobot(load_robot("parallel"))
    with AdapterPort("virtual", "caramelo-gateway", 1_000_000) as port:
        yield Gateway(sim, port)
    sim.close()


def test_joints_behind_a_bus_answer_as_real_ones_and_faults_are_told(run_json, shared_bus):
    shared_bus.inject("under-voltage:4@0.01")
    shared_bus.inject("e-stop:6@0.02")
    thread = threading.Thread(target=shared_bus.run, args=(10.0,), daemon=True)
    thread.start()
    stopped, volts = set(), {}
    while thread.is_alive() and not (len(stopped) == 12 and 3 in volts):
        code, found, _ = run_json("joints", "status", "--interface", "virtual", "--channel", "caramelo-gateway")
        rows = found["joints"]
        stopped |= {i for i, row in enumerate(rows) if "emergency" in row["fault"] or i in (3, 5)}
        volts |= {i: row["bus_V"] for i, row in enumerate(rows) if row.get("bus_V")}
    shared_bus.stopping = True
    thread.join(PATIENCE_S)
    assert code == 1
    assert len(stopped) == 12
    assert volts[3] == pytest.approx(12.0, abs=0.3)


@pytest.fixture
def without_a_joint(shared_bus):
    """Options for a bus on which the FL thigh has no power."""
    power_off(shared_bus.sim, [5])
    thread = threading.Thread(target=shared_bus.run, args=(None,), daemon=True)
    thread.start()
    yield ("--interface", "virtual", "--channel", "caramelo-gateway")
    shared_bus.stopping = True
    thread.join(PATIENCE_S)


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ("disarm", "not confirmed to have let go: FL thigh (node 5): check power"),
        ("clear", "FL thigh (node 5) is not there"),
    ],
)
def test_a_joint_that_is_silent_is_not_taken_for_one_that_has_obeyed(refused, without_a_joint, command, words):
    assert words in refused("joints", command, *without_a_joint, code=1)


def test_parameters_that_no_file_takes_are_not_saved_either(refused, tmp_path, monkeypatch):
    asked = []
    monkeypatch.setattr("host.bus.can.service.Requests.demand", lambda self, node, command, *_: asked.append(command))
    monkeypatch.setattr("host.bus.can.params.read_kept", lambda requests, node: {})
    refused("joints", "params", "save", "5", "--sim", "--file", str(tmp_path))
    assert asked == []


def test_two_buses_are_simulated_with_their_faults(joints):
    """The rear legs' joint on the second bus gets hot; a machine that is too slow only says so."""
    words = ("--interface", "virtual", "--channel", "caramelo-front,caramelo-rear", "--fault", "hot:9@0.01")
    heard = []
    with (
        AdapterPort("virtual", "caramelo-rear", 1_000_000) as rear,
        AdapterPort("virtual", "caramelo-front", 1_000_000) as front,
    ):
        assert joints("sim", *words, "--seconds", "0.5")[0] == 0
        for port in (front, rear):
            heard.append(set())
            while (frame := port.receive()) is not None:
                heard[-1].add(frame.identifier)
    heartbeats = [{node for node in range(1, 13) if HEARTBEAT_ID + node in identifiers} for identifiers in heard]
    assert heartbeats == [set(range(1, 7)), set(range(7, 13))]


@pytest.mark.parametrize("fault", ["melt:3@1", "e-stop:13@1", "e-stop", "power-off:2@-1", "hot:2@inf", "hot:2@nan"])
def test_a_fault_that_is_none_is_refused(shared_bus, fault):
    with pytest.raises(UserError, match="--fault"):
        shared_bus.inject(fault)
