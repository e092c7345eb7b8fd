"""Whatever is written anywhere at any time, the model goes on: it complains, it does not fall over."""

import random

import pytest

from host.sim.chip.bridge import HalfBridges
from host.sim.chip.can_wire import Frame

from .board import CEN, CENTRE, PSC, clocked, set_pin

STEPS = 600


def registers(chip):
    """Return all addresses with a register but those of RCC, which would stop the clocks, and some beside."""
    blocks = [block for block in chip.blocks if block is not chip.rcc]
    found = [block.base + register.offset for block in blocks for register in block.registers]
    return found + [0xE000_E100 + n for n in range(0, 0x400, 4)] + [0x0800_0000, 0x4000_0000, 0x4001_0058]


@pytest.mark.parametrize("seed", range(4))
def test_random_writes_never_stop_the_model(seed):
    rng = random.Random(seed)
    chip = clocked()
    HalfBridges(chip, {"a": ("PA8", "PB13")})
    for pin in ("PA8", "PB13", "PB12"):
        set_pin(chip, pin, 2, 1)
    addresses = registers(chip)
    busy = (0x40_0100, 0x40_0120, 0x40_0121, 0x40_0130, 0x40_0064)
    favoured = [address for address in addresses if address >> 8 in busy and address != PSC]
    for _ in range(STEPS):
        address = rng.choice(favoured if rng.random() < 0.7 else addresses)
        size = rng.choice((4, 4, 4, 2, 1))
        if rng.random() < 0.3:
            assert 0 <= chip.read(address, size) < 1 << 8 * size
        else:
            word = rng.choice((rng.getrandbits(32), rng.getrandbits(6), 1 << rng.randrange(32), CEN | CENTRE))
            chip.write(address, word & ((1 << 8 * size) - 1), size)
        if rng.random() < 0.05:
            chip.can1.wire.send(Frame(rng.getrandbits(11), bytes(rng.randrange(9))))
        chip.advance(rng.choice((0, 1, 4, 100, 2000)))
        if chip.pending_interrupts() and rng.random() < 0.5:
            chip.nvic.enter(chip.pending_interrupts()[0])
            chip.nvic.leave()
    assert chip.complaints
