"""What whole paths of a gait board's firmware cost on a Cortex-M4, in instructions, and the heap it leaves.

The firmware as an image has it, hot functions in C and the rest frozen. Its stream is MicroPython's own BytesIO, which
goes the way of USB's streams without the driver below; its sensor answers at once, on the bus a reading takes 0.4 ms.
The joints are where the last set-points put them, on even ground; the crawl's whole way over a step is the simulator's
(crawl_walk.py), and its answers are compared.
"""

import json
from dataclasses import dataclass
from typing import Any

from firmware import link
from firmware.gait import BoardStatus
from shared.gait.gaits import GAIT_NAMES, GAITS
from shared.planner import status
from shared.planner.command import COMMAND_SIZE, Command
from shared.planner.status import WALKING, Status

from ...boards.build.records import place_of
from ...boards.runtimes.cortex_m import FILES_AT, Machine
from ...robot.file import load_robot
from ...robot.scale import scale_of
from .crawl_walk import (
    ANGLES_AT,
    ANSWER_BYTES,
    COMMAND_BYTES,
    RAW_BYTES,
    SENSED_BYTES,
    TICK_BYTES,
    crawl_walk,
    in_plane,
)
from .paths import BUDGET, NOTHING, Cost, RoleFigures, filled, measured
from .role_vm import answer_of

