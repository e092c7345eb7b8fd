"""Registers of the STM32F405 that MicroPython has no call for (RM0090): addresses, bits, and their set-up in order.

``Registers(stm)`` takes MicroPython's ``stm`` module, or a fake one. Everything written here is written before the
interrupt starts; values of 2^30 and more, which would be heap objects, are avoided afterwards.
"""

from shared.runtime import const

# Timer 1 (RM0090 section 17.4); offsets
TIM1 = const(0x40010000)
CR1 = const(0x00)
CCMR1 = const(0x18)
CCMR2 = const(0x1C)
CCER = const(0x20)
RCR = const(0x30)
CCR1 = const(0x34)
CCR2 = const(0x38)
CCR3 = const(0x3C)
CCR4 = const(0x40)
BDTR = const(0x44)
CR2 = const(0x04)
EGR = const(0x14)
MOE = const(0x8000)  # main output enable
_OSSR_OSSI = const(0x0C00)  # while MOE is off the pins are driven low: both gates of a phase off
_PRELOAD_PWM1_BOTH = const(0x6868)  # OCxM = 110, OCxPE
_PRELOAD_PWM1_TOP = const(0x7068)  # channel 4: PWM mode 2, high around the top, its rise starts the ADCs
_OUTPUTS = const(0x1555)  # CC1..3 and their complements, CC4; all active high
_TWICE_A_PERIOD = const(3)  # update event each fourth half period: 10 kHz of 20 kHz

# ADCs (section 13.13)
ADC1 = const(0x40012000)
ADC2 = const(0x40012100)
ADC3 = const(0x40012200)
ADC_COMMON = const(0x40012304)
ADC_SR = const(0x00)
ADC_CR1 = const(0x04)
ADC_CR2 = const(0x08)
ADC_SMPR1 = const(0x0C)
ADC_SMPR2 = const(0x10)
ADC_SQR1 = const(0x2C)
ADC_SQR3 = const(0x34)
ADC_JSQR = const(0x38)
ADC_JDR1 = const(0x3C)
ADC_DR = const(0x4C)
EOC = const(2)
JEOC = const(4)
_ALL_BUT_JEOC = const(0x3B)
_PCLK2_BY_4_AND_SENSOR = const(0x00810000)  # 21 MHz; TSVREFE: the temperature sensor is on
_INJECTED_BY_TIM1_CC4 = const(0x00100001)  # JEXTEN rising edge, JEXTSEL 0000, ADON
_SWSTART_HIGH = const(0x4000)  # bit 30, in the upper half word
_SMPR_15_CYCLES_10_TO_12 = const(0x0DB6DB49)  # channels 10 .. 12 15 cycles (0.7 us), 13 .. 18 480 cycles

# RCC (section 7.3)
RCC_APB2ENR = const(0x40023844)
_TIM1_ADC123 = const(0x701)

CAN_TSR_HIGH = const(0x4000640A)  # upper half of CAN1's TSR
CAN_MAILBOX_FREE = const(0x1C00)
CAN_ESR = const(0x40006418)
CAN_BUS_OFF = const(4)

TS_CAL1 = const(0x1FFF7A2C)
TS_CAL2 = const(0x1FFF7A2E)

# Addresses used while running, added up here: they are 2^30 and more, so that each sum would be a new heap object
_BDTR = TIM1 + BDTR
_COMPARE_A = TIM1 + CCR1
_COMPARE_B = TIM1 + CCR2
_COMPARE_C = TIM1 + CCR3
JDR_A = ADC1 + ADC_JDR1
JDR_B = ADC2 + ADC_JDR1
JDR_C = ADC3 + ADC_JDR1
_SR_A = ADC1 + ADC_SR
_SR_B = ADC2 + ADC_SR
_SR_C = ADC3 + ADC_SR
_SEQUENCE = ADC1 + ADC_SQR3
_START = ADC1 + ADC_CR2 + 2
_RESULT = ADC1 + ADC_DR

_WAIT = const(2000)  # polls of a slow conversion: 23 us at 21 MHz and 480 cycles is far less
_CHANNEL_A = const(10)  # PC0, PC1, PC2: the shunt amplifiers (assumed wiring)


