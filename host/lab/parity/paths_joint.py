"""What whole paths of a joint's firmware cost on a Cortex-M4, in instructions, and the heap it leaves.

The firmware drives the model of the chip: waiting for SPI and ADC is in the figures. Of the interrupt's way in and out
MicroPython's part is not (docs/core.md says what it takes).
"""

import json
from functools import partial

from ...sim.chip import Chip
from ...sim.chip.as5047p import As5047p
from ...sim.chip.can_wire import Frame
from ...sim.chip.drv8323 import Drv8323s
from .joint_run import BESIDE, BEYOND_BRAD, JOINT, ROTOR, SAMPLES, check_driven, frames, joint_script
from .paths import BUDGET, Cost, RoleFigures, measured
from .role_vm import RoleMachine, answer_of

TIMEOUT_S = 600.0
BOARD = BESIDE + """
from firmware.board_stm32f405 import OnTheChip, Stm32F405Board
class On(Beside, OnTheChip):
    pass
def new_board():
    return Stm32F405Board(On())
UPDATED = 0x40010010
machine.mem32[0x40023844] = 1
def wait_step(memory=machine.mem32):
    while not memory[UPDATED] & 1:
        pass
    memory[UPDATED] = 0
def wait_due(us):
    while (run.board.ticks_us() - us) & 0x3FFFFFFF >= 0x20000000:
        pass
bring = mark
"""


def joint_figures(image: bytes) -> RoleFigures:
    """Run the joint's firmware on an emulated chip and return what its paths cost. RuntimeFailure if it ends early."""
    machine = RoleMachine(image, _chip())
    for number, frame in frames(BEYOND_BRAD).items():
        machine.actions[number] = partial(machine.chip.can1._store, Frame(*frame))
    answer = answer_of(machine, joint_script(BOARD), TIMEOUT_S, "joint")
    check_driven(answer)
    spent = measured(answer["names"], machine.marks)
    idle = min(spent["poll"])  # a frame is what it adds to a poll
    budgets = json.loads(BUDGET.read_text())["joint"]
    paths = []
    for name, counts in spent.items():
        base = idle if name in ("sync", "setpoint") else 0
        paths.append(Cost(name, max(counts) - base, sorted(counts)[len(counts) // 2] - base, budgets[name]))
    complaints = [str(complaint) for complaint in machine.chip.complaints]
    return RoleFigures(answer["free"], answer["left"], paths, complaints)


def _chip() -> Chip:
    chip = Chip()
    shunts: dict[str, int] = dict.fromkeys(("PC0", "PC1", "PC2"), SAMPLES["shunt"])
    rest = {"PC3": SAMPLES["bus"], "PA4": SAMPLES["thermistor"], "TEMPERATURE": SAMPLES["mcu"]}
    for pin, counts in (shunts | rest).items():
        chip.analog[pin] = lambda cycle, counts=counts: counts  # type: ignore[misc]
    As5047p(chip, "SPI1", "PC6", lambda cycle: ROTOR, "rotor")
    As5047p(chip, "SPI3", "PD2", lambda cycle: JOINT, "joint")
    Drv8323s(chip, "SPI3", "PA15", "PC4", "PB12")
    chip.muted.add("TIM1 outputs")
    return chip
