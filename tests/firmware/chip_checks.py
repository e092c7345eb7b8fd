"""What must hold of driver and board, each as a function that fails if it does not; on the model of the chip.

They are apart from the tests, because each fault put back (test_faults_put_back.py) has to be caught by one of them.
"""

from array import array
from itertools import pairwise

from firmware import chip_io, chip_joint, joint_run
from host.sim.chip.bxcan import accept
from host.sim.chip.can_wire import Frame
from host.sim.chip.drv8323 import FAULT1
from host.sim.chip.joint_board import HALF_BRIDGES, SHUNT_CHANNELS, Restart
from shared.joint import faults as f
from shared.wire import names as w

from .on_chip import NODE, STEP_CYCLES, OnChip

DEAD_CYCLES = 17  # 100 ns are 16.8
SETTLED_CYCLES = 400  # 2.4 us: loop.window is 2.5 us from the compare, the low side comes on a dead time later
PERIOD = 4200
OPEN_DOUBTS = {("TIM1", "RCR")}  # told differently in two manuals; align_updates works with either reading


def clean(joint):
    """No complaint, and no doubt but the one that the driver is written round."""
    assert joint.complaints == []
    assert {(doubt.peripheral, doubt.register) for doubt in joint.model.doubts} <= OPEN_DOUBTS


def armed(**more):
    joint = OnChip(**more).begin()
    assert joint.arm() == w.RESULT_OK, joint.fault
    assert joint.state == w.STATE_OPERATION_ENABLED
    assert joint.board.outputs_on
    return joint


def started_without_complaint():
    joint = OnChip()
    assert joint.driver.wrong == 0
    joint.board.shunts = [2040, 2051, 2063]
    joint.begin()
    clean(joint)
    assert (joint.state, joint.fault) == (w.STATE_SWITCH_ON_DISABLED, (0, 0))
    assert [joint.control.loop.offset_q4[n] >> 4 for n in range(3)] == [2040, 2051, 2063]
    joint.run(110)  # the slow tick, with the driver's registers, is in it
    clean(joint)
    assert joint.fault == (0, 0)
    return joint


def armed_moves_its_gates():
    joint = armed()
    watched = watch_gates(joint)
    joint.run(3)
    clean(joint)
    assert all(len(changes) >= 100 for changes in watched.values())  # 60 periods, on and off
    return joint


def steps_come_at_the_top():
    """Update events at the top and nowhere else, 10 kHz to the cycle; samples with them, the handler after them."""
    joint = OnChip()
    joint.joint.start()
    begun = joint.model.now
    joint.run(20)
    updates = [(cycle, where) for cycle, where in joint.model.tim1.updates if cycle > begun]
    assert {where for _, where in updates} == {"top"}
    assert {b - a for (a, _), (b, _) in pairwise(updates)} == {STEP_CYCLES}
    cycles = [cycle for cycle, _ in updates]
    entries = [entry for entry in joint.board.entries if entry > cycles[0]]
    assert [entry - joint.board.entry_cycles for entry in entries] == cycles[: len(entries)]
    assert len(entries) >= len(cycles) - 1 >= 190
    for adc in joint.model.adcs.values():
        triggers = [s.trigger for s in adc.samples if s.group == "injected" and s.trigger > begun]
        assert triggers == cycles[: len(triggers)]
        assert len(triggers) >= len(cycles) - 1


def compares_act_a_whole_step_later():
    """What a step writes acts from the next update: STEP_CYCLES after the samples it was made from."""
    joint = armed()
    begun = joint.model.now
    joint.run(5)
    updates = [cycle for cycle, where in joint.model.tim1.updates if where == "top"]
    written_by_steps = [e for e in joint.model.tim1.effects if e[2] > begun]
    assert len(written_by_steps) >= 3 * 45
    for _channel, _value, written, acts in written_by_steps:
        sampled = max(cycle for cycle in updates if cycle < written)
        assert acts == sampled + STEP_CYCLES
        assert written - sampled < STEP_CYCLES // 4


def watch_gates(joint):
    """Return the changes of the six gates from now on: pin -> [(cycle, level)]."""
    changes = {pin: [] for pair in HALF_BRIDGES.values() for pin in pair}
    for pin, seen in changes.items():
        joint.model.pins.watch(pin, lambda level, seen=seen: seen.append((joint.model.now, level)))
    return changes


