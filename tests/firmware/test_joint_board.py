"""The STM32F405 board against fake registers and chips: what is written in which order, and what reads back wrong."""

import importlib
import shutil
import subprocess
import sys
import types
from array import array
from pathlib import Path
from typing import ClassVar

import pytest

from firmware import drv8323, registers
from firmware.encoders import MagneticEncoder, parity
from shared.joint.layout import F_DUTY_A, F_RAW_A, FOC_SIZE
from shared.wire.framing import FILTERS, joint_filters

ROOT = Path(__file__).resolve().parents[2]


class FakeMemory(dict):
    """Remembers every write in order; ``stuck`` addresses keep 0."""

    def __init__(self):
        super().__init__()
        self.log = []
        self.stuck = set()

    def __getitem__(self, address):
        return self.get(address, 0)

    def __setitem__(self, address, value):
        self.log.append((address, value))
        super().__setitem__(address, 0 if address in self.stuck else value)


class FakeStm:
    def __init__(self):
        self.mem32 = self.mem16 = FakeMemory()


class FakePin:
    OUT, IN, ALT, ANALOG, PULL_UP = range(5)
    made: ClassVar[list] = []

    def __init__(self, name, mode=IN, pull=0, value=None, alt=0):
        self.name, self.mode, self.level = name, mode, 1 if value is None else value
        FakePin.made.append(self)

    def __call__(self, level=None):
        if level is not None:
            self.level = level
        return self.level


class FakeDriverSpi:
    """A DRV8323 that answers; ``stuck`` registers do not take what is written."""

    def __init__(self, *args, **kwargs):
        self.values = dict.fromkeys(range(7), 0)
        self.stuck = set()
        self.writes = []

    def write_readinto(self, out, into):
        word = out[0] << 8 | out[1]
        register = word >> 11 & 15
        into[0] = into[1] = 0
        if word & 0x8000:
            into[0], into[1] = self.values[register] >> 8, self.values[register] & 0xFF
        else:
            self.writes.append((register, word & 0x7FF))
            if register not in self.stuck:
                self.values[register] = word & 0x7FE if register == 2 else word & 0x7FF


class FakeAngle:
    def __init__(self, word):
        self.word = word

    def write_readinto(self, out, into):
        assert (out[0], out[1]) == (0xFF, 0xFF)
        into[0], into[1] = self.word >> 8, self.word & 0xFF


class FakeCan:
    NORMAL = MASK16 = 0

    def __init__(self, *args, **kwargs):
        self.options, self.filters, self.sent, self.waiting = kwargs, {}, [], {0: [], 1: []}

    def setfilter(self, bank, mode, fifo, params):
        self.filters[bank] = (fifo, tuple(params))

    def any(self, fifo):
        return bool(self.waiting[fifo])

    def recv(self, fifo, into, timeout=5000):
        assert timeout == 0
        identifier, data = self.waiting[fifo].pop(0)
        into[0] = identifier
        into[4][: len(data)] = data

    def send(self, data, identifier):
        self.sent.append((identifier, bytes(data)))


class FakeTimer:
    CENTER = 32

    def __init__(self, number, **options):
        self.number, self.options, self.handler = number, options, None

    def callback(self, handler):
        self.handler = handler


@pytest.fixture
def board(monkeypatch):
    FakePin.made = []
    stm = FakeStm()
    stm.mem16[registers.TS_CAL1], stm.mem16[registers.TS_CAL2] = 940, 1190
    stm.mem16.log.clear()
    machine = types.SimpleNamespace(
        PWRON_RESET=1, HARD_RESET=2, SOFT_RESET=0, WDT_RESET=3, reset_cause=lambda: 3, unique_id=lambda: bytes(12),
        WDT=lambda timeout: types.SimpleNamespace(feed=lambda: None), SPI=FakeDriverSpi, Pin=FakePin,
    )  # fmt: skip
    pyb = types.SimpleNamespace(CAN=FakeCan, Timer=FakeTimer, delay=lambda ms: None)
    for name, module in (("stm", stm), ("machine", machine), ("pyb", pyb)):
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "firmware.board_stm32f405", raising=False)
    made = importlib.import_module("firmware.board_stm32f405").Stm32F405Board()
    made.memory = stm.mem32
    yield made
    monkeypatch.delitem(sys.modules, "firmware.board_stm32f405", raising=False)


