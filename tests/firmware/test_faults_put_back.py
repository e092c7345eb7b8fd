"""Each fault that was once in the driver, or could be, put back: one of the checks on the model of the chip must fail.

A check that passes with the fault in it would be worth nothing. Which one catches a fault is named beside it.
"""

import pytest

from firmware import board_stm32f405, chip_io, chip_setup, chip_step, joint_run
from firmware.chip import (
    ADC1_32,
    ADC_JSQR_32,
    ADC_STEP_32,
    CAN_FS1R_32,
    RXNE,
    SPI_DR_32,
    SPI_SR_32,
    TIM1_BDTR_32,
    TIM1_CCR1_32,
    TIM1_CCR3_32,
    TIM1_RCR_32,
    peek,
    poke,
)
from host.sim.chip.joint_board import JointBoard
from shared.runtime import reg32

from . import chip_checks as checks
from . import on_chip


def constants(module, **values):
    """Return a fault that is other values of a module's constants."""

    def put_back(monkeypatch):
        for name, value in values.items():
            assert getattr(module, name) != value
            monkeypatch.setattr(module, name, value)

    return put_back


def afterwards(module, name, act):
    """Return a fault that is ``act(chip)`` after a function of a module has done its part."""

    def put_back(monkeypatch):
        real = getattr(module, name)

        def wrong(chip, *more):
            result = real(chip, *more)
            act(chip)
            return result

        monkeypatch.setattr(module, name, wrong)

    return put_back


def writing(at, value):
    """Return a fault that is another value written to one place while the chip is set up."""

    def wrong(chip, place, right):
        return poke(chip, place, value if place == at else right)

    return instead(chip_setup, "poke", wrong)


def instead(module, name, wrong):
    return lambda monkeypatch: monkeypatch.setattr(module, name, wrong)


def trigger_by_compare_4(monkeypatch):
    """The ADCs wait for TIM1_CC4, which is the fourth compare at the top: two manuals tell differently what it is."""
    monkeypatch.setattr(chip_setup, "_INJECTED_BY_TRGO", 0x00100001)
    monkeypatch.setattr(chip_setup, "_PWM1_LOW", 0x6868)
    monkeypatch.setattr(chip_setup, "_OUTPUTS", 0x1555)


def at_the_bottom(monkeypatch):
    """RCR is odd from the start, and nobody looks where the updates fall."""
    monkeypatch.setattr(chip_setup, "_EACH", 3)
    monkeypatch.setattr(chip_setup, "align_updates", lambda chip: 1)


def wrong_ranks(chip):
    for number in range(3):
        poke(chip, ADC1_32 + number * ADC_STEP_32 + ADC_JSQR_32, 10 + number)


def crossed_shunts(chip):
    for number in range(3):
        poke(chip, ADC1_32 + number * ADC_STEP_32 + ADC_JSQR_32, (12 - number) << 15)


def until_rxne(chip, spi):
    """Return the word as soon as it is in: half a clock before its end."""
    c = reg32(chip)
    for _ in range(400):
        if c[spi + SPI_SR_32] & RXNE:
            return c[spi + SPI_DR_32] & 0xFFFF
    return -1


def without_the_step_before(loop, run, now_us, rotor, real=joint_run.take_step):
    run.masked_before = 0
    return real(loop, run, now_us, rotor)


def no_pull_of_the_break(monkeypatch):
    rows = tuple(row if row[:2] != (1, 12) else (1, 12, 0, 0, 1) for row in chip_setup._PINS)
    monkeypatch.setattr(chip_setup, "_PINS", rows)


