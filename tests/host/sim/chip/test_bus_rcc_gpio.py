"""Memory map, clock gates, resets and pins: RM0090 sections 7 and 8."""

import pytest

from host.sim.chip import Chip

from .board import APB2ENR, BDTR, CSR, GPIO, RCC, TIM1, clocked, reasons, set_pin


def test_a_block_without_its_clock_reads_zero_and_takes_nothing():
    chip = Chip()
    chip.write(TIM1 + 0x2C, 1234)
    assert chip.read(TIM1 + 0x2C) == 0
    chip.write(APB2ENR, 1)
    chip.advance(10)
    assert chip.read(TIM1 + 0x2C) == 0xFFFF  # 17.4.12: the reset value, not 1234
    assert [(c.peripheral, c.register) for c in chip.complaints] == [("TIM1", "ARR")]
    assert "APB2ENR bit 0" in reasons(chip)[0]


def test_a_clock_needs_some_cycles_before_the_block_answers():
    """Errata ES0182, delay after an RCC peripheral clock enabling: 1 + prescaler cycles on APB2 (here 2)."""
    chip = Chip()
    chip.write(APB2ENR, 1)
    chip.advance(2)
    assert chip.read(TIM1 + 0x2C) == 0
    chip.advance(1)
    assert chip.read(TIM1 + 0x2C) == 0xFFFF


@pytest.mark.parametrize(
    ("address", "size", "word"),
    [
        (TIM1 + 0x2C, 1, "8 bits"),  # 17.4: written in half-words or words
        (0x4001_2000 + 0x38, 2, "16 bits"),  # 13.13: the ADC is written in words
        (TIM1 + 0x54, 4, "no register"),
        (0x5000_0000, 4, "nothing modelled"),
    ],
)
def test_an_access_that_is_not_allowed_is_told(address, size, word):
    chip = clocked()
    chip.write(address, 1, size)
    assert len(chip.complaints) == 1
    assert word in reasons(chip)[0]


def test_reserved_bits_are_told_and_not_stored():
    chip = clocked()
    chip.write(TIM1 + 0x30, 0x1FF)  # RCR has 8 bits
    assert chip.read(TIM1 + 0x30) == 0xFF
    assert "0x100" in reasons(chip)[0]


def test_half_words_and_bytes_reach_their_part_of_a_register():
    chip = clocked()
    chip.write(GPIO["B"] + 0x14, 0xAB, 1)
    chip.write(GPIO["B"] + 0x15, 0xCD, 1)
    assert chip.read(GPIO["B"] + 0x14) == 0xCDAB
    chip.write(GPIO["B"] + 0x1A, 0x00FF, 2)  # the upper half of BSRR resets
    assert chip.read(GPIO["B"] + 0x14, 2) == 0xCD00
    assert chip.complaints == []


def test_setting_wins_over_resetting_in_bsrr():
    chip = clocked()
    chip.write(GPIO["C"] + 0x18, 0x0003_0001)
    assert chip.read(GPIO["C"] + 0x14) == 1


def test_the_debug_pins_wake_in_use():
    chip = clocked()  # 8.4.1 and 8.4.4
    assert chip.read(GPIO["A"]) == 0xA800_0000
    assert chip.read(GPIO["B"]) == 0x280
    assert chip.read(GPIO["A"] + 0xC) == 0x6400_0000


def test_a_locked_pin_keeps_its_mode_until_a_reset():
    chip = clocked()
    lckr = GPIO["B"] + 0x1C
    for word in (0x1_0002, 0x0_0002, 0x1_0002):  # 8.4.8
        chip.write(lckr, word)
    assert chip.read(lckr) == 0x1_0002
    before = chip.read(GPIO["B"])
    chip.write(GPIO["B"], before | 1 << 2)
    assert chip.read(GPIO["B"]) == before
    assert "locked" in reasons(chip)[0]


def test_a_signal_reaches_the_pin_whose_alternate_function_is_chosen():
    chip = clocked()
    set_pin(chip, "PA8", 2, 1)
    assert chip.pin_of("TIM1_CH1") == "PA8"
    assert chip.complaints == []
    set_pin(chip, "PE9", 2, 1)
    chip.pin_of("TIM1_CH1")
    chip.pin_of("TIM1_CH2")
    assert "several pins: PA8, PE9" in reasons(chip)[0]
    assert "no pin carries it" in reasons(chip)[1]


def test_an_output_an_input_and_a_pull():
    chip = clocked()
    set_pin(chip, "PC1", 1)
    chip.write(GPIO["C"] + 0x18, 2)
    assert chip.pins.level("PC1") == 1
    assert chip.pins.level("PC2") is None
    chip.write(GPIO["C"] + 0xC, 1 << 4)  # pull-up on PC2
    assert chip.read(GPIO["C"] + 0x10) == 0b110
    chip.pins.drive_pin("PC2", 0)
    assert chip.read(GPIO["C"] + 0x10) == 0b010


def test_reset_flags_stay_until_they_are_removed():
    chip = Chip()
    assert chip.read(CSR) == 0x0E00_0000  # 7.3.21: power-on, brown-out and pin
    chip.write(CSR, 1 << 24)
    assert chip.read(CSR) == 0
    chip.reset("software")
    assert chip.read(CSR) == 1 << 28 | 1 << 26


def test_a_reset_bit_of_rcc_resets_its_block_only():
    chip = clocked()
    chip.write(TIM1 + 0x2C, 77)
    chip.write(BDTR, 1)
    chip.write(RCC + 0x24, 1)
    chip.write(RCC + 0x24, 0)
    assert chip.read(TIM1 + 0x2C) == 0xFFFF
    assert chip.read(BDTR) == 0
    assert chip.read(APB2ENR) & 1


def start_up(chip, cfgr=0x9400, wait_states=0x705):
    """Do what start-up code does, in the order of 7.2: HSE, PLL, wait states, prescalers, switch."""
    rcc = chip.view(RCC)
    rcc[0] |= 1 << 16
    while not rcc[0] & 1 << 17:
        chip.advance(1000)
    rcc[1] = 7 << 24 | 1 << 22 | 336 << 6 | 8 | 0x2000_0000
    rcc[0] |= 1 << 24
    while not rcc[0] & 1 << 25:
        chip.advance(1000)
    chip.write(0x4002_3C00, wait_states)
    rcc[2] = cfgr
    rcc[2] |= 2
    return rcc[2] >> 2 & 3


def test_start_up_code_gets_to_168_megahertz():
    chip = Chip(running=False)
    assert start_up(chip) == 2
    assert (chip.rcc.pll_hz(), chip.rcc.apb1_divider, chip.rcc.apb2_divider) == (168e6, 4, 2)
    assert chip.complaints == []


def test_start_up_code_is_told_of_missing_wait_states_and_fast_buses():
    chip = Chip(running=False)
    start_up(chip, cfgr=0, wait_states=0x703)
    assert [c.register for c in chip.complaints] == ["ACR", "CFGR"]
