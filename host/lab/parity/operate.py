"""An hour of operation, or less, in a VM with the chip's heap: what it takes of it must be nothing.

The firmware is as an image has it, on an emulated Cortex-M4. Nothing is collected while it operates, so that every byte
taken would be seen. The gait board gets a command and its joints each tick and changes its gait each minute. The joint
holds where it is (further off it would be a stall), with a set-point each 5 ms; each minute it is stopped, cleared and
armed again. Its registers stand still.
"""

from typing import Any

from firmware import chip as c
from firmware.encoders import READ_ANGLE

from ...boards.runtimes.cortex_m import PAGE, Machine
from .joint_run import BESIDE, JOINT, ROTOR, SAMPLES, SET_UP, encoder_word, filled_in, mailboxes, registers_at_rest
from .paths import filled
from .paths_gait import TAPE, Extent, complaints_of, gait_script
from .role_vm import answer_of

CHIP_AT, CHIP_BYTES = 0x10000000, 0x100000  # registers, in what is plain memory here; a small int of the VM's
CORE_AT, SYSTEM_AT = CHIP_AT + 0x80000, CHIP_AT + 0x90000
CALIBRATION = 2250 | 2650 << 16  # TS_CAL1 and 2 of a chip whose sensor is at some 40 deg C where the bus voltage is
TICKS_PER_MINUTE = 3000  # of the gait board, 50 a second
TIMEOUT_S = 24 * 3600.0  # who asks for an hour waits for it
_BOARD = BESIDE + """
from firmware.board_stm32f405 import Stm32F405Board
FRAMES = {frames}
memory = machine.mem32
class On(Beside):
    chip, core, system = {chip}, {core}, {system}
def new_board():
    for place, value in {ready}:
        memory[{chip} + 4 * place] = value
    memory[{system} + 0x2C] = {calibration}
    memory[{clock}] = now
    board = Stm32F405Board(On())
    board.wrong = 0
    board.driver_setup = board._driver.setup
    return board
now = 0x3FF00000  # a second before the clock begins anew
def wait_step():
    global now
    now = (now - 0x3FFFFF9C) & 0x3FFFFFFF  # 100 us on; a sum beyond 2^30 would take memory
    memory[{clock}] = now
    memory[{adc1}] = 6
    memory[{adc2}] = 4
    memory[{adc3}] = 4
def bring(number):
    at = {mailbox}
    for value in FRAMES[number]:
        memory[at] = value
        at += 4
    memory[{fifo}] = 1
"""
_OPERATE = """
wrong = 0
def operate(minutes):
    global wrong
    for _ in range(minutes):
        bring({clear})
        run.millisecond()
        wrong += run.drive() != {enabled}
        for _ in range(12000):
            run.fed()
            for _ in range(5):
                run.millisecond()
        wrong += run.state() != {enabled}
        bring({stop})
        for _ in range(30):
            run.millisecond()
        wrong += run.state() != {fault}
gc.collect()
gc.disable()
before = taken = 0  # so that the names are there: a dictionary of theirs that grew would count as taken
before = gc.mem_alloc()
operate({minutes})
taken = gc.mem_alloc() - before
gc.collect()
print("@@" + json.dumps(dict(taken=taken, left=gc.mem_free(), wrong=wrong)))
"""


def operated(role: str, image: bytes, minutes: int) -> list[str]:
    """Let a role operate; return what must not be, in sentences. RuntimeFailure if it ends early."""
    return {"joint": _joint, "gait": _gait}[role](image, minutes)


def _gait(image: bytes, minutes: int) -> list[str]:
    extent = Extent(ticks=0, warm_up_ticks=160, quiet_cycles=minutes * TICKS_PER_MINUTE, crawl_ticks=0)
    machine = Machine(image, b"\0", counting=False)
    return complaints_of(answer_of(machine, TAPE + gait_script(extent), TIMEOUT_S, "gait board"), extent)


def _joint(image: bytes, minutes: int) -> list[str]:
    found = answer_of(_StillChip(image), _script(minutes), TIMEOUT_S, "joint")
    complaints = []
    if found["taken"]:
        complaints.append(f"{found['taken']} bytes of heap were taken in {minutes} minutes of operation")
    if found["wrong"]:
        complaints.append(f"{found['wrong']} times the joint was not in the state that it was sent to")
    return complaints


class _StillChip(Machine):
    """A joint's chip whose registers are plain memory, but for the two SPIs: encoders and gate driver answer."""

    def __init__(self, image: bytes) -> None:
        super().__init__(image, b"\0", counting=False)
        self._driver: dict[int, int] = {}
        self._answer = 0
        spi1, spi3 = 4 * c.SPI1_32, 4 * c.SPI3_32 // PAGE * PAGE
        start = 0
        for page, read, write in ((spi3, self._spi3_read, self._spi3_write), (spi1, self._spi1_read, self._ignore)):
            self._uc.mem_map(CHIP_AT + start, page - start)
            self._uc.mmio_map(CHIP_AT + page, PAGE, read, None, write, None)
            start = page + PAGE
        self._uc.mem_map(CHIP_AT + start, CHIP_BYTES - start)

    def _spi1_read(self, uc: Any, offset: int, size: int, data: Any) -> int:
        return encoder_word(ROTOR) if offset == 4 * c.SPI_DR_32 else c.RXNE

    def _ignore(self, uc: Any, offset: int, size: int, value: int, data: Any) -> None:
        return

    def _spi3_read(self, uc: Any, offset: int, size: int, data: Any) -> int:
        return self._answer if offset % 0x400 == 4 * c.SPI_DR_32 else c.RXNE

    def _spi3_write(self, uc: Any, offset: int, size: int, value: int, data: Any) -> None:
        if offset != 4 * (c.SPI3_32 + c.SPI_DR_32) % PAGE:
            return
        place = value >> 11 & 15
        if value == READ_ANGLE:
            self._answer = encoder_word(JOINT)
            return
        if not value & 0x8000:
            self._driver[place] = value & 0x7FF
        self._answer = self._driver.get(place, 0)


def _script(minutes: int) -> str:
    return filled_in(filled(_BOARD + SET_UP + _OPERATE, {
        "chip": CHIP_AT, "core": CORE_AT, "system": SYSTEM_AT, "calibration": CALIBRATION,
        "ready": list((registers_at_rest() | {c.ADC1_DR_32: SAMPLES["bus"]}).items()), "frames": mailboxes(0),
        "clock": CHIP_AT + 4 * c.TIM5_CNT_32, "adc1": CHIP_AT + 4 * c.ADC1_SR_32, "adc2": CHIP_AT + 4 * c.ADC2_SR_32,
        "adc3": CHIP_AT + 4 * c.ADC3_SR_32, "mailbox": CHIP_AT + 4 * c.CAN_RX_32, "fifo": CHIP_AT + 4 * c.CAN_RF0R_32,
        "minutes": minutes,
    }))  # fmt: skip