def test_outputs_are_off_before_anything_else_is_set(board):
    address, value = board.memory.log[0]
    assert (address, value) == (registers.TIM1 + registers.BDTR, 0x0C00 | 17)
    assert value & registers.MOE == 0
    order = [address for address, _ in board.memory.log]
    outputs = order.index(registers.TIM1 + registers.CCER)
    assert outputs > order.index(registers.TIM1 + registers.CCMR1)
    assert outputs > order.index(registers.TIM1 + registers.CCR4)
    pins = [pin for pin in FakePin.made if pin.mode == FakePin.ALT]
    assert {pin.name for pin in pins} == {"PA8", "PA9", "PA10", "PB13", "PB14", "PB15"}


def test_the_timer_is_set_up_as_the_blocks_expect(board):
    memory = board.memory
    assert board._timer.options == {"prescaler": 0, "period": 4200, "mode": FakeTimer.CENTER}
    assert memory[registers.TIM1 + registers.RCR] == 3
    assert memory[registers.TIM1 + registers.CCR4] == 4199
    assert [memory[registers.TIM1 + c] for c in (registers.CCR1, registers.CCR2, registers.CCR3)] == [2100] * 3
    for number, base in enumerate((registers.ADC1, registers.ADC2, registers.ADC3)):
        assert memory[base + registers.ADC_JSQR] == (10 + number) << 15
        assert memory[base + registers.ADC_CR2] == 0x00100001


def test_a_register_that_does_not_read_back_is_named():
    stm = FakeStm()
    stm.mem32.stuck.add(registers.TIM1 + registers.CCER)
    r = registers.Registers(stm)
    r.setup_timer(4200, 17)
    assert r.wrong == registers.TIM1 + registers.CCER


def test_the_bridge_goes_on_and_off_without_touching_the_dead_time(board):
    board.pwm_on()
    assert board.memory[registers.TIM1 + registers.BDTR] == 0x8C00 | 17
    board.pwm_off()
    assert board.memory[registers.TIM1 + registers.BDTR] == 0x0C00 | 17


def test_compares_and_samples_go_where_the_blocks_say(board):
    foc = array("i", [0] * FOC_SIZE)
    for phase in range(3):
        foc[F_DUTY_A + phase] = 1000 + phase
    board.pwm_write(foc)
    assert [board.memory[registers.TIM1 + c] for c in (registers.CCR1, registers.CCR2, registers.CCR3)] == [
        1000,
        1001,
        1002,
    ]
    for phase, base in enumerate((registers.ADC1, registers.ADC2, registers.ADC3)):
        board.memory[base + registers.ADC_JDR1] = 2000 + phase
        board.memory[base] = registers.JEOC
    board.read_currents(foc)
    assert [foc[F_RAW_A + phase] for phase in range(3)] == [2000, 2001, 2002]


def test_a_trigger_that_stopped_is_an_error_and_not_an_old_current(board):
    foc = array("i", [0] * FOC_SIZE)
    for _ in range(3):
        board.read_currents(foc)
    with pytest.raises(OSError, match="5"):
        board.read_currents(foc)


def test_a_conversion_that_does_not_end_is_an_error(board):
    with pytest.raises(OSError, match="110"):
        board.read_bus()
    board.memory[registers.ADC1] = registers.EOC
    board.memory[registers.ADC1 + registers.ADC_DR] = 2291
    assert board.read_bus() == 2291


