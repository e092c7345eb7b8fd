"""SPI master (RM0090 section 28) with the AS5047P and the DRV8323S (their data sheets) on its wires."""

import pytest

from host.sim.chip.as5047p import ANGLECOM, ERRFL, As5047p, with_parity
from host.sim.chip.drv8323 import CONTROL, CSA, FAULT1, GATE_HS, OCP, Drv8323s

from .board import GPIO, SPI1, SPI3, clocked, reasons, set_pin

CR1, SR, DR = 0, 8, 12
RXNE, TXE, BSY = 1, 2, 0x80
MASTER_MODE_1_16_BITS = 1 | 4 | 1 << 8 | 1 << 9 | 1 << 11  # CPHA, MSTR, SSI, SSM, DFF
SPE = 1 << 6
DIV_16 = 3 << 3  # 84 / 16 = 5.25 MHz


def bus(cr1=MASTER_MODE_1_16_BITS | DIV_16, base=SPI1):
    """Return a chip with an SPI on its pins, and PC4 and PC5 as high outputs."""
    chip = clocked()
    for pin in ("PA5", "PA6", "PA7") if base == SPI1 else ("PC10", "PC11", "PC12"):
        set_pin(chip, pin, 2, 5 if base == SPI1 else 6)
    chip.write(GPIO["C"] + 0x18, 0x70)
    for pin in ("PC4", "PC5", "PC6"):
        set_pin(chip, pin, 1)
    chip.write(base + CR1, cr1)
    chip.write(base + CR1, cr1 | SPE)
    chip.advance(1000)
    return chip


def select(chip, pin, low, wait=100):
    chip.advance(wait)
    chip.write(GPIO["C"] + 0x18, 1 << int(pin[2:]) << (16 if low else 0))
    chip.advance(wait)


def transfer(chip, word, base=SPI1, pin="PC4", wait=100):
    """Send a word to the chip selected by a pin and return what comes back."""
    select(chip, pin, True, wait)
    chip.write(base + DR, word)
    while not chip.read(base + SR) & RXNE:
        chip.advance(1)
    answer = chip.read(base + DR)
    while chip.read(base + SR) & BSY:
        chip.advance(1)
    select(chip, pin, False, wait)
    return answer


def read_command(address):
    return with_parity(1 << 14 | address)


# -- 28.3: the master --


@pytest.mark.parametrize(("base", "bus_divider"), [(SPI1, 2), (SPI3, 4)])
@pytest.mark.parametrize("code", [1, 3, 7])
def test_a_frame_lasts_its_bits_at_the_baud_rate(base, bus_divider, code):
    chip = bus(MASTER_MODE_1_16_BITS | code << 3, base)
    begin = chip.now
    chip.write(base + DR, 0x1234)
    assert chip.read(base + SR) & (TXE | BSY) == TXE | BSY  # the word has gone on to the shift register
    bit = bus_divider * 2 ** (code + 1)
    while chip.read(base + SR) & BSY:
        chip.advance(1)
    assert chip.now - begin == 16 * bit


def test_settings_changed_while_enabled_and_stopping_in_a_frame_are_told():
    chip = bus()
    chip.write(SPI1 + CR1, chip.read(SPI1 + CR1) ^ 8)
    chip.write(SPI1 + DR, 1)
    chip.write(SPI1 + CR1, chip.read(SPI1 + CR1) & ~SPE)
    assert "changed while SPE" in reasons(chip)[0]
    assert "frame is under way" in reasons(chip)[1]


def test_wires_without_pins_are_told():
    chip = bus()
    set_pin(chip, "PA6", 0)
    chip.write(SPI1 + CR1, MASTER_MODE_1_16_BITS | DIV_16)
    chip.write(SPI1 + CR1, MASTER_MODE_1_16_BITS | DIV_16 | SPE)
    chip.write(SPI1 + DR, 0)
    assert "SPI1_MISO: no pin" in reasons(chip)[0]


# -- AS5047P --


def sensor(angle=0x1234, **more):
    chip = bus(**more)
    return chip, As5047p(chip, "SPI1", "PC4", lambda cycle: angle)


def test_the_answer_to_a_read_comes_with_the_next_word():
    chip, _ = sensor()
    first = transfer(chip, read_command(ANGLECOM))
    second = transfer(chip, read_command(ANGLECOM))
    assert first == 0
    assert second & 0x3FFF == 0x1234
    assert second.bit_count() % 2 == 0
    assert chip.complaints == []


