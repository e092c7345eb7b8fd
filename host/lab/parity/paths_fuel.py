"""What whole paths of both roles' firmware cost in the WASI VM, in fuel: exact, and wherever the project is installed.

The firmware runs as bytecode, so what counts is not the figure but whether it grows. The joint's registers stand still
here: what is waited for is there at once.
"""

from pathlib import Path

from firmware import chip as c
from firmware.chip_io import BUS_CHANNEL
from firmware.chip_setup import MCU_CHANNEL, THERMISTOR_CHANNEL
from firmware.encoders import READ_ANGLE
from shared.gait.gaits import GAIT_NAMES

from ... import ROOT
from ...boards.build.frozen import select
from ...boards.build.generated import generated_modules
from ...boards.build.leaves import leaves_first
from ...boards.build.source import read_modules
from ...boards.build.tree import write_tree
from ...boards.runtimes import Wasi
from ...boards.runtimes.base import RuntimeFailure
from ...robot.file import load_robot
from .crawl_walk import TICK_BYTES, crawl_walk
from .joint_run import (
    BESIDE,
    BEYOND_BRAD,
    JOINT,
    ROTOR,
    SAMPLES,
    check_driven,
    encoder_word,
    joint_script,
    mailboxes,
    registers_at_rest,
)
from .paths import filled, measured
from .paths_gait import OVER_STEP, ROBOT, Extent, complaints_of, gait_script

EXTENT = Extent(ticks=30, warm_up_ticks=120, quiet_cycles=0, crawl_ticks=700)
PROLOGUE = """
import host
class gc:
    collect = disable = mem_free = mem_alloc = lambda: 0
def mark(call=host.call):
    call("", "")
"""
_WRITTEN = "tape.bin"  # the way over a step, beside the modules
_TAPE = f"""
tape = open("/core/{_WRITTEN}", "rb")
came = memoryview(bytearray({TICK_BYTES}))
def next_tick():
    tape.readinto(came)
"""
_REGISTERS = BESIDE + """
from firmware.board_stm32f405 import Stm32F405Board
HELD = {held}
CHANNELS = {channels}
FRAMES = {frames}
class Words:
    def __init__(self):
        self.held, self.driver, self.answer, self.us = {}, {}, 0, 0
    def __getitem__(self, at):
        if at == {clock}:
            self.us += 1
            return self.us
        if at == {spi1}:
            return {rotor}
        if at == {spi3}:
            return self.answer
        if at == {sample}:
            return CHANNELS.get(self.held.get({channel}), 0)
        return HELD[at] if at in HELD else self.held.get(at, 0)
    def __setitem__(self, at, value):
        self.held[at] = value
        if at == {spi3}:
            self.exchange(value)
    def exchange(self, word):
        if word == {read_angle}:
            self.answer = {joint}
            return
        place = word >> 11 & 15
        if not word & 0x8000:
            self.driver[place] = word & 0x7FF
        self.answer = self.driver.get(place, 0)
class Halves:
    def __getitem__(self, at):
        return HALVES.get(at, 0)
    def __setitem__(self, at, value):
        pass
HALVES = {halves}
class Chip:
    pass
words, chip = Words(), Chip()
chip.words, chip.halves = words, Halves()
class On(Beside):
    chip = core = system = chip
def new_board():
    board = Stm32F405Board(On())
    board.wrong = 0
    return board
def wait_step():
    words.us += 100
def wait_due(us):
    words.us = us
def bring(number):
    for place, value in enumerate(FRAMES[number]):
        words.held[{mailbox} + place] = value
    words.held[{fifo}] = 1
"""


def path_fuel(work: Path) -> dict[str, int]:
    """Return what the dearest call of each path costs in fuel, and of each gait the mean and the peak."""
    found = {f"joint:{name}": max(costs) for name, costs in _joint(work / "joint").items()}
    costs = _gait(work / "gait")
    for name, counts in costs.items():
        if name in (*GAIT_NAMES, OVER_STEP):
            found[f"gait:{name} mean"], found[f"gait:{name} peak"] = sum(counts) // len(counts), max(counts)
        else:
            found[f"gait:{name}"] = max(counts)
    return found


def _joint(work: Path) -> dict[str, list[int]]:
    runtime = Wasi(counting=True)
    answer = runtime.ask(runtime.prepare(_sources("joint", work), work), joint_script(PROLOGUE + _registers()))
    check_driven(answer)
    return measured(answer["names"], runtime.marks)


def _gait(work: Path) -> dict[str, list[int]]:
    runtime = Wasi(counting=True)
    tree = runtime.prepare(_sources("gait", work), work)
    walk = crawl_walk(load_robot(ROBOT), EXTENT.crawl_ticks)
    (tree / _WRITTEN).write_bytes(b"".join(walk))
    if complaints := complaints_of(runtime.ask(tree, PROLOGUE + _TAPE + gait_script(EXTENT)), EXTENT):
        raise RuntimeFailure(complaints[0])
    return measured(EXTENT.names, runtime.marks)


def _sources(role: str, work: Path) -> Path:
    """Write what a board of this role runs, as it is, and return the folder."""
    modules = read_modules(ROOT)
    names = select(modules, role)
    files = {modules[name].path: modules[name].text for name in names}
    generated = generated_modules(role, ROBOT, leaves_first(modules, names))
    files |= {path: text.encode() for path, text in generated.items()}
    write_tree(files, work / "sources")
    return work / "sources"


def _registers() -> str:
    """Return the joint's board for the script."""
    return filled(_REGISTERS, {
        "held": registers_at_rest(), "halves": {c.TS_CAL1_16: 943, c.TS_CAL2_16: 1194},
        "channels": {BUS_CHANNEL: SAMPLES["bus"], MCU_CHANNEL: SAMPLES["mcu"],
                     THERMISTOR_CHANNEL: SAMPLES["thermistor"]},
        "frames": mailboxes(BEYOND_BRAD), "clock": c.TIM5_CNT_32, "spi1": c.SPI1_32 + c.SPI_DR_32,
        "spi3": c.SPI3_32 + c.SPI_DR_32, "rotor": encoder_word(ROTOR), "joint": encoder_word(JOINT),
        "read_angle": READ_ANGLE, "sample": c.ADC1_DR_32, "channel": c.ADC1_SQR3_32, "mailbox": c.CAN_RX_32,
        "fifo": c.CAN_RF0R_32,
    })  # fmt: skip

