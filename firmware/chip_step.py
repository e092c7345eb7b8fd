"""The current step's interrupt on the chip: samples, rotor encoder, control, compares; no HAL, no bytecode.

Timer 1 counts up and down at 20 kHz; its update event comes at the top of each second period. It starts the three ADCs
(through TRGO), makes the compares written a step ago act, and calls this. The rotor's word is on the wire (3 us) while
the rest is got ready.
"""

from shared.joint.layout import CurrentLoop
from shared.runtime import const, hot, reg16, reg32

from .chip import (
    ADC1_JDR1_32,
    ADC1_SR_32,
    ADC2_JDR1_32,
    ADC2_SR_32,
    ADC3_JDR1_32,
    ADC3_SR_32,
    GPIOC_CLEAR_16,
    GPIOC_SET_16,
    JEOC,
    MOE,
    SPI1_32,
    SPI_DR_32,
    TIM1_BDTR_32,
    TIM1_CCR1_32,
    TIM1_CCR2_32,
    TIM1_CCR3_32,
    TIM5_CNT_32,
)
from .chip_io import settle, spi_end, spi_word
from .chip_setup import PERIOD
from .encoders import READ_ANGLE, angle_of
from .joint_run import BRIDGE_OFF, BRIDGE_ON, PART_STEP, STALE_MOST, BoardRun, take_step

_ROTOR_BIT = const(0x40)  # PC6
_SAMPLE_POLLS = const(60)  # a sample takes 27 ADC clocks, 1.3 us; a poll three reads
_ALL_BUT_JEOC = const(0x3B)  # bits written as 1 stay: a slow conversion under way keeps its end
_MASK = const(0x3FFFFFFF)


@hot
def interrupt(chip, loop: CurrentLoop, run: BoardRun, timer) -> int:
    """Do one current step; return what became of the bridge. ``timer`` is what calls, and not needed."""
    c = reg32(chip)
    h = reg16(chip)
    h[GPIOC_CLEAR_16] = _ROTOR_BIT
    now = c[TIM5_CNT_32] & _MASK
    settle(chip)
    c[SPI1_32 + SPI_DR_32] = READ_ANGLE
    fresh = take_samples(chip, loop, run)
    word = spi_end(chip, SPI1_32)
    h[GPIOC_SET_16] = _ROTOR_BIT
    bridge = take_step(loop, run, now, angle_of(word))
    if bridge == BRIDGE_OFF or fresh == 0:
        return bridge_off(chip, run)
    if bridge == BRIDGE_ON:
        write_compares(chip, loop)
    return bridge


@hot
def rotor_angle(chip) -> int:
    """Return the rotor encoder's angle, 0 .. 16383, or -1; only while the interrupt does not run.

    It is asked twice, because a word answers the one before: the first after power-on says 0, and would pass for it.
    """
    h = reg16(chip)
    word = 0
    for _ in range(2):
        settle(chip)
        h[GPIOC_CLEAR_16] = _ROTOR_BIT
        settle(chip)
        word = spi_word(chip, SPI1_32, READ_ANGLE)
        h[GPIOC_SET_16] = _ROTOR_BIT
    return angle_of(word)


@hot
def take_samples(chip, loop: CurrentLoop, run: BoardRun) -> int:
    """Write the shunts' samples to loop.raw; return 0 after too many steps in a row without new ones, else 1."""
    c = reg32(chip)
    run.stale_steps += 1
    for _ in range(_SAMPLE_POLLS):
        if c[ADC1_SR_32] & c[ADC2_SR_32] & c[ADC3_SR_32] & JEOC:
            c[ADC1_SR_32] = _ALL_BUT_JEOC
            c[ADC2_SR_32] = _ALL_BUT_JEOC
            c[ADC3_SR_32] = _ALL_BUT_JEOC
            run.stale_steps = 0
            break
    loop.raw[0] = c[ADC1_JDR1_32] & 0xFFF
    loop.raw[1] = c[ADC2_JDR1_32] & 0xFFF
    loop.raw[2] = c[ADC3_JDR1_32] & 0xFFF
    if run.stale_steps > STALE_MOST:
        run.failed_part = PART_STEP
        return 0
    return 1


@hot
def write_compares(chip, loop: CurrentLoop) -> None:
    """Set the compares; they act from the next update event on, all at once."""
    c = reg32(chip)
    c[TIM1_CCR1_32] = loop.duty[0]
    c[TIM1_CCR2_32] = loop.duty[1]
    c[TIM1_CCR3_32] = loop.duty[2]


@hot
def bridge_on(chip) -> None:
    """Let the outputs follow the compares."""
    c = reg32(chip)
    c[TIM1_BDTR_32] = c[TIM1_BDTR_32] | MOE


@hot
def bridge_off(chip, run: BoardRun) -> int:
    """Switch all six gates off; return BRIDGE_OFF."""
    run.bridge = 0
    return outputs_off(chip)


@hot
def outputs_off(chip) -> int:
    """Switch all six gates off, whatever the rest thinks; return BRIDGE_OFF.

    The compares go to the middle: switched on again, the bridge begins without voltage and not where it left off.
    """
    c = reg32(chip)
    c[TIM1_BDTR_32] = c[TIM1_BDTR_32] & ~MOE
    c[TIM1_CCR1_32] = PERIOD // 2
    c[TIM1_CCR2_32] = PERIOD // 2
    c[TIM1_CCR3_32] = PERIOD // 2
    return BRIDGE_OFF