def gates_keep_their_dead_time():
    """Between one side off and the other on lie 100 ns, at all duties; both are never on."""
    joint = armed()
    changes = watch_gates(joint)
    for amps in (0.3, 1.5, -1.5):
        joint.goal = amps
        joint.run(8)
    clean(joint)
    for high, low in HALF_BRIDGES.values():
        level, off_at, rose = {high: 0, low: 0}, {high: None, low: None}, 0
        merged = sorted((cycle, value, pin) for pin in (high, low) for cycle, value in changes[pin])
        for cycle, value, pin in merged:
            other = low if pin == high else high
            if value == 1:
                assert level[other] != 1
                assert off_at[other] is None or cycle - off_at[other] >= DEAD_CYCLES
                rose += 1
            else:
                off_at[pin] = cycle
            level[pin] = value
        assert rose > 500


def duties_are_at_the_pins():
    """The high sides are on round the counter's bottom, as long as their own compare says, less the dead time."""
    joint = armed()
    changes, begun = watch_gates(joint), joint.model.now
    seen = []
    loop = joint.control.loop
    joint.run(6)
    effects = {}
    for channel, value, _, acts in joint.model.tim1.effects:
        if begun < acts < joint.model.now - STEP_CYCLES:
            effects.setdefault(acts, {})[channel] = value
    assert len(effects) >= 50
    for acts, values in effects.items():
        for channel, (high, _low) in enumerate(HALF_BRIDGES.values(), 1):
            ons = [cycle - acts for cycle, level in changes[high] if level == 1 and 0 <= cycle - acts < STEP_CYCLES]
            offs = [cycle - acts for cycle, level in changes[high] if level == 0 and 0 < cycle - acts <= STEP_CYCLES]
            value = values[channel]
            seen.append(value)
            assert ons == [n * PERIOD - value + DEAD_CYCLES for n in (1, 3)]
            assert offs == [n * PERIOD + value for n in (1, 3)]
    assert len(set(seen)) > 20
    assert [loop.duty[n] for n in range(3)] == [joint.model.tim1.value[f"CCR{n}"] for n in (1, 2, 3)]


def samples_lie_in_the_low_sides(turns=(0, 20, 45), amps=1.5):
    """Each sample that the current step uses is taken where its low side has been on for SETTLED_CYCLES and stays on.

    The voltage is at its limit and the rotor turns, so that duties go through their whole range and jump.
    """
    for turn in turns:
        _samples_at(turn, amps)


def _samples_at(turn, amps):
    joint = armed()
    joint.goal = amps
    joint.control.settings.has_joint_encoder = 0  # it does not turn with the rotor here
    used = {}
    real = joint_run.current_step

    def noted(rotor, invalid, loop):
        used.setdefault(joint.board.entries[-1] - joint.board.entry_cycles, loop.masked)
        return real(rotor, invalid, loop)

    begun, start = joint.model.now, joint.board.rotor_angle
    joint.board.rotor.angle = lambda cycle: start + turn * (cycle - begun) / STEP_CYCLES
    joint_run.current_step = noted
    try:
        joint.run(25)
    finally:
        joint_run.current_step = real
    assert joint.board.outputs_on, joint.fault
    ranges = {value for _, value, _, acts in joint.model.tim1.effects if acts > begun}
    assert min(ranges) < 100
    assert max(ranges) > PERIOD - 100
    looked_at = 0
    for check in joint.board.bridges.check_samples(SHUNT_CHANNELS):
        mask = used.get(check.sample.trigger)
        if mask is not None and not mask >> "abc".index(check.phase) & 1:
            assert check.inside(SETTLED_CYCLES), check
            looked_at += 1
    assert looked_at > 500


def sensors_are_read():
    """Both encoders, bus, thermistor and the chip's temperature, each its own value, with the times they ask for."""
    joint = OnChip()
    board = joint.board
    board.rotor_angle, board.joint_angle, board.bus, board.thermistor, board.mcu = 9001, 5003, 2207, 1809, 977
    assert (joint.driver.read_rotor(), joint.driver.read_joint()) == (9001, 5003)  # the first words already
    joint.begin(4)
    io = joint.control.io
    assert (joint.control.loop.rotor, io.joint_raw, io.joint_valid) == (9001, 5003, 1)
    assert (io.bus_raw, io.thermistor_raw, io.mcu_raw) == (2207, 1809, 977)
    assert joint.control.loop.glitches == 0
    board.rotor_angle, board.bus = 9011, 2210
    joint.run(3)
    assert (joint.control.loop.rotor, io.bus_raw) == (9011, 2210)
    clean(joint)