class Registers:
    """Set-up and access. ``wrong`` is the address of the first register that did not read back, 0 if none."""

    def __init__(self, stm):
        self._mem32 = stm.mem32
        self._mem16 = stm.mem16
        self.wrong = 0

    def setup_timer(self, period, dead_ticks):
        """Set timer 1, already counting up and down to ``period``, to three complementary pairs, outputs off.

        Dead time in timer ticks, 1 .. 127. Preload everywhere, so that compares change together.
        """
        self._set(TIM1 + BDTR, _OSSR_OSSI | dead_ticks)  # first: outputs off, whatever they were
        self._set(TIM1 + CCMR1, _PRELOAD_PWM1_BOTH)
        self._set(TIM1 + CCMR2, _PRELOAD_PWM1_TOP)
        self._set(TIM1 + RCR, _TWICE_A_PERIOD)
        for channel in (CCR1, CCR2, CCR3):
            self._set(TIM1 + channel, period // 2)
        self._set(TIM1 + CCR4, period - 1)
        self._set(TIM1 + CR2, 0)  # idle states low
        self._set(TIM1 + CCER, _OUTPUTS)
        self._mem32[TIM1 + EGR] = 1  # take the preloaded values over

    def setup_adc(self):
        """Let the three ADCs sample the three shunts together at the top of the PWM; regular channels by software."""
        self._mem32[RCC_APB2ENR] = self._mem32[RCC_APB2ENR] | _TIM1_ADC123
        self._set(ADC_COMMON, _PCLK2_BY_4_AND_SENSOR)
        for number, base in enumerate((ADC1, ADC2, ADC3)):
            self._set(base + ADC_CR2, 0)
            self._set(base + ADC_CR1, 0)
            self._set(base + ADC_SMPR1, _SMPR_15_CYCLES_10_TO_12 & 0x07FFFFFF)
            self._set(base + ADC_SMPR2, 0x3FFFFFFF)
            self._set(base + ADC_SQR1, 0)
            self._set(base + ADC_JSQR, (_CHANNEL_A + number) << 15)
            self._set(base + ADC_CR2, _INJECTED_BY_TIM1_CC4)

    def bridge_on(self):
        """Let the outputs follow the compares."""
        self._mem16[_BDTR] = self._mem16[_BDTR] | MOE

    def bridge_off(self):
        """Switch all six gates off; nothing can go wrong here but the bus itself."""
        self._mem16[_BDTR] = self._mem16[_BDTR] & ~MOE

    def compare(self, a, b, c):
        """Set the three compares; they act from the next update event on."""
        mem = self._mem16
        mem[_COMPARE_A] = a
        mem[_COMPARE_B] = b
        mem[_COMPARE_C] = c

    def sample(self, address):
        """Return the last sample of a shunt, 0 .. 4095: JDR_A, JDR_B or JDR_C."""
        return self._mem16[address]

    def sampled(self):
        """Return True if all three shunts were sampled since the last call."""
        mem = self._mem16
        fresh = mem[_SR_A] & mem[_SR_B] & mem[_SR_C] & JEOC
        if fresh:
            mem[_SR_A] = _ALL_BUT_JEOC  # bits written as 1 stay: a slow conversion under way keeps its end
            mem[_SR_B] = _ALL_BUT_JEOC
            mem[_SR_C] = _ALL_BUT_JEOC
        return fresh != 0

    def convert(self, channel):
        """Convert one slow channel on ADC1, 0 .. 4095; OSError if it does not end. Interrupted by the shunts' samples.

        Waits for CR2's upper half only, because a value with bit 30 would be a heap object.
        """
        mem = self._mem16
        mem[_SEQUENCE] = channel
        mem[_START] = mem[_START] | _SWSTART_HIGH
        for _ in range(_WAIT):
            if mem[_SR_A] & EOC:
                return mem[_RESULT]
        raise OSError(110)

    def can_free(self):
        """Return True if one of the three transmit mailboxes is free."""
        return self._mem16[CAN_TSR_HIGH] & CAN_MAILBOX_FREE != 0

    def can_bus_off(self):
        """Return True while the CAN controller is bus-off."""
        return self._mem16[CAN_ESR] & CAN_BUS_OFF != 0

    def factory(self, address):
        """Return a half word of the factory's calibration."""
        return self._mem16[address]

    def _set(self, address, value):
        """Write a register and read it back; the first that differs is kept in ``wrong``."""
        self._mem32[address] = value
        if self._mem32[address] != value and self.wrong == 0:
            self.wrong = address
