"""NVIC (PM0214), watchdog (RM0090 section 21) and flash memory (section 3)."""

import pytest

from host.sim.chip.flash import START, sector_range

from .board import CSR, FLASH, IWDG, clocked, reasons

ISER, IPR = 0xE000_E100, 0xE000_E400


# -- NVIC --


def test_the_most_urgent_enabled_interrupt_comes_first():
    chip = clocked()
    chip.write(ISER, 1 << 18 | 1 << 25)
    for interrupt in (18, 25, 5):  # 5 is not enabled
        chip.nvic.line(interrupt, "test", True)
    chip.write(IPR + 18, 0x20, 1)
    chip.write(IPR + 25, 0x10, 1)
    assert chip.pending_interrupts() == [41, 34]
    chip.nvic.enter(41)
    chip.nvic.line(25, "test", False)
    assert chip.pending_interrupts() == []  # 34 is less urgent than what runs
    chip.nvic.leave()
    assert chip.pending_interrupts() == [34]


def test_priorities_have_four_bits():
    chip = clocked()
    chip.write(IPR + 18, 0x2F, 1)
    assert chip.read(IPR + 18, 1) == 0x20
    assert "upper four bits" in reasons(chip)[0]


def test_a_line_that_stays_high_comes_again():
    chip = clocked()
    chip.write(ISER, 1 << 25)
    chip.nvic.line(25, "TIM1", True)
    chip.nvic.enter(41)
    assert chip.nvic.leave() == 41
    assert chip.pending_interrupts() == [41]
    chip.nvic.enter(41)
    chip.nvic.line(25, "TIM1", False)
    chip.nvic.leave()
    assert chip.pending_interrupts() == []


# -- the factory's words --


def test_the_factory_words_are_read_in_half_words():
    chip = clocked()
    assert chip.read(0x1FFF_7A22, 2) == 1024
    assert chip.read(0x1FFF_7A2C, 2) < chip.read(0x1FFF_7A2E, 2)


# -- IWDG --


def watchdog(prescaler=3, reload=999, **more):
    chip = clocked(**more)
    for key in (0xCCCC, 0x5555):
        chip.write(IWDG, key)
    chip.write(IWDG + 4, prescaler)
    chip.write(IWDG + 8, reload)
    while chip.read(IWDG + 12):
        chip.advance(1000)
    chip.write(IWDG, 0xAAAA)
    return chip


@pytest.mark.parametrize("lsi_hz", [17_000, 32_000, 47_000])
def test_the_watchdog_bites_after_its_time(lsi_hz):
    """Table 107: prescaler 32 and 1000 counts are 1 s at 32 kHz."""
    chip = watchdog(lsi_hz=lsi_hz)
    chip.advance(round(0.999 * 32_000 / lsi_hz * 168e6))
    assert chip.resets == []
    chip.advance(round(0.002 * 32_000 / lsi_hz * 168e6))
    assert [cause for _, cause in chip.resets] == ["iwdg"]
    assert chip.read(CSR) >> 29 & 1


def test_the_range_of_its_time():
    chip = watchdog()
    shortest, longest = chip.iwdg.timeout_range_s
    assert (round(shortest, 3), round(longest, 3)) == (0.681, 1.882)


def test_a_fed_watchdog_keeps_still():
    chip = watchdog(prescaler=0, reload=31)  # 4 ms
    for _ in range(20):
        chip.advance(3 * 168_000)
        chip.write(IWDG, 0xAAAA)
    assert chip.resets == []


def test_settings_need_the_key_and_the_last_change_to_be_through():
    chip = clocked()
    chip.write(IWDG + 4, 1)
    assert "0x5555" in reasons(chip)[0]
    chip.write(IWDG, 0x5555)
    chip.write(IWDG + 4, 1)
    assert chip.read(IWDG + 12) == 1
    chip.write(IWDG + 4, 2)
    assert "under way" in reasons(chip)[1]
    chip.advance(round(5.1 / 32_000 * 168e6))
    assert chip.read(IWDG + 12) == 0
    chip.write(IWDG, 0xAAAA)  # closes them again
    chip.write(IWDG + 8, 5)
    assert chip.read(IWDG + 8) == 0xFFF


# -- flash --

