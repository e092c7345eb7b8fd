"""ADC1 to ADC3: RM0090 section 13 and the data sheet DS8626."""

import pytest

from host.sim.chip.bridge import HalfBridges

from .board import (
    ADC1,
    ADC2,
    ADC_COMMON,
    ARPE,
    ARR,
    BDTR,
    CCER,
    CCMR1,
    CCR1,
    CEN,
    CENTRE,
    CR1,
    CR2,
    EGR,
    RCR,
    UG,
    clocked,
    forgive,
    reasons,
    set_pin,
)

SR, ACR2, SMPR1, SMPR2, SQR3, JSQR, JDR1, DR = 0, 8, 12, 16, 0x34, 0x38, 0x3C, 0x4C
ADON, SWSTART, RISING, TRGO = 1, 1 << 30, 1 << 20, 1 << 16
TICK = 8  # core cycles of one ADCCLK at PCLK2 / 4 = 21 MHz


def converter(base=ADC1, prescaler=1):
    """Return a chip with an ADC switched on and all its pins analog; ADCCLK is PCLK2 / 4 = 21 MHz."""
    chip = clocked()
    for pin in ("PC0", "PC1", "PC2", "PC3", "PA0", "PA1"):
        set_pin(chip, pin, 3)
    chip.write(ADC_COMMON + 4, prescaler << 16)
    chip.write(base + ACR2, ADON)
    chip.advance(600)
    return chip


def convert(chip, channel, base=ADC1):
    """Start a regular conversion."""
    chip.write(base + SQR3, channel)
    chip.write(base + ACR2, ADON | SWSTART)


def constant(value):
    return lambda cycle: value


def done_after(chip, base=ADC1, flag=4, limit=20_000):
    """Return how many cycles from now a flag of SR is set."""
    begin = chip.now
    while not chip.read(base + SR) & flag:
        assert chip.now - begin < limit
        chip.advance(1)
    return chip.now - begin


@pytest.mark.parametrize(
    ("code", "sampling"), [(0, 3), (1, 15), (2, 28), (3, 56), (4, 84), (5, 112), (6, 144), (7, 480)]
)
def test_a_conversion_takes_sampling_plus_twelve(code, sampling):
    """13.7: the conversion; DS8626 t_latr: up to 2 cycles before it."""
    chip = converter()
    chip.analog["PC1"] = constant(1234)
    chip.write(ADC1 + SMPR1, code << 3)  # channel 11 is the second of SMPR1
    convert(chip, 11)
    assert done_after(chip, flag=2) == (2 + sampling + 12) * TICK
    assert chip.read(ADC1 + DR) == 1234
    assert not chip.read(ADC1 + SR) & 2  # reading DR clears EOC
    assert chip.complaints == []


def test_channels_0_to_9_have_their_sampling_time_in_smpr2():
    chip = converter()
    chip.write(ADC1 + SMPR2, 7 << 3)
    convert(chip, 1)
    assert done_after(chip, flag=2) == (2 + 480 + 12) * TICK


def test_an_injected_trigger_resets_a_regular_conversion_that_starts_again_afterwards():
    chip = converter()
    chip.analog["PC0"], chip.analog["PC1"] = constant(10), constant(11)
    chip.write(ADC1 + SQR3, 10)
    chip.write(ADC1 + SMPR1, 3)  # channel 10: 56
    chip.write(ADC1 + JSQR, 11 << 15)
    chip.write(ADC1 + ACR2, ADON | RISING | TRGO | SWSTART)
    chip.advance(30 * TICK)
    begin = chip.now
    chip.trigger_adcs()
    assert done_after(chip, flag=4) == (3 + 15) * TICK
    done_after(chip, flag=2)
    assert chip.now - begin == (3 + 15 + 2 + 56 + 12) * TICK
    assert [sample.channel for sample in chip.adcs["ADC1"].samples] == [11, 10]


def test_a_regular_start_during_an_injected_sequence_waits():
    chip = converter()
    chip.write(ADC1 + SQR3, 10)
    chip.write(ADC1 + JSQR, 11 << 15)
    chip.write(ADC1 + ACR2, ADON | RISING | TRGO)
    chip.trigger_adcs()
    chip.advance(TICK)
    chip.write(ADC1 + ACR2, ADON | RISING | TRGO | SWSTART)
    done_after(chip, flag=2)
    assert [sample.group for sample in chip.adcs["ADC1"].samples] == ["injected", "regular"]


def test_starting_in_the_write_that_switches_on_converts_nothing():
    chip = clocked()
    chip.write(ADC1 + ACR2, ADON | SWSTART)
    chip.advance(5000)
    assert chip.adcs["ADC1"].samples == []
    assert "ADON is 0" in reasons(chip)[0]


