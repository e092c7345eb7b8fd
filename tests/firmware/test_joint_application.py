"""The joint's application over its bus: sessions, set-points, requests, status, storage, faults."""

from array import array

import pytest

from firmware import joint_store
from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.joint_service import HOME_POSE
from firmware.settings import Memory
from host.protocol import parameters
from host.robot.file import load_robot
from host.sim.motor.bench import SESSION, Bench
from shared.joint import faults as f
from shared.record import pack, unpack
from shared.wire import codec
from shared.wire import names as w
from shared.wire.parameters import PARAMETER_DEFAULT, PARAMETER_NODE_ID, PARAMETER_UPTIME

ID = {parameter.name: parameter.id for parameter in parameters.load()}
BLDC = load_robot("parallel").actuator


@pytest.fixture
def bench():
    return Bench(BLDC)


def frames(board):
    """Return what the joint has sent, as (identifier, words)."""
    found, frame = [], array("H", [0] * 4)
    while True:
        identifier = board.sent.take(frame)
        if identifier < 0:
            return found
        found.append((identifier, array("H", frame)))


def decoded(found, identifier, decode, values):
    for known, frame in found:
        if known == identifier:
            assert decode(frame, values) == 0
            return values
    return None


def ask(bench, command, index=0, value=0):
    """Send a request and return (result, index, value) of its answer."""
    result = bench.request(command, index, value)
    response = bench.joint.service._response
    return result, response.index, response.value


def deliver(bench, identifier, words=(0, 0, 0, 0), length=8):
    bench.board.deliver(identifier, array("H", words), length)


def send_request(bench, request, identifier=w.SERVICE_REQUEST_ID):
    """Put a request of these integers on the bus, to all joints or to one, and wait for no answer."""
    frame = array("H", [0] * 4)
    codec.encode_service_request(frame, unpack(codec.ServiceRequest(), request))
    deliver(bench, identifier, frame)
    bench.run(1)


def responses(bench):
    """Return the words of the answers that the joint has sent."""
    return [words for identifier, words in frames(bench.board) if identifier == w.SERVICE_RESPONSE_ID + 1]