KEYR, FSR, FCR = FLASH + 4, FLASH + 12, FLASH + 16
PG, SER, STRT, X32 = 1, 2, 1 << 16, 2 << 8


def unlocked():
    chip = clocked()
    chip.write(KEYR, 0x4567_0123)
    chip.write(KEYR, 0xCDEF_89AB)
    return chip


def finish(chip):
    while chip.read(FSR) & 1 << 16:
        chip.advance(10_000)


def test_sectors_of_one_mebibyte():
    """Table 5."""
    starts = [sector_range(n).start for n in range(12)]
    assert [hex(start) for start in starts[:6]] == [
        "0x8000000", "0x8004000", "0x8008000", "0x800c000", "0x8010000", "0x8020000"]  # fmt: skip
    assert sector_range(11).stop == START + (1 << 20)


def test_programming_only_clears_bits():
    chip = unlocked()
    chip.write(FCR, PG | X32)
    chip.write(START + 0x4000, 0xFFFF_00FF)
    finish(chip)
    chip.write(START + 0x4000, 0x0F0F_FFFF)
    finish(chip)
    assert chip.read(START + 0x4000) == 0x0F0F_00FF
    assert "from 0 to 1" in reasons(chip)[0]


def test_erasing_takes_its_time_and_one_sector():
    chip = unlocked()
    chip.write(FCR, PG | X32)
    chip.write(START + 0x4000, 0)
    chip.write(START + 0x8000, 0)
    finish(chip)
    chip.write(FCR, SER | 1 << 3 | X32)
    begin = chip.now
    chip.write(FCR, SER | 1 << 3 | X32 | STRT)
    finish(chip)
    assert chip.now - begin == pytest.approx(0.25 * 168e6, rel=0.001)
    assert chip.read(START + 0x4000) == 0xFFFF_FFFF
    assert chip.read(START + 0x8000) == 0


@pytest.mark.parametrize(
    ("control", "size", "flag"),
    [(PG | X32, 2, 0x40), (PG, 4, 0x40), (X32, 4, 0x80)],  # wrong parallelism, PG missing
)
def test_wrong_programming_sets_a_flag_and_writes_nothing(control, size, flag):
    chip = unlocked()
    chip.write(FCR, control)
    chip.write(START, 0, size)
    assert chip.read(FSR) & flag
    assert chip.read(START) == 0xFFFF_FFFF
    chip.write(FSR, flag)  # cleared by writing 1
    assert not chip.read(FSR) & flag


def test_a_wrong_key_locks_until_a_reset():
    chip = clocked()
    chip.write(KEYR, 1)
    chip.write(KEYR, 0x4567_0123)
    chip.write(KEYR, 0xCDEF_89AB)
    assert chip.read(FCR) >> 31
    chip.reset("software")
    chip.write(KEYR, 0x4567_0123)
    chip.write(KEYR, 0xCDEF_89AB)
    assert not chip.read(FCR) >> 31


def test_reading_waits_while_the_flash_is_busy():
    chip = unlocked()
    chip.write(FCR, PG | X32)
    chip.write(START, 1)
    begin = chip.now
    assert chip.read(START) == 1
    assert chip.now - begin == 2688  # 16 us


def test_the_power_goes_in_the_middle_of_an_erase():
    chip = unlocked()
    chip.write(FCR, PG | X32)
    for place in (0x4000, 0x7FFC):
        chip.write(START + place, 0)
        finish(chip)
    chip.write(FCR, SER | 1 << 3 | X32 | STRT)
    chip.advance(1000)
    chip.reset("power")
    assert chip.read(START + 0x4000) == 0xFFFF_FFFF
    assert chip.read(START + 0x7FFC) == 0


def test_the_power_goes_before_a_chosen_write():
    class PowerCut(Exception):
        pass

    chip, seen = unlocked(), []

    def step(what, address, value):
        seen.append((what, address, value))
        if len(seen) == 2:
            raise PowerCut

    chip.flash.step = step
    chip.write(FCR, PG | X32)
    chip.write(START, 11)
    with pytest.raises(PowerCut):
        chip.write(START + 4, 22)
    assert seen == [("program", START, 11), ("program", START + 4, 22)]
    chip.reset("power")
    assert chip.read(START + 4) == 0xFFFF_FFFF