def test_converting_right_after_switching_on_is_too_soon():
    chip = clocked()
    set_pin(chip, "PC0", 3)
    chip.write(ADC_COMMON + 4, 1 << 16)
    chip.write(ADC1 + SQR3, 10)
    chip.write(ADC1 + ACR2, ADON)
    chip.advance(100)
    chip.write(ADC1 + ACR2, ADON | SWSTART)
    assert "t_STAB" in reasons(chip)[0]


def test_too_fast_a_clock_is_told():
    chip = converter(prescaler=0)  # 84 / 2 = 42 MHz
    convert(chip, 10)
    assert "42000000 Hz is above 36 MHz" in reasons(chip)[0]


def test_a_pin_that_is_not_analog_is_told():
    chip = converter()
    convert(chip, 5)
    assert "PA5 is not in analog mode" in reasons(chip)[0]


@pytest.mark.parametrize(("code", "told"), [(6, True), (7, False)])  # 144 cycles are 6.9 us, 480 are 22.9 us
def test_the_temperature_sensor_wants_ten_microseconds(code, told):
    chip = converter()
    chip.write(ADC_COMMON + 4, 1 << 16 | 1 << 23)
    chip.advance(2000)
    chip.write(ADC1 + SMPR1, code << 18)
    convert(chip, 16)
    assert bool(chip.complaints) == told


def test_the_temperature_sensor_wants_tsvrefe_and_adc1():
    chip = converter()
    chip.write(ADC1 + SMPR1, 7 << 18)
    convert(chip, 16)
    assert "TSVREFE" in reasons(chip)[0]
    chip = converter(ADC2)
    convert(chip, 16, ADC2)
    assert "does not exist" in reasons(chip)[0]


def with_pwm():
    """Return a chip with a half bridge whose ADC1 waits for each second update, at the top of 1000."""
    chip = converter()
    chip.analog["PC0"] = lambda cycle: cycle % 4096
    for address, value in ((CR1, CENTRE | ARPE), (CR2, 0x20), (ARR, 1000), (CCMR1, 0x60), (CCR1, 300), (CCER, 5),
                           (EGR, UG), (RCR, 1), (BDTR, 0x8000 | 20)):  # fmt: skip
        chip.write(address, value)
    chip.write(ADC1 + JSQR, 10 << 15)
    chip.write(ADC1 + ACR2, ADON | RISING | TRGO)
    set_pin(chip, "PA8", 2, 1)
    set_pin(chip, "PB13", 2, 1)
    forgive(chip)
    return chip


def test_trgo_starts_the_injected_conversion_at_the_update():
    chip = with_pwm()
    begin = chip.now
    chip.write(CR1, CENTRE | ARPE | CEN)
    chip.advance(4000)
    samples = chip.adcs["ADC1"].samples
    assert [sample.trigger - begin for sample in samples] == [1000, 3000]
    first = samples[0]
    assert (first.latest - begin, first.done - begin) == (1000 + 48, 1000 + 48 + 96)
    assert first.counts == first.latest % 4096 == chip.read(ADC1 + JDR1) - 2000


@pytest.mark.parametrize(("word", "told"), [(RISING, "another trigger"), (1 << 1, "not modelled")])
def test_another_trigger_and_what_is_not_modelled_are_told(word, told):
    chip = converter()
    chip.write(ADC1 + ACR2, ADON | word)
    assert told in reasons(chip)[0]


def test_samples_are_placed_in_the_low_side_window():
    chip = with_pwm()
    bridges = HalfBridges(chip, {"a": ("PA8", "PB13")})
    begin = chip.now
    chip.write(CR1, CENTRE | ARPE | CEN)
    chip.advance(6100)
    # The high side goes off at 300, the low side is on from 320 to 1700: 2000 - 300.
    assert [(a - begin, b - begin) for a, b in bridges.low_windows("a")] == [(320, 1700), (2320, 3700), (4320, 5700)]
    check = bridges.check_samples({("ADC1", 10): "a"})[0]
    assert (check.before, check.after) == (1000 - 320, 1700 - 1048)
    assert check.inside(680)
    assert not check.inside(681)


def test_a_sample_outside_the_window_is_found():
    chip = with_pwm()
    chip.write(CCR1, 990)  # the low side would be on from 1010 to 1010
    bridges = HalfBridges(chip, {"a": ("PA8", "PB13")})
    chip.write(CR1, CENTRE | ARPE | CEN)
    chip.advance(4000)
    checks = bridges.check_samples({("ADC1", 10): "a"})
    assert checks
    assert not any(check.inside() for check in checks)