def a_trigger_that_stops_ends_the_torque():
    joint = armed()
    for adc in joint.model.adcs.values():
        adc.write(0x08, adc.value["CR2"] & ~(3 << 20), 4)
    joint.steps(joint_run.STALE_MOST + 2)
    assert not joint.board.outputs_on
    joint.run(3)
    assert joint.fault == (f.FAULT_EXCEPTION, joint_run.PART_STEP)
    assert joint.state == w.STATE_FAULT


def an_adc_that_does_not_end_ends_the_torque():
    joint = armed()
    adc = joint.model.adcs["ADC1"]
    adc._trigger = lambda group: None
    joint.run(8)
    assert not joint.board.outputs_on
    assert joint.fault[0] == f.FAULT_EXCEPTION
    assert joint.model.resets == []


def an_adc_that_is_silent_from_the_start_keeps_it_from_ready():
    """The joint comes up on the bus and says what is wrong, rather than not at all."""
    joint = OnChip()
    adc = joint.model.adcs["ADC1"]
    real = adc._trigger
    adc._trigger = lambda group: real(group) if group == "injected" else None
    joint.begin(60)
    assert joint.control.io.hardware_fault == f.FAULT_EXCEPTION
    assert joint.from_joint(w.HEARTBEAT_ID + NODE)
    assert joint.arm() != w.RESULT_OK
    assert (joint.state, joint.fault[0]) == (w.STATE_FAULT, f.FAULT_EXCEPTION)
    assert not joint.board.outputs_on


def an_encoder_that_is_silent_ends_the_torque():
    """SPI 1 without its clock: no word ends. The step goes on in its time, the fault is told."""
    joint = armed()
    joint.model.spis["SPI1"].write_DR = None
    joint.model.spis["SPI1"]._writers.pop(0x0C)
    joint.run(4)
    assert not joint.board.outputs_on
    assert joint.fault[0] == f.FAULT_ENCODER_LOST
    took = [end - entry for entry, end in zip(joint.board.entries, joint.board.exits, strict=False)]
    assert max(took[-10:]) < STEP_CYCLES // 2
    assert all(b - a == STEP_CYCLES for a, b in pairwise(joint.board.entries[-10:]))


def a_joint_encoder_that_goes_silent_is_a_fault():
    joint = armed()
    joint.board.joint.respond = lambda command: 0xFFFF
    joint.run(joint_run.INVALID_MS + 3)
    assert joint.fault == (f.FAULT_JOINT_ENCODER_LOST, joint_run.INVALID_MS + 1)
    assert joint.state == w.STATE_FAULT_REACTION  # the rotor's encoder still answers, so it damps


def a_joint_encoder_that_never_answers_is_a_fault():
    joint = OnChip()
    joint.board.joint.respond = lambda command: 0xFFFF
    joint.begin()
    joint.run(joint_run.INVALID_MS)
    assert joint.fault[0] == f.FAULT_JOINT_ENCODER_LOST
    assert (joint.state, joint.board.outputs_on) == (w.STATE_FAULT, False)


def a_stuck_wire_ends_the_torque(level):
    joint = armed()
    joint.board.rotor.respond = lambda command: 0xFFFF * level
    joint.run(4)
    assert not joint.board.outputs_on
    assert joint.fault[0] == f.FAULT_ENCODER_LOST


def a_fault_of_the_driver_needs_no_software():
    joint = armed()
    joint.board.driver.raise_fault(FAULT1, 1 << 5)
    assert not joint.board.outputs_on  # in the same cycle, before any instruction
    assert joint.board.gates == "000000"
    joint.run(3)
    assert joint.fault == (f.FAULT_DRIVER, 1 << 10 | 1 << 5)
    assert joint.state == w.STATE_FAULT
    assert joint.board.gates == "000000"