def test_filters_pass_what_the_joint_needs_and_keep_setpoints_with_sync(board):
    pairs = array("H", [0] * (2 * FILTERS))
    board.can_filters(pairs, joint_filters(pairs, 5))
    filters = board._can.filters
    assert filters[0] == (0, (0x000, 0x7FF, 0x080, 0x7FF))
    assert filters[1] == (1, (0x380, 0x7FF, 0x385, 0x7FF))
    assert filters[2] == (0, (0x108, 0x7F8, 0x108, 0x7F8))
    assert filters[3] == (1, (0x305, 0x7FF, 0x205, 0x7FF))
    board.can_filters(pairs, joint_filters(pairs, 0))
    assert board._can.filters[2] == board._can.filters[0]
    assert board._can.options == {"prescaler": 3, "bs1": 10, "bs2": 3, "auto_restart": True}


def test_frames_keep_their_bytes_both_ways(board):
    frame = array("H", [0] * 4)
    board._can.waiting[0].append((0x100, bytes(range(8))))
    assert board.can_receive(frame) == 0x100
    assert list(frame) == [0x0100, 0x0302, 0x0504, 0x0706]
    assert board.can_receive(frame) == -1
    assert board.can_send(0x201, frame, 6) == 0  # no free mailbox
    board.memory[registers.CAN_TSR_HIGH] = 0x0400
    assert board.can_send(0x201, frame, 6) == 1
    assert board._can.sent == [(0x201, bytes(range(6)))]


def test_the_driver_is_written_and_read_back(board):
    assert board.driver_setup() == -1
    spi = board._driver._spi
    assert spi.writes[0] == (drv8323.DRIVER_CONTROL, 1)
    assert spi.writes[1:] == list(drv8323.SETTINGS)
    assert board.RESET_CAUSE == 4
    assert (board.MCU_CAL1, board.MCU_CAL2) == (940, 1190)


@pytest.mark.parametrize("register", [r for r, value in drv8323.SETTINGS if value])
def test_each_driver_register_that_does_not_read_back_is_named(register):
    spi = FakeDriverSpi()
    spi.stuck.add(register)
    assert drv8323.Drv8323(spi, FakePin("CS")).setup() == register


def test_both_fault_registers_are_read_once_each():
    spi = FakeDriverSpi()
    spi.values[0], spi.values[1] = 0x401, 0x080
    assert drv8323.Drv8323(spi, FakePin("CS")).faults() == 0x401 | 0x080 << 11


def test_the_driver_fault_pin_switches_the_bridge_off(board):
    board.pwm_on()
    assert board.driver_fault() == 0
    board._fault.level = 0
    assert board.driver_fault() == 1
    assert board.memory[registers.TIM1 + registers.BDTR] & registers.MOE == 0


def test_an_encoder_checks_parity_error_flag_and_an_idle_line():
    for angle in (0, 1, 8191, 16383):
        word = angle | parity(angle) << 15
        assert MagneticEncoder(FakeAngle(word), FakePin("CS")).read() in (angle, -1 if word == 0xFFFF else angle)
        assert MagneticEncoder(FakeAngle(word ^ 0x8000), FakePin("CS")).read() == -1
        assert MagneticEncoder(FakeAngle(word | 0x4000), FakePin("CS")).read() == -1


def test_the_board_has_all_of_the_simulated_ones_interface(board):
    from firmware.board_sim import SimBoard

    tools = {"deliver"}  # of the simulation
    wanted = {name for name in dir(SimBoard) if not name.startswith("_")} - tools
    assert wanted <= set(dir(board))


def test_the_firmware_type_checks_against_the_micropython_stubs():
    checker = shutil.which("basedpyright", path=str(Path(sys.executable).parent))
    if checker is None:
        pytest.skip("basedpyright is not installed")
    config = ROOT / "tests/firmware/pyrightconfig.json"
    ran = subprocess.run(
        [checker, "-p", str(config), "--pythonpath", sys.executable], capture_output=True, text=True, timeout=300
    )
    assert ran.returncode == 0, ran.stdout