def test_the_angle_is_that_of_the_end_of_the_command():
    chip = bus()
    As5047p(chip, "SPI1", "PC4", lambda cycle: cycle // 100)
    transfer(chip, 0xFFFF)
    deselected = chip.now - 100
    chip.advance(50_000)
    assert transfer(chip, 0xFFFF) & 0x3FFF == deselected // 100


def test_wrong_parity_sets_the_error_flag_until_the_error_register_is_read():
    chip, _ = sensor()
    transfer(chip, read_command(ANGLECOM) ^ 0x8000)
    assert transfer(chip, read_command(ANGLECOM)) & 0x4000
    assert transfer(chip, read_command(ERRFL)) & 0x4000  # the angle, with the flag still up
    answer = transfer(chip, 0xC000)
    assert answer & 0x3FFF == 4  # PARERR
    assert not answer & 0x4000
    assert not transfer(chip, 0xC000) & 0x4000


def test_an_address_that_is_not_there_is_an_invalid_command():
    chip, sensed = sensor()
    transfer(chip, read_command(0x1000))
    assert sensed.errors == 2


@pytest.mark.parametrize(
    ("cr1", "wait", "word"),
    [
        (MASTER_MODE_1_16_BITS | 1 << 3, 100, "at most 10000000 Hz"),  # 21 MHz
        (MASTER_MODE_1_16_BITS | DIV_16, 20, "350 ns"),  # 20 cycles are 119 ns
        (MASTER_MODE_1_16_BITS & ~1 | DIV_16, 100, "mode 0"),
        (MASTER_MODE_1_16_BITS | 2 | DIV_16, 100, "mode 3"),
    ],
)
def test_wrong_times_and_modes_are_told(cr1, wait, word):
    chip, _ = sensor(cr1=cr1)
    transfer(chip, 0xFFFF, wait=wait)
    assert word in reasons(chip)[0]


def test_deselecting_at_rxne_is_too_early_and_in_the_middle_is_a_framing_error():
    """The last clock edge sets RXNE, half a bit before BSY falls; t_H is half a bit."""
    chip, sensed = sensor()
    for bits, error in ((15.6, 0), (10, 1)):
        select(chip, "PC4", True)
        chip.write(SPI1 + DR, 0xFFFF)
        chip.advance(round(bits * 32))
        chip.write(GPIO["C"] + 0x18, 1 << 4)
        chip.advance(1000)
        chip.read(SPI1 + DR)
        assert sensed.errors == error
    assert "95 ns after the last clock edge" in reasons(chip)[0]
    assert "frame is under way" in reasons(chip)[1]


def test_two_selected_slaves_are_told():
    chip, _ = sensor()
    As5047p(chip, "SPI1", "PC5", lambda cycle: 0, name="other")
    chip.write(GPIO["C"] + 0x18, 1 << 21)
    transfer(chip, 0xFFFF)
    assert "several slaves" in reasons(chip)[0]


# -- DRV8323S --


def driver(enable=True, **more):
    chip = bus(**more)
    chip.write(GPIO["C"] + 0x18, 1 << 22)  # ENABLE low
    chip.advance(1000)
    gate = Drv8323s(chip, "SPI1", "PC4", "PC6", fault_pin="PB2")
    if enable:
        chip.write(GPIO["C"] + 0x18, 1 << 6)
        chip.advance(168_000)
    return chip, gate


def read_register(chip, address):
    return transfer(chip, 1 << 15 | address << 11) & 0x7FF


def test_reset_values_of_the_gate_driver():
    chip, _ = driver()
    words = [read_register(chip, address) for address in range(7)]
    assert words == [0, 0, 0, 0x3FF, 0x7FF, 0x159, 0x283]
    assert chip.complaints == []


def test_a_write_answers_with_the_old_value_in_the_same_word():
    chip, _ = driver()
    assert transfer(chip, OCP << 11 | 0x123) & 0x7FF == 0x159
    assert read_register(chip, OCP) == 0x123


def test_the_gate_driver_wants_a_millisecond_after_enable():
    chip, _ = driver(enable=False)
    chip.write(GPIO["C"] + 0x18, 1 << 6)
    chip.advance(160_000)
    transfer(chip, 1 << 15 | CSA << 11)
    assert "within 1 ms" in reasons(chip)[0]


def test_a_fault_pulls_nfault_until_it_is_cleared():
    chip, gate = driver()
    assert chip.pins.level("PB2") == 1
    gate.raise_fault(FAULT1, 1 << 9 | 1 << 5)
    assert chip.pins.level("PB2") == 0
    assert read_register(chip, FAULT1) == 0x620
    transfer(chip, CONTROL << 11 | 1)
    assert chip.pins.level("PB2") == 1
    assert read_register(chip, FAULT1) == 0
    assert read_register(chip, CONTROL) == 0  # CLR_FLT clears itself


def test_asleep_the_gate_driver_forgets_its_registers():
    chip, _ = driver()
    transfer(chip, OCP << 11 | 0x123)
    chip.write(GPIO["C"] + 0x18, 1 << 22)
    chip.advance(168 * 1100)
    chip.write(GPIO["C"] + 0x18, 1 << 6)
    chip.advance(170_000)
    assert read_register(chip, OCP) == 0x159
    assert chip.complaints == []


def test_two_words_in_one_select_are_a_framing_error_and_an_unread_one_an_overrun():
    chip, sensed = sensor()
    select(chip, "PC4", True)
    for _ in range(2):
        chip.write(SPI1 + DR, 0xFFFF)
        chip.advance(16 * 32 + 10)
    select(chip, "PC4", False)
    assert sensed.errors == 1
    assert "overrun" in reasons(chip)[0]


def test_what_is_not_modelled_is_told():
    chip, _ = driver()
    transfer(chip, GATE_HS << 11 | 6 << 8)
    assert "locking is not modelled" in reasons(chip)[0]
    for wrong in (1 << 11, 1 << 9, 1 << 8):  # 8 bits, without SSM, without SSI
        assert "is modelled" in reasons(bus(MASTER_MODE_1_16_BITS & ~wrong))[0]
    chip = bus()
    for word in (1, 2):
        chip.write(SPI1 + DR, word)
    assert "not modelled" in reasons(chip)[0]