def a_trip_while_the_bridge_goes_on_wins():
    """An interrupt between the decision to switch on and the register that does it sees far too much current."""
    joint = OnChip().begin()
    real = chip_joint.write_compares
    tripped = []

    def late(chip, loop):
        real(chip, loop)
        if not joint.board.handling and not tripped:
            joint.board.shunts = [4000, 100, 2048]
            while not loop.tripped:
                joint.board.work(100)
            tripped.append(joint.model.now)

    seen = []
    joint.model.pins.watch("PA8", seen.append)  # a high side: nothing drives the motor, not even once
    chip_joint.write_compares = late
    try:
        joint.arm()
    finally:
        chip_joint.write_compares = real
    assert len(tripped) == 1
    assert not joint.board.outputs_on
    assert joint.fault[0] in (f.FAULT_OVER_CURRENT, f.FAULT_CURRENT_SENSE)
    assert seen == []


def pins_without_torque_are_low():
    """Whenever the bridge is off its six pins are driven low, not left floating; before the timer has them too."""
    joint = OnChip()
    assert joint.board.gates == "000000"
    joint.begin()
    assert joint.board.gates == "000000"
    assert joint.arm() == w.RESULT_OK
    joint.driver.pwm_off()
    joint.board.work(DEAD_CYCLES + 1)
    assert joint.board.gates == "000000"


def registers_of_the_driver_are_read_back():
    for stuck in (3, 4, 5, 6):
        joint = OnChip()
        joint.board.driver._write = lambda address, value, d=joint.board.driver, stuck=stuck: (
            None if address == stuck else d.registers.__setitem__(address, value & ~1 if address == 2 else value)
        )
        joint.begin(5)
        io = joint.control.io
        assert (io.hardware_fault, io.hardware_value) == (f.FAULT_DRIVER_SETUP, stuck)
        joint.run(30)
        assert (joint.state, joint.fault) == (w.STATE_FAULT, (f.FAULT_DRIVER_SETUP, stuck))
        assert joint.from_joint(w.FAULT_ID + NODE)
        assert joint.arm() != w.RESULT_OK
        assert not joint.board.outputs_on


