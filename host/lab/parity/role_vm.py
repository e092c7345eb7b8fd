"""A role's own firmware on an emulated Cortex-M4 whose peripherals are the model of the chip, instructions counted.

A cycle is half an instruction: the chip's time goes on with what is done.
"""

import json
from typing import Any

from ...boards.runtimes.base import MARK, RuntimeFailure
from ...boards.runtimes.cortex_m import MARKS_AT, Machine
from ...sim.chip import Chip

CYCLES_PER_INSTRUCTION = 2
# The emulated board's own serial port lies in the page left out
_PAGES = ((0x40000000, 0x4000), (0x40005000, 0x7B000))
_FACTORY_AT, _FACTORY_BYTES = 0x1FFF7000, 0x1000
PROLOGUE = f"""
import gc, machine
def mark(number=0, memory=machine.mem32):
    memory[{MARKS_AT}] = number
"""


def answer_of(machine: Machine, script: str, timeout_s: float, role: str) -> dict[str, Any]:
    """Run a script on a machine and return its answer; RuntimeFailure if the firmware of the role ends early."""
    output = machine.run(PROLOGUE + script, timeout_s).decode("utf-8", "replace")
    answer = output.partition(MARK)[2]
    if not answer:
        raise RuntimeFailure(f"the {role}'s firmware ended: {machine.failure}: {output.strip()[-1500:]}")
    return dict(json.loads(answer.splitlines()[0]))


class RoleMachine(Machine):
    """``chip`` is the model."""

    def __init__(self, image: bytes, chip: Chip) -> None:
        super().__init__(image, b"\0", counting=True)
        self.chip = chip
        self._seen = 0
        for base, size in _PAGES:
            self._uc.mmio_map(base, size, self._chip_read, base, self._chip_write, base)
        self._uc.mem_map(_FACTORY_AT, _FACTORY_BYTES)
        self._uc.mem_write(_FACTORY_AT + 0xA2C, (943).to_bytes(2, "little") + (1194).to_bytes(2, "little"))

    def _pass_time(self) -> None:
        done, self._seen = self._done - self._seen, self._done
        self.chip.advance(done * CYCLES_PER_INSTRUCTION)

    def _chip_read(self, uc: Any, offset: int, size: int, base: int) -> int:
        self._pass_time()
        return self.chip.read(base + offset, size)

    def _chip_write(self, uc: Any, offset: int, size: int, value: int, base: int) -> None:
        self._pass_time()
        self.chip.write(base + offset, value, size)

    def _mark(self, uc: Any, offset: int, size: int, value: int, data: Any) -> None:
        if value:
            self._pass_time()
        super()._mark(uc, offset, size, value, data)
