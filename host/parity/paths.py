"""What whole paths of a joint's firmware cost on a Cortex-M4, in instructions, and the heap it leaves.

The firmware as an image has it, hot functions in C and the rest frozen, drives the model of the chip: waiting for
SPI and ADC is in the figures. Of the interrupt's way in and out MicroPython's part is not (some 200 instructions).
"""

import importlib.util
import json
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from shared.wire import names as w

from ..chip import Chip
from ..chip.as5047p import As5047p
from ..chip.can_wire import Frame
from ..chip.drv8323 import Drv8323s
from ..errors import UserError
from ..runtimes.base import MARK, RuntimeFailure
from ..runtimes.role_vm import PROLOGUE, RoleMachine

BUDGET = Path(__file__).with_name("path_budget.json")
HEAP_BYTES = 103168  # what the PYBV11 port leaves of an STM32F405's memory
TIMEOUT_S = 300.0
SCRIPT = """
import gc, json
from firmware.board_stm32f405 import OnTheChip, Stm32F405Board
from firmware.joint import Joint
from firmware.settings import Memory
class Timer:
    def callback(self, handler):
        self.handler = handler
timer = Timer()
class On(OnTheChip):
    def timer(self, period):
        return timer
    def reset_cause(self):
        return 0
    def unique_id(self):
        return bytes(12)
    def random(self):
        return 4711
UPDATED = 0x40010010
class Script:
    def __init__(self):
        machine.mem32[0x40023844] = 1
        self.board = Stm32F405Board(On())
        self.joint = Joint(self.board, Memory())
        self.joint.set_node(1)
        self.joint.start()
        self.handler = timer.handler
        self.due = 0
    def steps(self, count):
        memory, handler = machine.mem32, self.handler
        for _ in range(count):
            while not memory[UPDATED] & 1:
                pass
            memory[UPDATED] = 0
            handler(timer)
    def settle(self):
        while self.joint.poll():
            pass
s = Script()
gc.collect()
free = gc.mem_free()
for _ in range(40):
    s.steps(10)
    s.settle()
names = []
def cost(name, path, *given):
    names.append(name)
    if given:
        mark(); path(timer); mark()
    else:
        mark(); path(); mark()
def nothing():
    pass
poll = s.joint.poll
def wait_due():
    while (s.board.ticks_us() - s.joint._due_us) & 0x3FFFFFFF >= 0x20000000:
        pass
for _ in range(20):
    s.steps(9)
    while not machine.mem32[UPDATED] & 1:
        pass
    machine.mem32[UPDATED] = 0
    cost("interrupt", s.handler, timer)
    s.settle()
    cost("nothing", nothing)
for _ in range(110):
    s.settle()
    wait_due()
    s.steps(1)
    cost("slow" if s.joint.control._slow_ticks == 99 else "tell" if s.joint._told[2] == 199 else "motion", poll)
for name, action in (("poll", 0), ("sync", 1), ("setpoint", 2), ("sync", 1), ("stop", 3)):
    for _ in range(5):
        s.steps(10)
        s.settle()
        if action:
            mark(action)
        cost(name, poll)
gc.collect()
print("@@" + json.dumps({"free": free, "left": gc.mem_free(), "names": names, "steps": s.joint.control.run[1]}))
"""


@dataclass(frozen=True)
class Cost:
    """What one path took: instructions of the dearest call and of the middle one, and what that may be.

    A dearest one may hold what was due besides: the millisecond in a SYNC, a heartbeat in a millisecond.
    """

    name: str
    most: int
    median: int
    budget: int

    @property
    def ok(self) -> bool:
        return self.median <= self.budget


@dataclass(frozen=True)
class RoleFigures:
    """Heap left after set-up and after the run, in bytes of HEAP_BYTES; the paths; complaints of the chip's model."""

    free: int
    left: int
    paths: list[Cost]
    complaints: list[str]
    least_free: int = HEAP_BYTES // 4  # a quarter is to be free whatever was done

    @property
    def ok(self) -> bool:
        """True if every path is within its budget, memory is left, and nothing was complained of."""
        return all(path.ok for path in self.paths) and self.left >= self.least_free and not self.complaints

    def told(self) -> dict[str, Any]:
        """Return the figures as they are printed for machines."""
        paths = {path.name: {"median": path.median, "most": path.most, "budget": path.budget} for path in self.paths}
        return {"free": self.free, "left": self.left, "paths": paths, "complaints": self.complaints, "ok": self.ok}


def figures_of(role: str, micropython: Path, jobs: int) -> RoleFigures:
    """Build a role's VM and return its figures. UserError for what is missing, RuntimeFailure if it ends early."""
    from ..build.frozen import frozen_sources
    from ..build.vm import build_vm
    from .paths_gait import gait_figures

    if importlib.util.find_spec("unicorn") is None:
        raise UserError("unicorn is not installed: pip install unicorn")
    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder:
        work = Path(folder)
        tree = frozen_sources(role, "caramelo", work / "frozen")
        image = build_vm(micropython.absolute(), tree, HEAP_BYTES, work, jobs)
    return {"joint": joint_figures, "gait": gait_figures}[role](image)


def joint_figures(image: bytes) -> RoleFigures:
    """Run the joint's firmware on an emulated chip and return what its paths cost. RuntimeFailure if it ends early."""
    machine = RoleMachine(image, _chip())
    setpoint = (400).to_bytes(2, "little") + b"\x00\x80" * 3
    frames = {1: Frame(w.SYNC_ID, bytes([0, 0])), 2: Frame(w.SETPOINT_POSITION_ID, setpoint), 3: Frame(w.E_STOP_ID)}
    for number, frame in frames.items():
        machine.actions[number] = lambda frame=frame: machine.chip.can1._store(frame)  # type: ignore[misc]
    answer = _answer(machine)
    spent: dict[str, list[int]] = {}
    for name, begin, end in zip(answer["names"], machine.marks[::2], machine.marks[1::2], strict=True):
        spent.setdefault(name, []).append(end - begin)
    empty = min(spent.pop("nothing"))
    idle = min(spent["poll"])
    budgets = json.loads(BUDGET.read_text())
    paths = []
    for name, counts in spent.items():
        base = idle if name in ("sync", "setpoint") else empty
        paths.append(Cost(name, max(counts) - base, sorted(counts)[len(counts) // 2] - base, budgets["joint"][name]))
    complaints = [str(complaint) for complaint in machine.chip.complaints]
    return RoleFigures(answer["free"], answer["left"], paths, complaints)


def _chip() -> Chip:
    chip = Chip(hse_hz=12_000_000)
    for pin, counts in {"PC0": 2048, "PC1": 2048, "PC2": 2048, "PC3": 2291, "PA4": 2000, "TEMPERATURE": 950}.items():
        chip.analog[pin] = lambda cycle, counts=counts: counts  # type: ignore[misc]
    As5047p(chip, "SPI1", "PC6", lambda cycle: 1234, "rotor")
    As5047p(chip, "SPI3", "PD2", lambda cycle: 777, "joint")
    Drv8323s(chip, "SPI3", "PA15", "PC4", "PB12")
    chip.muted.add("TIM1 outputs")
    return chip


def _answer(machine: RoleMachine) -> dict[str, Any]:
    output = machine.run(PROLOGUE + SCRIPT, TIMEOUT_S).decode("utf-8", "replace")
    answer = output.partition(MARK)[2]
    if answer:
        return dict(json.loads(answer.splitlines()[0]))
    raise RuntimeFailure(f"the joint's firmware ended: {machine.failure}: {output.strip()[-1500:]}")