TIMEOUT_S = 3000.0
IDLE, LIMP, STANDING = 20, 60, 100  # how often these are measured
SPEED_M_S = 0.05
ROBOT = "caramelo"
OVER_STEP = "step"  # the crawl over one
TAPE = f"""
import uctypes
came = memoryview(uctypes.bytearray_at({FILES_AT}, {TICK_BYTES}))
def next_tick():
    mark(1)
"""
SCRIPT = """
import io, json
import firmware.leaves
from array import array
from firmware import gait, gait_main, mpu6050
from firmware.robot_params import ATTITUDE, PARAMS
from firmware.start_gait import UsbStream
SPEED, GAITS, WARM_UP, TICKS, QUIET_CYCLES, CRAWL_TICKS = {settings}
COMMAND, SENSED, READ = {kinds}
class I2c:
    def __init__(self):
        self.noise = 0
    def readfrom_mem(self, address, register, count):
        return bytes((0x68 if register == 0x75 else 0,) + (0,) * (count - 1))
    def writeto_mem(self, address, register, data):
        pass
    def readfrom_mem_into(self, address, register, raw):
        self.noise ^= 1
        raw[4] = 0x40
        raw[9] = self.noise
class Felt(I2c):
    def readfrom_mem_into(self, address, register, raw):
        felt.readinto(raw)
class Port:
    def setinterrupt(self, byte):
        pass
port, sink = Port(), io.BytesIO(bytes(64))
port.write = sink.write
stream = UsbStream(port)
def new_board(i2c):
    attitude = array("i", ATTITUDE)
    return gait.GaitBoard(PARAMS, attitude, mpu6050.Mpu6050(i2c, sleep_ms=lambda ms: None))
board = new_board(I2c())
data = bytearray(gait_main.BLOCK_BYTES)
take_block, setpoints = gait_main.take_block, board.setpoints
gc.collect()
free = gc.mem_free()
gc.disable()  # what the script itself takes is not to be collected within a path

class Sent:
    def __init__(self, kind, count, size):
        self.frame, self.kind, self.size = bytearray(6 + count * size), kind, size
        self.end = 4 + count * size
        self.bytes = io.BytesIO(bytes(len(self.frame)))
        self.readinto = self.bytes.readinto
        self.seal()
    def put(self, place, value):
        gait.put(self.frame, 4 + self.size * place, value, self.size)
    def seal(self):
        gait.close_frame(self.frame, self.kind, self.end)
        self.bytes.seek(0)
        self.bytes.write(self.frame)
    def take(self):
        self.come()
        take_block(board, stream, data)
    def come(self):
        self.bytes.seek(0)
        sink.seek(0)
        port.readinto = self.readinto
command, sensed, read = Sent(COMMAND, {command_size}, 4), Sent(SENSED, 12, 2), Sent(READ, 1, 1)
broken = Sent(COMMAND, {command_size}, 4)
broken.bytes.seek(9)
broken.bytes.write(b"1")
nobody = io.BytesIO(b"")
states = []
copy, sent, felt = io.BytesIO(bytes(24)), memoryview(setpoints)[14:38], memoryview(sensed.frame)[4:28]

def follow():
    copy.seek(0)
    copy.write(sent)
    copy.seek(0)
    copy.readinto(felt)
    gait.close_frame(sensed.frame, SENSED, 28)
    sensed.bytes.seek(0)
    sensed.bytes.write(sensed.frame)
def tick():
    board.tick()
    stream.write(setpoints)
def cost(path, *given):
    sink.seek(0)
    mark(); path(*given); mark()
def take(sent):
    sent.come()
    cost(take_block, board, stream, data)
def cycle():
    follow()
    take(command)
    take(sensed)
    cost(tick)
def quiet():
    follow()
    command.take()
    sensed.take()
    sink.seek(0)
    tick()
def nothing(*given):
    pass
def order(mode, number):
    command.put({mode_at}, mode)
    command.put({gait_at}, number)
    command.put({speed_at}, SPEED)
    command.put({balance_at}, 1)
    command.seal()

for _ in range({idle}):
    cost(nothing, board, stream, data)
    take(read)
    take(broken)
    port.readinto = nobody.readinto
    cost(take_block, board, stream, data)
for _ in range({limp}):
    cycle()
order(1, 0)
for _ in range(WARM_UP):
    quiet()
for _ in range({standing}):
    cycle()
for number in range(GAITS):
    order(2, number)
    for _ in range(WARM_UP):
        quiet()
    for _ in range(TICKS):
        cycle()
    gc.collect()
    states.append([board.planner.status[i] for i in {watched}] + [board.status[{flags}] >> 16])
    order(1, number)
    while board.planner.status[{watched}[0]] != {stands}:
        quiet()
order(2, 1)
gc.collect()
for _ in range(10):
    quiet()
before = taken = 0  # so that the names are there: a dictionary of theirs that grew would count as taken
before = gc.mem_alloc()
for number in range(QUIET_CYCLES):
    if number % {minute} == 0:
        order(2, (number // {minute} + 1) % GAITS)
    quiet()
taken = gc.mem_alloc() - before

for place, value in {plane}:
    PARAMS[place] = value
board = None
gc.collect()
felt = io.BytesIO(bytes({raw_bytes}))
board = new_board(Felt())
inputs, at = [], 0
for target, count in ((command.bytes, {command_bytes}), (sensed.bytes, {sensed_bytes}), (felt, {raw_bytes})):
    inputs.append((target, came[at : at + count]))
    at += count
expected = came[at:]
setpoints = board.setpoints
answer = memoryview(setpoints)[{angles} : {angles} + {answer_bytes}]
wrong = 0
for number in range(CRAWL_TICKS):
    if number % 100 == 0:
        gc.collect()
    next_tick()
    for target, block in inputs:
        target.seek(0)
        target.write(block)
        target.seek(0)
    take(command)
    take(sensed)
    cost(tick)
    wrong += answer != expected
gc.collect()
print("@@" + json.dumps(dict(free=free, left=gc.mem_free(), taken=taken, states=states, wrong=wrong)))
"""


@dataclass(frozen=True)
class Extent:
    """How long a run is, in ticks: of each gait (warm-up: standing up, the first steps), of the gaits minute by minute
    while the heap must not move, and of the way over a step."""

    ticks: int
    warm_up_ticks: int
    quiet_cycles: int
    crawl_ticks: int

    @property
    def names(self) -> list[str]:
        """What the script measures, in order."""
        names = [NOTHING, "read", "broken", "idle"] * IDLE
        gaits = [(gait, self.ticks) for gait in GAIT_NAMES]
        for name, count in (("limp", LIMP), ("standing", STANDING), *gaits, (OVER_STEP, self.crawl_ticks)):
            names += ["command", "sensed", name] * count
        return names


