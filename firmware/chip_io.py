"""What a joint does with its chip while it runs: SPI words, slow samples, CAN frames; all hot, on registers.

Each wait has an end: what does not come is told by -1.
"""

from shared.joint.layout import JointIo
from shared.runtime import const, hot, ptr16, reg16, reg32

from .chip import (
    ADC1_CR2_32,
    ADC1_DR_32,
    ADC1_SQR3_32,
    ADC1_SR_32,
    BSY,
    CAN_ESR_32,
    CAN_RF0R_32,
    CAN_RX_32,
    CAN_TSR_32,
    CAN_TX_32,
    EOC,
    GPIOA_SET_16,
    GPIOB_IDR_32,
    GPIOD_SET_16,
    RXNE,
    SPI3_32,
    SPI_DR_32,
    SPI_SR_32,
    TIM5_CNT_32,
)
from .drv8323 import DRIVER_READ, FAULT_STATUS_1, FAULT_STATUS_2
from .encoders import READ_ANGLE, angle_of

_SPI_POLLS = const(400)  # a word of 16 bits at 5.25 MHz takes 3.05 us, some 60 polls
_ADC_POLLS = const(4000)  # 95 us at least: 23 us a slow conversion, which samples of the shunts begin anew
_SELECT_POLLS = const(16)  # reads of a timer, 4 cycles each: 0.38 us (AS5047P: tL and tCSn 0.35)
DRIVER_BIT = const(0x8000)  # PA15 selects the gate driver
JOINT_BIT = const(4)  # PD2 selects the joint's encoder
_FAULT_BIT = const(0x1000)  # PB12, low while the gate driver reports a fault
BUS_CHANNEL = const(13)
_SWSTART_HALF = const(0x20000000)  # CR2 bit 30, told in a number that is within 2^30
_TX_FREE = const(0x1C000000)  # TSR: TME0 .. TME2
_TX_BITS = const(26)
_STANDARD = const(0x7FF)
_NOT_STANDARD_DATA = const(6)  # RIR: IDE, RTR
_FIFO_COUNT = const(3)
_RELEASE = const(0x20)
_BUS_OFF = const(4)


@hot
def spi_word(chip, spi: int, word: int) -> int:
    """Exchange 16 bits on the SPI at place ``spi`` and return what came, or -1."""
    c = reg32(chip)
    c[spi + SPI_DR_32] = word
    return spi_end(chip, spi)


@hot
def spi_end(chip, spi: int) -> int:
    """Wait for the end of a word that was begun and return what came, or -1."""
    c = reg32(chip)
    for _ in range(_SPI_POLLS):
        if c[spi + SPI_SR_32] & (RXNE | BSY) == RXNE:
            return c[spi + SPI_DR_32] & 0xFFFF
    return -1


@hot
def settle(chip) -> None:
    """Give a chip the time it asks for, before its select falls again and before its first clock."""
    c = reg32(chip)
    for _ in range(_SELECT_POLLS):
        c[TIM5_CNT_32]


@hot
def selected_word(chip, select: int, bit: int, word: int) -> int:
    """Exchange a word on SPI 3 with the chip that a pin selects; return what came, or -1.

    ``select``: the place that sets the pin's port, GPIOx_SET_16; the one after it clears.
    """
    h = reg16(chip)
    settle(chip)
    h[select + 1] = bit
    settle(chip)
    came = spi_word(chip, SPI3_32, word)
    h[select] = bit
    return came


@hot
def begin_sample(chip, channel: int) -> None:
    """Begin to convert a slow channel on ADC 1. Samples of the shunts come between and cost it time."""
    c = reg32(chip)
    c[ADC1_SQR3_32] = channel
    start = _SWSTART_HALF
    c[ADC1_CR2_32] = c[ADC1_CR2_32] | start << 1