def filters_pass_what_the_joint_needs():
    """All 2048 identifiers, data and remote, and as many extended ones; node 0 and nodes of each group."""
    for node in (0, 1, 4, 5, 12):
        joint = OnChip()
        joint.joint.set_node(node)
        group = {0x100 + 8 * ((node - 1) // 4) + kind for kind in range(8)} if node else set()
        own = {w.HEARTBEAT_ID + node, w.REPLY_ID + node} if node else set()
        update = {w.UPDATE_REQUEST_ID + node} if node else set()  # in that queue because there is a place in its bank
        ordered = {w.E_STOP_ID, w.SYNC_ID} | group | update
        wanted = ordered | own | {w.SERVICE_REQUEST_ID, w.SERVICE_REQUEST_ID + node}
        banks = joint.model.can1.banks()
        assert not joint.model.can1.value["FMR"] & 1
        for number in range(2048):
            passed = accept(banks, Frame(number))
            assert (passed is not None) == (number in wanted), hex(number)
            assert passed is None or passed == (number not in ordered), hex(number)
            for frame in (
                Frame(number, remote=True),
                Frame(number << 18, extended=True),
                Frame(number << 18 | 0x2A5A5, extended=True),
                Frame(number << 18, extended=True, remote=True),
            ):
                assert accept(banks, frame) is None, hex(number)


def frames_keep_their_bytes():
    """Both ways over the wire, every length, identifiers at both ends of their range."""
    joint = OnChip()
    joint.board.run(1)
    frame = array("H", [0] * 4)
    joint.heard.clear()
    for length in range(9):
        payload = bytes(17 * n + length for n in range(1, length + 1))
        joint.send(w.SYNC_ID, payload)
        joint.board.run(0.3)
        came = chip_io.receive(joint.board.chip, frame)
        assert came == w.SYNC_ID | length << 11
        assert frame.tobytes()[:length] == payload
        assert chip_io.receive(joint.board.chip, frame) == -1
        identifier = 0x7FF - 200 * length
        words = array("H", [0x0201, 0xFFFE, 0x8000, length])
        assert chip_io.send(joint.board.chip, identifier, words, length) == 1
        joint.board.run(0.3)
        sender, sent = joint.heard[-1]
        assert (sender, sent.identifier, sent.data) == ("CAN1", identifier, words.tobytes()[:length])
        assert not sent.extended
        assert not sent.remote
    clean(joint)


def setpoints_keep_their_order_with_sync():
    """A set-point and its SYNC that wait together are used together, and the last of them holds."""
    joint = OnChip().begin()
    for number in range(5):
        joint.goal = 0.2 + 0.1 * number
        wanted = round(joint.goal * 4096)
        joint.send_goal()
        joint.goal = None
        joint.board.run(0.8)  # both in before the main loop looks
        joint.run(1)
        assert joint.control.io.mode == w.MODE_CURRENT
        assert joint.control.io.current == wanted
        assert joint.control.io.sequence == number + 1


def mailboxes_run_full_and_empty():
    joint = OnChip()
    joint.board.run(1)
    words, chip = array("H", [0] * 4), joint.board.chip
    joint.heard.clear()
    taken = [chip_io.send(chip, 0x201, words, 6) for _ in range(5)]
    assert taken == [1, 1, 1, 0, 0]
    joint.board.run(1)
    assert len(joint.from_joint(0x201)) == 3
    assert chip_io.send(chip, 0x201, words, 6) == 1


def an_overrun_loses_frames_and_nothing_else():
    joint = OnChip().begin()
    joint.goal = None
    for _ in range(10):
        joint.send(w.SYNC_ID, bytes(2))
    joint.board.run(2)  # the main loop is busy
    assert joint.model.can1.value["RF0R"] & 1 << 4
    joint.run(2)
    assert not joint.model.can1.fifo[0]
    assert joint.arm() == w.RESULT_OK


def bus_off_and_back():
    joint = OnChip().begin()
    joint.model.can1.wire.disturb = 40
    joint.model.can1.tec = 240
    joint.run(1)
    for _ in range(300):
        if joint.driver.bus_off():
            break
        joint.run(1)
    assert joint.driver.bus_off() == 1
    joint.model.can1.wire.disturb = 0
    joint.run(5)
    assert joint.driver.bus_off() == 1
    assert not joint.model.can1.bus_off
    assert joint.arm() == w.RESULT_OK


def the_watchdog_waits_as_stated():
    """Fed while steps happen; a main loop that hangs resets the chip within 136 to 378 ms, and never before 130."""
    for lsi_hz in (47_000, 32_000, 17_000):
        joint = OnChip(lsi_hz=lsi_hz).begin(10)
        low, high = joint.model.iwdg.timeout_range_s
        assert 0.130 < low < 0.140
        assert 0.370 < high < 0.380
        if lsi_hz != 47_000:
            joint.model.tim1.write(0, 0xA0, 4)  # hang with the timer too: that is sooner simulated
        _hangs(joint, joint.model.now, 201 * 32 / lsi_hz)
        clean(joint)


def _hangs(joint, fed, expected_s):
    try:
        joint.board.run(400)
    except Restart:
        waited_s = (joint.model.resets[-1][0] - fed) / 168e6
        assert expected_s - 0.0021 < waited_s <= expected_s
        assert waited_s > 0.130
        assert joint.board.reset_cause() == 4
        assert set(joint.board.gates) == {"-"}  # inputs; the gate driver pulls them low
        return
    raise AssertionError("the watchdog did not reset the chip")


def the_watchdog_is_not_fed_without_steps():
    joint = OnChip(lsi_hz=47_000).begin(10)
    joint.board._timer.callback(lambda timer: None)
    try:
        joint.run(150)
    except Restart:
        assert joint.board.reset_cause() == 4
        return
    raise AssertionError("fed although no current step happens")


CHECKS = (
    started_without_complaint, armed_moves_its_gates, steps_come_at_the_top, compares_act_a_whole_step_later,
    gates_keep_their_dead_time, duties_are_at_the_pins, samples_lie_in_the_low_sides, sensors_are_read,
    a_trigger_that_stops_ends_the_torque, an_adc_that_does_not_end_ends_the_torque,
    an_adc_that_is_silent_from_the_start_keeps_it_from_ready, an_encoder_that_is_silent_ends_the_torque,
    a_joint_encoder_that_goes_silent_is_a_fault, a_joint_encoder_that_never_answers_is_a_fault,
    a_fault_of_the_driver_needs_no_software, a_trip_while_the_bridge_goes_on_wins, pins_without_torque_are_low,
    registers_of_the_driver_are_read_back, filters_pass_what_the_joint_needs, frames_keep_their_bytes,
    setpoints_keep_their_order_with_sync, mailboxes_run_full_and_empty, an_overrun_loses_frames_and_nothing_else,
    bus_off_and_back, the_watchdog_waits_as_stated, the_watchdog_is_not_fed_without_steps,
)  # fmt: skip