def gait_figures(image: bytes) -> RoleFigures:
    """Run the gait board's firmware on an emulated processor and return what its paths cost.

    Of each gait and of the way over a step: the mean of its ticks, the dearest, and the dearest whole cycle of COMMAND,
    SENSED and a tick. RuntimeFailure if it ends early. Complaints: memory taken, a gait not walked, a wrong answer.
    """
    walk = crawl_walk(load_robot(ROBOT))
    extent = Extent(ticks=200, warm_up_ticks=160, quiet_cycles=1000, crawl_ticks=len(walk))
    machine = Machine(image, b"\0", counting=True)
    ticks = iter(walk)
    machine.actions[1] = lambda: machine.write(FILES_AT, next(ticks))
    answer = answer_of(machine, TAPE + gait_script(extent), TIMEOUT_S, "gait board")
    spent = measured(extent.names, machine.marks)
    budgets = json.loads(BUDGET.read_text())["gait"]
    paths = []
    for name in ("command", "sensed", "broken", "read", "idle", "limp", "standing"):
        counts = sorted(spent[name])
        paths.append(Cost(name, counts[-1], counts[len(counts) // 2], budgets[name]))
    frames = paths[0].most + paths[1].most
    for gait in (*GAIT_NAMES, OVER_STEP):
        counts = spent[gait]
        mean, most = sum(counts) // len(counts), max(counts)
        for name, value in (("mean", mean), ("peak", most), ("cycle", most + frames)):
            paths.append(Cost(f"{gait} {name}", value, value, budgets[name]))
    return RoleFigures(answer["free"], answer["left"], paths, complaints_of(answer, extent))


WATCHED = ("state", "gait", "mover")  # of the planner's status, in every gait


def complaints_of(answer: dict[str, Any], extent: Extent) -> list[str]:
    """Return what a run's answer says that must not be, in sentences."""
    found = [f"{answer['taken']} bytes of heap were taken in {extent.quiet_cycles} cycles"] if answer["taken"] else []
    if answer["wrong"]:
        found.append(f"the way over a step: {answer['wrong']} answers differ from CPython's")
    for number, (state, gait, mover, flags) in enumerate(answer["states"]):
        if (state, gait, mover) != (WALKING, number, GAITS[number][1]) or flags:
            name = GAIT_NAMES[number]
            found.append(f"{name} was not walked: state {state}, gait {gait}, mover {mover}, board's flags {flags:#x}")
    return found


def gait_script(extent: Extent) -> str:
    """Return the script; its VM gives ``gc``, ``mark``, and ``next_tick``, which puts a tick of the way in ``came``."""
    robot = load_robot(ROBOT)
    speed = scale_of(robot).lf_per_tick(SPEED_M_S)
    return filled(SCRIPT, {
        "settings": (speed, len(GAIT_NAMES), extent.warm_up_ticks, extent.ticks, extent.quiet_cycles,
                     extent.crawl_ticks),
        "kinds": (link.COMMAND, link.SENSED, link.READ), "flags": place_of(BoardStatus, "flags"),
        **{f"{name}_at": place_of(Command, name) for name in ("mode", "gait", "speed", "balance")},
        "command_size": COMMAND_SIZE,
        "watched": [place_of(Status, name) for name in WATCHED],
        "stands": status.STANDING, "minute": 60 * scale_of(robot).rate_hz, "idle": IDLE, "limp": LIMP,
        "standing": STANDING,
        "plane": in_plane(robot), "command_bytes": COMMAND_BYTES, "sensed_bytes": SENSED_BYTES,
        "raw_bytes": RAW_BYTES, "answer_bytes": ANSWER_BYTES, "angles": ANGLES_AT,
    })  # fmt: skip
