"""The joint's whole firmware on the model of its chip: whoever wrote the model did not see the driver."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from firmware import chip_joint, chip_step, joint
from firmware.board_sim import SimBoard
from firmware.board_stm32f405 import Stm32F405Board
from firmware.encoders import angle_of, parity
from host.sim.chip.joint_board import JointBoard, Restart
from shared.joint import faults as f
from shared.wire import names as w
from tests import ROOT

from . import chip_checks
from .chip_checks import armed, clean
from .on_chip import NODE, OnChip


@pytest.mark.parametrize("check", chip_checks.CHECKS, ids=lambda check: check.__name__)
def test_on_the_model_of_the_chip(check):
    check()


@pytest.mark.parametrize("level", [0, 1])
def test_a_stuck_wire_ends_the_torque(level):
    chip_checks.a_stuck_wire_ends_the_torque(level)


@pytest.mark.parametrize("entry_cycles", [100, 300, 1400])
def test_it_runs_however_late_the_interrupt_is_entered(entry_cycles):
    running = armed(entry_cycles=entry_cycles)
    running.run(3)
    clean(running)
    assert running.state == w.STATE_OPERATION_ENABLED
    assert running.joint.control.run.failed_part == 0


@pytest.mark.parametrize("loop_cycles", [37, 911, 7001])
def test_it_does_not_matter_where_the_interrupt_meets_the_main_loop(loop_cycles):
    running = armed(loop_cycles=loop_cycles)
    running.run(2)
    clean(running)
    assert (running.state, running.fault) == (w.STATE_OPERATION_ENABLED, (0, 0))


def raising(*_):
    raise RuntimeError("planted")


@pytest.mark.parametrize(
    ("module", "name", "fault"),
    [
        (chip_joint, "sense", (f.FAULT_EXCEPTION, 2)),
        (chip_joint, "take_motion", (f.FAULT_EXCEPTION, 2)),
        (chip_joint, "receive", (f.FAULT_EXCEPTION, 4)),
        (joint, "what_to_tell", (f.FAULT_EXCEPTION, 4)),
        (chip_step, "take_step", (f.FAULT_INTERRUPT_STOPPED, 3)),
        (chip_step, "take_samples", (f.FAULT_INTERRUPT_STOPPED, 3)),
    ],
)
def test_every_exception_ends_with_the_outputs_off(monkeypatch, module, name, fault):
    """One in the main loop at once; one in the interrupt, which MicroPython then calls no more, within 4 ms."""
    running = armed()
    monkeypatch.setattr(module, name, raising)
    if module is chip_step:
        running.run(5)
        assert len(running.board._timer.uncaught) == 1
    else:
        running.board.run(1.1, running.joint.poll)
    assert not running.board.outputs_on
    assert running.board.gates == "000000"
    monkeypatch.undo()
    running.run(4)
    assert running.fault == fault
    assert not running.board.outputs_on


def test_an_exception_in_the_slow_tick_ends_with_the_outputs_off(monkeypatch):
    running = armed()
    monkeypatch.setattr(running.driver, "read_thermistor", raising)
    running.run(105)
    assert not running.board.outputs_on
    assert running.fault == (f.FAULT_EXCEPTION, 3)


def test_a_reset_over_the_bus_leaves_no_gate_driven_and_is_told_afterwards():
    running = OnChip().begin()
    with pytest.raises(Restart):
        running.request(w.COMMAND_REBOOT)
    assert not running.board.outputs_on
    assert set(running.board.gates) == {"-"}
    assert (running.board.reset_cause(), running.board.to_loader) == (3, False)
    again = OnChip(running.board).begin()
    clean(again)
    assert again.driver.RESET_CAUSE == 3
    assert again.arm() == w.RESULT_OK


def test_an_emergency_stop_ends_the_torque_at_once():
    running = armed()
    running.send(w.E_STOP_ID)
    running.board.run(0.3, running.joint.poll)
    assert not running.board.outputs_on
    running.run(2)
    assert running.fault[0] == f.FAULT_EMERGENCY_STOP


def test_a_motion_tick_that_stays_away_ends_the_torque():
    running = armed()
    running.steps(60)  # the main loop hangs
    assert not running.board.outputs_on


def test_sync_is_answered_and_status_is_told():
    running = armed()
    running.heard.clear()
    running.run(210)
    assert len(running.from_joint(w.REPLY_ID + NODE)) == 42  # one every 5 ms
    for identifier in (w.HEARTBEAT_ID, w.SLOW_STATUS_ID):
        assert len(running.from_joint(identifier + NODE)) >= 1
    clean(running)


def test_a_scope_shows_what_the_bring_up_page_says():
    """Times from the update event, in cycles; the page gives them in microseconds."""
    running = OnChip().begin(5)
    selects, begun = [], running.model.now
    running.model.pins.watch("PC6", lambda level: selects.append((running.model.now, level)))
    running.run(3)
    updates = [cycle for cycle, _ in running.model.tim1.updates if begun < cycle < running.model.now - 2000]
    frames = [(start, end) for start, end, *_ in running.model.spis["SPI1"].frames]
    assert len(updates) >= 29
    for update in updates:
        fell, rose = [(cycle - update, level) for cycle, level in selects if update < cycle < update + 16_800]
        assert (fell, rose[1]) == ((1204, 0), 1)  # 7.2 us
        assert 580 <= rose[0] - fell[0] <= 610  # 3.5 us
        ((start, end),) = [(a - update, b - update) for a, b in frames if update < a < update + 16_800]
        assert end - start == 16 * 32  # 3.05 us: 16 clocks at 5.25 MHz
        assert 59 <= start - fell[0] <= 80  # t_L, 0.35 us
    shunts = [s for s in running.model.adcs["ADC1"].samples if s.trigger in updates]
    assert {(s.trigger - s.trigger, s.latest - s.trigger, s.done - s.trigger) for s in shunts} == {(0, 144, 240)}


def test_what_the_factory_wrote_is_read():
    board = JointBoard()
    driver = Stm32F405Board(board)
    assert (driver.MCU_CAL1, driver.MCU_CAL2) == (959, 1207)
    assert driver.unique_id() == bytes.fromhex("41003300075136343735 3237".replace(" ", ""))


def test_an_encoder_checks_parity_error_flag_and_an_idle_line():
    for angle in (0, 1, 8191, 16383):
        word = angle | parity(angle) << 15
        assert angle_of(word) in (angle, -1 if word == 0xFFFF else angle)
        assert angle_of(word ^ 0x8000) == -1
        assert angle_of(word | 0x4000) == -1
    assert angle_of(0xFFFF) == -1


def test_the_board_has_all_of_the_simulated_ones_interface():
    tools = {  # of the simulation, and what the chip does in millisecond() and listen()
        "deliver", "now_us", "handler", "raw", "rotor", "joint", "bus", "thermistor", "mcu", "driver", "driver_wrong",
        "compare", "bridge", "fed", "resets", "to_loader", "filters", "sent", "can_receive",
    }  # fmt: skip
    sim = SimBoard()
    wanted = {name for name in dir(sim) if not name.startswith("_")} - tools
    found = OnChip().begin(1).driver
    assert wanted <= set(dir(found))
    assert len(wanted) > 15


def test_the_firmware_type_checks_against_the_micropython_stubs():
    checker = shutil.which("basedpyright", path=str(Path(sys.executable).parent))
    if checker is None:
        pytest.skip("basedpyright is not installed")
    config = ROOT / "tests/firmware/pyrightconfig.json"
    ran = subprocess.run(
        [checker, "-p", str(config), "--pythonpath", sys.executable], capture_output=True, text=True, timeout=300
    )
    assert ran.returncode == 0, ran.stdout