@hot
def end_sample(chip) -> int:
    """Wait for the slow conversion and return it, 0 .. 4095, or -1."""
    c = reg32(chip)
    for _ in range(_ADC_POLLS):
        if c[ADC1_SR_32] & EOC:
            return c[ADC1_DR_32] & 0xFFF
    return -1


@hot
def sample(chip, channel: int) -> int:
    """Convert another slow channel than the bus voltage and return it, 0 .. 4095, or -1; the bus voltage's goes on."""
    end_sample(chip)
    begin_sample(chip, channel)
    found = end_sample(chip)
    begin_sample(chip, BUS_CHANNEL)
    return found


@hot
def sense(chip, io: JointIo) -> int:
    """Write bus voltage and joint encoder to ``io``; return the gate driver's fault, 0 if none, -1 without an ADC.

    The bus voltage is the one converted since the last call.
    """
    c = reg32(chip)
    bus = end_sample(chip)
    if bus < 0:
        return -1
    io.bus_raw = bus
    begin_sample(chip, BUS_CHANNEL)
    angle = angle_of(selected_word(chip, GPIOD_SET_16, JOINT_BIT, READ_ANGLE))
    io.joint_valid = 0
    if angle >= 0:
        io.joint_raw = angle
        io.joint_valid = 1
    if c[GPIOB_IDR_32] & _FAULT_BIT:
        return 0
    return driver_faults(chip)


@hot
def driver_faults(chip) -> int:
    """Return fault status 1 (bits 0 .. 10) and 2 (bits 11 .. 21), each read once; 1 if they say nothing."""
    first = selected_word(chip, GPIOA_SET_16, DRIVER_BIT, DRIVER_READ | FAULT_STATUS_1 << 11)
    second = selected_word(chip, GPIOA_SET_16, DRIVER_BIT, DRIVER_READ | FAULT_STATUS_2 << 11)
    if first < 0 or second < 0:
        return 1
    found = first & 0x7FF | (second & 0x7FF) << 11
    if found == 0:
        return 1
    return found


@hot
def clock_us(chip) -> int:
    """Return microseconds modulo 2^30."""
    c = reg32(chip)
    return c[TIM5_CNT_32] & 0x3FFFFFFF


@hot
def receive(chip, frame) -> int:
    """Copy the oldest frame out of either FIFO; return its identifier + its length << 11, or -1.

    ``frame`` is an array('H') of four words. FIFO 0 holds what has an order (set-points, SYNC), and comes first.
    """
    c = reg32(chip)
    f = ptr16(frame)
    for fifo in range(2):
        while c[CAN_RF0R_32 + fifo] & _FIFO_COUNT:
            at = CAN_RX_32 + fifo * 4
            head = c[at]
            length = c[at + 1] & 15
            low = c[at + 2]
            high = c[at + 3]
            c[CAN_RF0R_32 + fifo] = _RELEASE
            if head & _NOT_STANDARD_DATA == 0:
                f[0] = low & 0xFFFF
                f[1] = low >> 16 & 0xFFFF
                f[2] = high & 0xFFFF
                f[3] = high >> 16 & 0xFFFF
                return (head >> 21 & _STANDARD) | length << 11
    return -1


@hot
def send(chip, identifier: int, frame, length: int) -> int:
    """Put a frame into a free mailbox; return 1, or 0 if all three are full."""
    c = reg32(chip)
    f = ptr16(frame)
    free = c[CAN_TSR_32] & _TX_FREE
    if free == 0:
        return 0
    at = CAN_TX_32
    free = free >> _TX_BITS
    while free & 1 == 0:
        free = free >> 1
        at += 4
    c[at + 1] = length
    c[at + 2] = f[0] | f[1] << 16
    c[at + 3] = f[2] | f[3] << 16
    c[at] = identifier << 21 | 1
    return 1


@hot
def is_bus_off(chip) -> int:
    """Return 1 while the CAN controller keeps off the bus after too many errors, else 0."""
    c = reg32(chip)
    return (c[CAN_ESR_32] & _BUS_OFF) >> 2
