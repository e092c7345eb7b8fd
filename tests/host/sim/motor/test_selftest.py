"""The board's self-test on the model of the chip: a sound board passes, and whatever is wrong with one is named."""

import pytest

from firmware import chip_io, chip_setup, joint_selftest
from firmware.board_stm32f405 import Stm32F405Board
from firmware.joint_selftest import measure
from host.boards import joint_selftest as selftest
from host.boards.joint_selftest import judge
from host.cli import main
from host.sim.chip.drv8323 import FAULT1
from host.sim.chip.joint_board import JointBoard

CALL_CYCLES = 400  # of bytecode between two looks at the clock
FEWER = 200


def measured(board=None, bridge=False):
    board = board or JointBoard()
    driver = Stm32F405Board(board)
    clock = driver.ticks_us
    driver.ticks_us = lambda: (board.work(CALL_CYCLES), clock())[1]
    return measure(driver, bridge)


def fewer(monkeypatch, steps):
    for module in (joint_selftest, selftest):
        monkeypatch.setattr(module, "STEPS", steps)


def outside(figures):
    return [row.name for row in judge(figures) if not row.ok]


@pytest.fixture
def fewer_steps(monkeypatch):
    """A board that is wrong shows it in a tenth of the steps."""
    fewer(monkeypatch, FEWER)


def test_a_sound_board_passes_and_its_bridge_is_off_in_the_end():
    board = JointBoard()
    board.shunts = [2040, 2051, 2063]
    figures = measured(board, bridge=True)
    assert outside(figures) == []
    assert figures["steps"] >= 2 * joint_selftest.STEPS == 2 * selftest.STEPS
    assert board.model.complaints == []
    assert board.model.resets == []
    assert board.gates == "000000"


@pytest.mark.usefixtures("fewer_steps")
def test_without_the_bridge_no_gate_moves():
    board = JointBoard()
    seen = []
    driver = Stm32F405Board(board)
    for pin in ("PA8", "PB13", "PA9", "PB14", "PA10", "PB15"):
        board.model.pins.watch(pin, seen.append)
    clock = driver.ticks_us
    driver.ticks_us = lambda: (board.work(CALL_CYCLES), clock())[1]
    assert "bridge_on" not in measure(driver)
    assert seen == []


def stuck_driver(board):
    write = board.driver._write
    board.driver._write = lambda address, value: None if address == 5 else write(address, value)


def uneven(board):
    real, count = board._serve, iter(range(1 << 30))

    def serve():
        board.entry_cycles = 300 + 3000 * (next(count) % 50 == 49)
        real()

    board._serve = serve


def silent_adc(board):
    adc = board.model.adcs["ADC1"]
    real = adc._trigger
    adc._trigger = lambda group: real(group) if group == "injected" else None


WRONG = {
    "gate driver reads back": stuck_driver,
    "gate driver faults": lambda board: board.model.at(2_000_000, lambda: board.driver.raise_fault(FAULT1, 1)),
    "longest time between steps, us": uneven,
    "update to first instruction, ns": lambda board: setattr(board, "entry_cycles", 2000),
    "update to end of the step, ns": lambda board: setattr(board, "entry_cycles", 7000),
    "rotor readings that failed": lambda board: setattr(board.rotor, "respond", lambda command: 0xFFFF),
    "joint encoder, counts": lambda board: setattr(board.joint, "respond", lambda command: 0xFFFF),
    "supply, V": lambda board: setattr(board, "bus", 0),
    "thermistor, counts": lambda board: setattr(board, "thermistor", 4095),
    "temperature sensor of the microcontroller, counts": silent_adc,
    "shunt b at no current, counts": lambda board: board.shunts.__setitem__(1, 2048 + 260),
    "shunt c noise, counts peak to peak": lambda board: board.shunts.__setitem__(2, lambda cycle: 2048 + cycle % 31),
}


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.usefixtures("fewer_steps")
def test_what_is_wrong_with_a_board_is_named(name):
    board = JointBoard()
    WRONG[name](board)
    assert name in outside(measured(board))


def off_by_itself(board):
    """nFAULT falls for a moment while the bridge switches, and the gate driver remembers nothing."""

    def pulse():
        board.model.pins.drive_pin("PB12", 0)
        board.model.pins.drive_pin("PB12", 1)

    board.model.at(board.model.now + 11_000_000, pulse)


WRONG_WHILE_ON = {
    "bridge stayed on": off_by_itself,
    "shunt a with the bridge on, shift in counts": lambda board: board.shunts.__setitem__(
        0, lambda cycle: 2048 + 9 * board.outputs_on),
    "shunt c with the bridge on, noise, counts peak to peak": lambda board: board.shunts.__setitem__(
        2, lambda cycle: 2020 + cycle // 16_800 * 7 % 57 * board.outputs_on),
}  # fmt: skip


@pytest.mark.parametrize("name", WRONG_WHILE_ON)
def test_what_is_wrong_with_a_bridge_is_named(monkeypatch, name):
    fewer(monkeypatch, FEWER * 2)
    board = JointBoard()
    WRONG_WHILE_ON[name](board)
    assert name in outside(measured(board, bridge=True))


@pytest.mark.usefixtures("fewer_steps")
def test_a_bridge_whose_gate_driver_is_not_set_up_stays_off():
    board = JointBoard()
    stuck_driver(board)
    figures = measured(board, bridge=True)
    assert {"gate driver reads back", "bridge stayed on"} <= set(outside(figures))
    assert "on_low" not in figures


@pytest.mark.parametrize(
    ("module", "name", "value", "row"),
    [
        (chip_setup, "_FOURTH", 1, f"time of {FEWER} steps, us"),
        (chip_setup, "_INJECTED_BY_TRGO", 0x00100001, f"steps without new samples, of {FEWER}"),
        (chip_io, "_SWSTART_HALF", 0, "supply, V"),
    ],
)
@pytest.mark.usefixtures("fewer_steps")
def test_what_is_wrong_with_a_driver_is_named(monkeypatch, module, name, value, row):
    assert getattr(module, name) != value
    monkeypatch.setattr(module, name, value)
    assert row in outside(measured())


@pytest.mark.usefixtures("fewer_steps")
def test_a_figure_of_the_code_itself_is_judged_too():
    figures = measured()
    figures["step_ns"], figures["failed"], figures["steps"] = 10_001, 1, FEWER - 1
    assert outside(figures) == ["steps that failed", "current steps", "current step alone, ns"]


def test_the_script_that_is_sent_asks_for_what_was_asked():
    for bridge in (False, True):
        compile(selftest.SCRIPT % bridge, "script", "exec")
        assert f"run({bridge})" in selftest.SCRIPT % bridge


def test_a_port_that_is_none_is_one_line(capsys):
    assert main(["motor", "selftest", "--port", "/dev/null"]) != 0
    assert capsys.readouterr().err.count("\n") == 1