def test_it_arms_follows_and_disarms(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.goal += 0.1
    bench.run(400)
    assert abs(bench.motor.joint_rad - bench.goal) < 0.004
    assert bench.request(w.COMMAND_DISARM) == w.RESULT_OK
    bench.run(3)
    assert (bench.state.drive_state, bench.board.bridge) == (w.STATE_SWITCH_ON_DISABLED, 0)
    assert bench.joint.control.io.session == 0


def test_a_reply_and_status_say_what_is(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    frames(bench.board)
    bench.run(220)
    found = frames(bench.board)
    position = decoded(found, w.REPLY_ID + 1, codec.decode_reply, codec.Reply()).position
    assert abs(position / 65536 * 360 - bench.motor.joint_rad * 57.29578) < 0.1
    status = decoded(found, w.SLOW_STATUS_ID + 1, codec.decode_slow_status, codec.SlowStatus())
    assert abs(status.winding_temperature / 16 - 25) < 1
    assert abs(status.bus_voltage / 16 - 24) < 0.2
    beat = decoded(found, w.HEARTBEAT_ID + 1, codec.decode_heartbeat, codec.Heartbeat())
    assert (beat.state, beat.mode, beat.fault) == (w.STATE_OPERATION_ENABLED, w.MODE_POSITION, 0)
    assert (beat.protocol_hash, beat.session) == (w.PROTOCOL_HASH, SESSION)


@pytest.mark.parametrize(
    ("value", "session", "send", "result"),
    [
        (w.PROTOCOL_HASH ^ 1, SESSION, True, w.RESULT_WRONG_HASH),
        (w.PROTOCOL_HASH, 0, True, w.RESULT_NO_SESSION),
        (w.PROTOCOL_HASH, SESSION, False, w.RESULT_NO_SETPOINT),
    ],
)
def test_arming_is_refused_with_its_reason_and_leaves_nothing(bench, monkeypatch, value, session, send, result):
    monkeypatch.setattr("host.sim.motor.bench.SESSION", session)
    if send:
        bench.mode, bench.goal = w.MODE_POSITION, bench.motor.joint_rad
        bench.run(20)
    assert bench.request(w.COMMAND_ARM, value=value) == result
    assert bench.joint.control.io.session == 0
    bench.run(10)
    assert bench.state.drive_state == w.STATE_SWITCH_ON_DISABLED


@pytest.mark.parametrize("command", [w.COMMAND_ARM, w.COMMAND_COMMISSION, w.COMMAND_HOME])
def test_without_the_challenge_of_now_nothing_is_armed_commissioned_or_homed(bench, command):
    bench.mode, bench.goal = w.MODE_POSITION, bench.motor.joint_rad
    bench.run(20)
    old = bench.joint.service.challenge
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    assert bench.joint.service.challenge != old
    armed = bench.joint.service.challenge
    bench.request(w.COMMAND_DISARM)
    bench.run(20)
    now = bench.joint.service.challenge
    assert now != armed
    for challenge in (old, armed, now ^ 1, now ^ 0x2000, 0 if now else 1):
        value = challenge << 16 | w.PROTOCOL_HASH
        assert bench.ask(command, 0, value) == w.RESULT_WRONG_CHALLENGE
        assert bench.ask(command, 0, value - (1 << 30)) == w.RESULT_WRONG_CHALLENGE
    bench.run(10)
    assert bench.state.drive_state == w.STATE_SWITCH_ON_DISABLED
    assert bench.board.bridge == 0


def test_far_set_points_do_not_arm(bench):
    bench.mode, bench.goal = w.MODE_POSITION, bench.motor.joint_rad + 0.3
    bench.run(20)
    assert bench.request(w.COMMAND_ARM, value=w.PROTOCOL_HASH) == w.RESULT_FAR_FROM_SETPOINT


def test_a_request_repeated_is_answered_again_and_not_done_again(bench):
    service = bench.joint.service
    frames(bench.board)
    for _ in range(2):
        request = (w.COMMAND_WRITE_PARAMETER, 9, SESSION, ID["position_p"], 700)
        send_request(bench, request, w.SERVICE_REQUEST_ID + 1)
        bench.joint.parameters.put(ID["position_p"], 600)
    answers = responses(bench)
    assert len(answers) == 2
    assert answers[0] == answers[1]
    assert bench.joint.parameters.get(ID["position_p"]) == 600
    assert service.reboot == 0


def test_without_set_points_it_damps_coasts_and_latches(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.mode = 0
    bench.run(120)
    assert (bench.state.drive_state, bench.state.fault_code) == (w.STATE_FAULT_REACTION, f.FAULT_WATCHDOG)
    bench.run(600)
    assert (bench.state.drive_state, bench.board.bridge) == (w.STATE_FAULT, 0)
    record = decoded(frames(bench.board), w.FAULT_ID + 1, codec.decode_fault, codec.Fault())
    assert record.code == f.FAULT_WATCHDOG
    assert bench.request(w.COMMAND_CLEAR_FAULT) == w.RESULT_OK
    bench.run(5)
    assert bench.state.drive_state == w.STATE_SWITCH_ON_DISABLED


def test_polling_requests_do_not_feed_the_watchdog(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.mode = 0
    for _ in range(60):
        ask(bench, w.COMMAND_READ_PARAMETER, PARAMETER_UPTIME)
        bench.run(2)
    assert bench.state.fault_code == f.FAULT_WATCHDOG


@pytest.mark.parametrize("length", [0, 3, 8])
def test_an_emergency_stop_ends_the_torque_at_once(bench, length):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    deliver(bench, w.E_STOP_ID, length=length)
    bench.run(1)
    assert (bench.board.bridge, bench.state.drive_state) == (0, w.STATE_FAULT)
    assert bench.state.fault_code == f.FAULT_EMERGENCY_STOP
    bench.run(30)
    assert bench.request(w.COMMAND_CLEAR_FAULT) == w.RESULT_OK


def test_another_host_moves_nothing(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    sequence = bench.joint.control.io.sequence
    bench.mode = 0
    deliver(bench, w.SETPOINT_POSITION_ID, (4000, 0, 0, 0))
    frame = array("H", [0] * 4)
    codec.encode_sync(frame, unpack(codec.Sync(), (3, SESSION + 1)))
    bench.board.deliver(w.SYNC_ID, frame, 2)
    bench.run(2)
    assert bench.joint.control.io.sequence == sequence


def test_its_own_heartbeat_from_the_bus_means_a_twin(bench):
    deliver(bench, w.HEARTBEAT_ID + 1)
    bench.run(2)
    assert (bench.state.fault_code, bench.state.fault_value) == (f.FAULT_DUPLICATE_ID, 1)


def test_discovery_answers_after_its_delay_and_only_once(bench):
    board = bench.joint.service.board
    frames(bench.board)
    send_request(bench, (w.COMMAND_DISCOVER, 200, 0, 0, 0))
    delay = bench.joint.service.discover_ms
    bench.run(delay + 3)
    found = responses(bench)
    assert len(found) == 1
    values = codec.ServiceResponse()
    codec.decode_service_response(found[0], values)
    assert pack(values) == [w.COMMAND_DISCOVER, 200, w.RESULT_OK, 1, board]


def test_a_node_is_set_by_the_boards_number_only(bench):
    board = bench.joint.service.board
    assert ask(bench, w.COMMAND_SET_ID, 4, board ^ 1)[0] == w.RESULT_WRONG_KEY
    assert ask(bench, w.COMMAND_SET_ID, 13, board)[0] == w.RESULT_OUT_OF_RANGE
    send_request(bench, (w.COMMAND_SET_ID, 77, 0, 4, board))
    assert bench.joint.parameters.node == 4


def test_commands_to_all_move_nobody_else(bench):
    for command in (w.COMMAND_REBOOT, w.COMMAND_ARM, w.COMMAND_SAVE_PARAMETERS, w.COMMAND_DISARM):
        frames(bench.board)
        send_request(bench, (command, command, SESSION, 0, 0))
        assert responses(bench) == []
    assert bench.board.resets == 0


def test_parameters_are_read_written_and_refused(bench):
    assert ask(bench, w.COMMAND_READ_PARAMETER, PARAMETER_NODE_ID)[2] == 1
    assert ask(bench, w.COMMAND_WRITE_PARAMETER, PARAMETER_NODE_ID, 3)[0] == w.RESULT_READ_ONLY
    assert ask(bench, w.COMMAND_READ_PARAMETER, 250)[0] == w.RESULT_UNKNOWN_PARAMETER
    assert ask(bench, w.COMMAND_WRITE_PARAMETER, ID["accel"], 1 << 29)[0] == w.RESULT_OUT_OF_RANGE
    assert ask(bench, w.COMMAND_WRITE_PARAMETER, ID["accel"], 500)[0] == w.RESULT_OK
    assert ask(bench, w.COMMAND_READ_PARAMETER, ID["accel"])[2] == 500
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    assert ask(bench, w.COMMAND_SAVE_PARAMETERS)[0] == w.RESULT_NEEDS_DISARMED
    assert ask(bench, w.COMMAND_REBOOT)[0] == w.RESULT_NEEDS_DISARMED


def test_reboot_needs_the_boards_key_for_the_loader(bench):
    board = bench.joint.service.board
    assert ask(bench, w.COMMAND_REBOOT_TO_LOADER, 0, board ^ 1)[0] == w.RESULT_WRONG_KEY
    bench.run(2)
    assert bench.board.resets == 0
    assert ask(bench, w.COMMAND_REBOOT_TO_LOADER, 0, board)[0] == w.RESULT_OK
    assert (bench.board.resets, bench.board.to_loader) == (1, True)


def test_home_at_a_pose_is_refused_while_ambiguous(bench):
    wrong = round((bench.motor.joint_rad + 0.14) / 6.283185 * 65536)
    assert ask(bench, w.COMMAND_HOME, HOME_POSE, wrong)[0] == w.RESULT_NOT_HOMED
    right = round(bench.motor.joint_rad / 6.283185 * 65536)
    assert ask(bench, w.COMMAND_HOME, HOME_POSE, right)[0] == w.RESULT_OK


def changed(journal, values):
    """Return a joint with other values of parameters, by number; they are not saved yet."""
    joint = Joint(SimBoard(), journal)
    for parameter, value in values.items():
        joint.parameters.put(parameter, value)
    return joint


def test_the_encoders_eccentricity_survives_a_power_cycle_and_is_taken_out_of_readings():
    journal = Memory()
    assert changed(journal, {ID["bend_cos1"]: 800, ID["commissioned"]: 1}).parameters.save() == 1
    again = Joint(SimBoard(), journal)
    again.start()
    again.control.board.rotor = 50
    again.control.board.handler()
    assert again.control.loop.rotor in (99, 100)  # 800 / 16 rc more


def test_parameters_survive_a_power_cycle():
    journal = Memory()
    joint = changed(journal, {ID["accel"]: 777, PARAMETER_NODE_ID: 6})
    assert joint.loaded == joint_store.MISSING
    assert joint.parameters.save() == 1
    again = Joint(SimBoard(), journal)
    assert again.loaded == joint_store.LOADED
    assert (again.parameters.get(ID["accel"]), again.parameters.node) == (777, 6)


def test_every_broken_byte_is_noticed():
    journal = Memory()
    changed(journal, {ID["accel"]: 777}).parameters.save()
    whole = journal.get(joint_store.KEY)
    for at in [*range(40), len(whole) // 2, len(whole) - 1]:
        journal.put(joint_store.KEY, whole[:at] + bytes([whole[at] ^ 0x10]) + whole[at + 1 :])
        joint = Joint(SimBoard(), journal)
        assert joint.loaded == joint_store.BROKEN
        assert joint.parameters.get(ID["accel"]) == PARAMETER_DEFAULT[ID["accel"]]
    journal.put(joint_store.KEY, whole[:17])
    joint = Joint(SimBoard(), journal)
    joint.start()
    assert joint.control.io.hardware_fault == f.FAULT_STORAGE


def test_another_firmware_takes_what_it_knows_and_the_node(monkeypatch):
    journal = Memory()
    changed(journal, {118: 900, 119: 800, 120: 700, PARAMETER_NODE_ID: 6}).parameters.save()
    moved = list(joint_store.PARAMETER_KEY)
    moved[118], moved[119] = moved[119], moved[118]  # two have changed places
    moved[120] = 7  # one has another name, unit or scale
    monkeypatch.setattr(joint_store, "PARAMETER_KEY", moved)
    parameters = Joint(SimBoard(), journal).parameters
    assert Joint(SimBoard(), journal).loaded == joint_store.LOADED
    assert [parameters.get(at) for at in (118, 119, 120)] == [800, 900, PARAMETER_DEFAULT[120]]
    assert parameters.node == 6


def test_a_kept_value_out_of_its_range_is_noticed_and_the_node_stays(monkeypatch):
    journal = Memory()
    changed(journal, {118: 900, PARAMETER_NODE_ID: 6}).parameters.save()
    high = list(joint_store.PARAMETER_HIGH)
    high[118] = 899
    monkeypatch.setattr(joint_store, "PARAMETER_HIGH", high)
    joint = Joint(SimBoard(), journal)
    assert (joint.loaded, joint.parameters.node) == (joint_store.BROKEN, 6)
    assert joint.parameters.get(118) == PARAMETER_DEFAULT[118]


def test_saving_that_fails_is_told(monkeypatch):
    journal = Memory()
    joint = changed(journal, {ID["accel"]: 777})
    joint.parameters.save()
    joint.parameters.put(ID["accel"], 778)
    monkeypatch.setattr(journal, "put", lambda key, data: 0)
    assert joint.parameters.save() == 0
    assert Joint(SimBoard(), journal).parameters.get(ID["accel"]) == 777


@pytest.mark.parametrize(
    ("part", "method", "value"),
    [
        ("_sense", "motion", 2),
        ("read_thermistor", "slow", 3),
        ("can_receive", "bus", 4),
    ],
)
def test_any_exception_switches_the_bridge_off_first(bench, monkeypatch, part, method, value):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    order = []

    def fail(*args):
        order.append("failed")
        raise RuntimeError(method)

    real_off = bench.board.pwm_off
    monkeypatch.setattr(bench.board, part, fail)
    monkeypatch.setattr(bench.board, "pwm_off", lambda: (order.append("off"), real_off()))
    bench.run(101 if part == "read_thermistor" else 2)
    assert order[:2] == ["failed", "off"]
    assert bench.board.bridge == 0
    monkeypatch.undo()
    bench.run(3)
    assert (bench.state.fault_code, bench.state.fault_value) == (f.FAULT_EXCEPTION, value)


def test_a_main_loop_that_stops_loses_the_bridge(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    for _ in range(60):
        bench._step()
    assert bench.board.bridge == 0


def test_an_interrupt_that_stops_is_a_fault(bench):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.late_every = 1
    bench.run(6)
    assert (bench.board.bridge, bench.state.fault_code) == (0, f.FAULT_INTERRUPT_STOPPED)


@pytest.mark.parametrize(
    ("field", "value", "code"), [("driver", 5, f.FAULT_DRIVER), ("bus", 3900, f.FAULT_OVER_VOLTAGE)]
)
def test_what_the_board_reports_is_latched(bench, monkeypatch, field, value, code):
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    if field == "driver":
        bench.board.driver = value
    else:
        sense = bench.board._sense
        monkeypatch.setattr(bench.board, "_sense", lambda io: (sense(io), setattr(io, "bus_raw", value)))
    bench.run(10)
    assert (bench.board.bridge, bench.state.fault_code) == (0, code)


def test_a_driver_that_does_not_read_back_never_gets_ready_and_is_told():
    board = SimBoard()
    board.driver_wrong = 3
    joint = Joint(board, Memory())
    joint.set_node(1)
    joint.start()
    for _ms in range(100):
        for _ in range(10):
            board.now_us += 100
            board.handler()
        joint.poll()
    state = joint.control.state
    assert (state.drive_state, state.fault_code, state.fault_value) == (
        w.STATE_FAULT, f.FAULT_DRIVER_SETUP, 3,
    )  # fmt: skip
    assert w.FAULT_ID in {identifier & ~0xF for identifier, _ in frames(board)}


def test_parameters_that_are_broken_are_told_though_the_joint_was_not_ready_yet():
    bench = Bench(BLDC)
    bench.joint.control.start()
    bench.joint.control.raise_fault(f.FAULT_STORAGE, 0)
    bench.run(60)
    assert (bench.state.drive_state, bench.state.fault_code) == (w.STATE_FAULT, f.FAULT_STORAGE)