FAULTS = {
    "phase c sampled for 112 cycles": (
        constants(chip_setup, _SMPR1=0x0DB6DB49 & 0x07FFFFFF), checks.samples_lie_in_the_low_sides),
    "temperature sensor sampled too shortly": (
        constants(chip_setup, _SMPR1=0x0DB6DB49 & 0x07FFFFFF), checks.started_without_complaint),
    "thermistor's and the chip's channels at 3 cycles": (
        constants(chip_setup, _SMPR1=0x49, _SMPR2=0), checks.sensors_are_read),
    "trigger by CC4": (trigger_by_compare_4, checks.started_without_complaint),
    "updates at the bottom": (at_the_bottom, checks.steps_come_at_the_top),
    "an update each PWM period": (constants(chip_setup, _FOURTH=1), checks.steps_come_at_the_top),
    "period one short": (constants(chip_setup, PERIOD=4199), checks.steps_come_at_the_top),
    "compares without preload": (
        constants(chip_setup, _PWM1_BOTH=0x6060, _PWM1_LOW=0x60), checks.compares_act_a_whole_step_later),
    "mask of one step only": (
        instead(chip_step, "take_step", without_the_step_before), checks.samples_lie_in_the_low_sides),
    "phases a and c crossed at the pins": (
        constants(chip_step, TIM1_CCR1_32=TIM1_CCR3_32, TIM1_CCR3_32=TIM1_CCR1_32), checks.duties_are_at_the_pins),
    "no OSSI": (constants(chip_setup, _OFF_BREAK=0x1800), checks.pins_without_torque_are_low),
    "dead time 0": (constants(chip_setup, DEAD_TICKS=0), checks.gates_keep_their_dead_time),
    "dead time 95 ns": (constants(chip_setup, DEAD_TICKS=16), checks.gates_keep_their_dead_time),
    "low sides' polarity": (constants(chip_setup, _OUTPUTS=0xDDD), checks.gates_keep_their_dead_time),
    "break by a high level": (constants(chip_setup, _OFF_BREAK=0x3C00), checks.armed_moves_its_gates),
    "no break": (constants(chip_setup, _OFF_BREAK=0x0C00), checks.a_fault_of_the_driver_needs_no_software),
    "nFAULT not given to the timer": (no_pull_of_the_break, checks.started_without_complaint),
    "shunt in the wrong rank": (
        afterwards(board_stm32f405, "set_up_adcs", wrong_ranks), checks.started_without_complaint),
    "shunts crossed": (
        afterwards(board_stm32f405, "set_up_adcs", crossed_shunts), checks.started_without_complaint),
    "ADC at 42 MHz": (constants(chip_setup, _PCLK2_BY_4_AND_SENSOR=0x00800000), checks.started_without_complaint),
    "temperature sensor off": (
        constants(chip_setup, _PCLK2_BY_4_AND_SENSOR=0x00010000), checks.started_without_complaint),
    "old samples taken for new": (
        constants(chip_step, _ALL_BUT_JEOC=0x3F), checks.a_trigger_that_stops_ends_the_torque),
    "any number of old samples": (
        constants(chip_step, STALE_MOST=1 << 20), checks.a_trigger_that_stops_ends_the_torque),
    "a slow conversion's end is cleared": (constants(chip_step, _ALL_BUT_JEOC=0), checks.started_without_complaint),
    "SPI mode 0": (constants(chip_setup, _SPI_MODE_1=0x0B44), checks.sensors_are_read),
    "SPI 1 at 10.5 MHz": (constants(chip_setup, _SPI1_BY_16=0x10), checks.sensors_are_read),
    "SPI 3 at 10.5 MHz": (constants(chip_setup, _SPI3_BY_8=0x08), checks.sensors_are_read),
    "select released at RXNE, joint": (instead(chip_io, "spi_end", until_rxne), checks.sensors_are_read),
    "select released at RXNE, rotor": (instead(chip_step, "spi_end", until_rxne), checks.sensors_are_read),
    "no time between select and clock": (
        instead(chip_step, "settle", lambda chip: 0), checks.started_without_complaint),
    "no time between two words": (instead(chip_io, "settle", lambda chip: 0), checks.started_without_complaint),
    "CAN at 0.5 Mbit": (constants(chip_setup, _CAN_1M=0x00290005), checks.frames_keep_their_bytes),
    "CAN without recovery": (constants(chip_setup, _CAN_RUN=0), checks.bus_off_and_back),
    "filters of 32 bits": (writing(CAN_FS1R_32, 15), checks.started_without_complaint),
    "filters blind to RTR and IDE": (constants(chip_setup, _EXACT=0), checks.filters_pass_what_the_joint_needs),
    "set-points and SYNC in two FIFOs": (
        constants(chip_setup, _FIFO_OF_BANKS=0x0E), checks.filters_pass_what_the_joint_needs),
    "FIFOs swapped": (constants(chip_setup, _FIFO_OF_BANKS=0x05), checks.filters_pass_what_the_joint_needs),
    "FIFO not released": (constants(chip_io, _RELEASE=0), checks.frames_keep_their_bytes),
    "watchdog's registers without their key": (
        constants(chip_setup, _IWDG_UNLOCK=0xAAAA), checks.the_watchdog_waits_as_stated),
    "watchdog of 20 ms": (constants(chip_setup, WATCHDOG_MS=20), checks.the_watchdog_waits_as_stated),
    "watchdog by 4": (constants(chip_setup, _IWDG_BY_32=0), checks.the_watchdog_waits_as_stated),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_put_back_is_caught(monkeypatch, name):
    put_back, check = FAULTS[name]
    put_back(monkeypatch)
    with pytest.raises(AssertionError):
        check()


def test_updates_that_do_not_come_at_the_top_are_found_by_the_driver_itself(monkeypatch):
    monkeypatch.setattr(chip_setup, "_FOURTH", 2)  # each third end: top and bottom in turn
    assert on_chip.OnChip().driver.wrong == TIM1_RCR_32
    monkeypatch.undo()
    assert on_chip.OnChip().driver.wrong == 0


def test_a_register_that_does_not_read_back_is_named(monkeypatch):
    board = JointBoard()
    board.model.tim1._writers[0x44] = lambda old, new: board.model.tim1.value.__setitem__("BDTR", old)
    joint = on_chip.OnChip(board)
    assert joint.driver.wrong == TIM1_BDTR_32
    assert peek(board.chip, TIM1_BDTR_32) == 0
    assert joint.driver.driver_setup() == board_stm32f405._OF_THE_CHIP
