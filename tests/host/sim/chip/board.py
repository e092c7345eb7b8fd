"""Addresses and short ways to a chip that runs, for the tests of the chip model."""

from host.sim.chip import Chip

RCC, FLASH = 0x4002_3800, 0x4002_3C00
GPIO = {letter: 0x4002_0000 + 0x400 * n for n, letter in enumerate("ABCD")}
TIM1, SPI1, SPI3 = 0x4001_0000, 0x4001_3000, 0x4000_3C00
ADC1, ADC2, ADC3, ADC_COMMON = 0x4001_2000, 0x4001_2100, 0x4001_2200, 0x4001_2300
CAN1, IWDG = 0x4000_6400, 0x4000_3000
AHB1ENR, APB1ENR, APB2ENR, CSR = RCC + 0x30, RCC + 0x40, RCC + 0x44, RCC + 0x74
CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER, CNT, PSC, ARR, RCR = (TIM1 + 4 * n for n in range(13))
CCR1, CCR2, CCR3 = (TIM1 + 0x34 + 4 * n for n in range(3))
BDTR = TIM1 + 0x44
CENTRE, ARPE, CEN, UG = 0x20, 0x80, 1, 1


def clocked(**more):
    """Return a chip with the clocks of all modelled blocks on."""
    chip = Chip(**more)
    chip.write(AHB1ENR, chip.read(AHB1ENR) | 0xF)
    chip.write(APB1ENR, 1 << 15 | 1 << 25)
    chip.write(APB2ENR, 1 | 7 << 8 | 1 << 12)
    chip.advance(20)
    return chip


def set_pin(chip, pin, mode, function=0):
    """Give a pin a mode (0 input, 1 output, 2 alternate, 3 analog) and an alternate function."""
    base, n = GPIO[pin[1]], int(pin[2:])
    chip.write(base, chip.read(base) & ~(3 << 2 * n) | mode << 2 * n)
    afr = base + (0x20 if n < 8 else 0x24)
    chip.write(afr, chip.read(afr) & ~(15 << 4 * (n % 8)) | function << 4 * (n % 8))


def reasons(chip):
    """Return the complaints as text."""
    return [str(complaint) for complaint in chip.complaints]


def forgive(chip):
    """Forget complaints, doubts and events up to now."""
    for told in (chip.complaints, chip.doubts, chip.counts, chip.events):
        told.clear()


def edges(chip, output):
    """Return the edges of an output of TIM1 as (cycle, level)."""
    begin = f"{output} = "
    return [(cycle, told[len(begin) :]) for cycle, who, told in chip.events
            if who == "TIM1 outputs" and told.startswith(begin)]  # fmt: skip
