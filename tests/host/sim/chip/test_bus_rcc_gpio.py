"""Memory map, clock gates, resets and pins: RM0090 sections 7 and 8."""

import pytest

from host.sim.chip import Chip

from .board import APB2ENR, CSR, GPIO, TIM1, clocked, reasons, set_pin


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


def test_a_signal_reaches_the_pin_whose_alternate_function_is_chosen():
    chip = clocked()
    set_pin(chip, "PA8", 2, 1)
    assert chip.pins.pin_of("TIM1_CH1") == "PA8"
    assert chip.complaints == []
    for pin in ("PA6", "PB12"):
        set_pin(chip, pin, 2, 1)
    chip.pins.pin_of("TIM1_BKIN")
    chip.pins.pin_of("TIM1_CH2")
    assert "several pins: PA6, PB12" in reasons(chip)[0]
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


def test_reset_flags_stay_through_a_reset():
    chip = Chip()
    assert chip.read(CSR) == 0x0E00_0000  # 7.3.21: power-on, brown-out and pin
    chip.reset("software")
    assert chip.read(CSR) == 0x0E00_0000 | 1 << 28
