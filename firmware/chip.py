"""Registers of the STM32F405 (RM0090), as places from the start of its peripherals.

A function that works on the chip gets ``chip``: there the number PERIPHERALS, elsewhere anything that is indexed like
one long array of registers (host/sim/chip). Places end in _32 for reg32, in _16 for reg16: places of half words.
Timers and SPI allow half words, GPIO allows them, ADC and bxCAN are written by words only (each chapter's register
map says so).
"""

from shared.runtime import const, hot, reg16, reg32

PERIPHERALS = const(0x40000000)
SYSTEM = const(0x1FFF7A00)  # unique id and factory values (section 39.1, DS8626 section 5.3.22), as half words
TS_CAL1_16 = const(0x2C >> 1)
TS_CAL2_16 = const(0x2E >> 1)
CORE = const(0xE000E000)  # the processor's own: PM0214 section 4.3
NVIC_PRIORITY_32 = const(0x400 >> 2)

# RCC (section 7.3)
RCC_AHB1ENR_32 = const(0x23830 >> 2)
RCC_APB1ENR_32 = const(0x23840 >> 2)
RCC_APB2ENR_32 = const(0x23844 >> 2)

# GPIO (section 8.4): ports A .. D lie 0x400 bytes apart
GPIOA_32 = const(0x20000 >> 2)
GPIO_STEP_32 = const(0x400 >> 2)
MODER_32 = const(0)
OSPEEDR_32 = const(2)
PUPDR_32 = const(3)
AFRL_32 = const(8)
GPIOA_SET_16 = const(0x20018 >> 1)  # BSRR: its other half, the next place, clears
GPIOB_IDR_32 = const(0x20410 >> 2)
GPIOC_SET_16 = const(0x20818 >> 1)
GPIOC_CLEAR_16 = const(0x2081A >> 1)
GPIOD_SET_16 = const(0x20C18 >> 1)

# Timer 1, the bridge (section 17.4)
TIM1_CR1_32 = const(0x10000 >> 2)
TIM1_CR2_32 = const(0x10004 >> 2)
TIM1_SMCR_32 = const(0x10008 >> 2)
TIM1_SR_32 = const(0x10010 >> 2)
TIM1_EGR_32 = const(0x10014 >> 2)
TIM1_CCMR1_32 = const(0x10018 >> 2)
TIM1_CCMR2_32 = const(0x1001C >> 2)
TIM1_CCER_32 = const(0x10020 >> 2)
TIM1_CNT_32 = const(0x10024 >> 2)
TIM1_PSC_32 = const(0x10028 >> 2)
TIM1_ARR_32 = const(0x1002C >> 2)
TIM1_RCR_32 = const(0x10030 >> 2)
TIM1_CCR1_32 = const(0x10034 >> 2)
TIM1_CCR2_32 = const(0x10038 >> 2)
TIM1_CCR3_32 = const(0x1003C >> 2)
TIM1_BDTR_32 = const(0x10044 >> 2)
MOE = const(0x8000)  # main output enable

# Timer 5, the clock: 32 bits (section 18.4)
TIM5_CR1_32 = const(0xC00 >> 2)
TIM5_EGR_32 = const(0xC14 >> 2)
TIM5_CNT_32 = const(0xC24 >> 2)
TIM5_PSC_32 = const(0xC28 >> 2)
TIM5_ARR_32 = const(0xC2C >> 2)

# ADC (section 13.13): 1, 2 and 3 lie 0x100 bytes apart
ADC1_32 = const(0x12000 >> 2)
ADC_STEP_32 = const(0x100 >> 2)
ADC_CR1_32 = const(1)
ADC_CR2_32 = const(2)
ADC_SMPR1_32 = const(3)
ADC_SMPR2_32 = const(4)
ADC_SQR1_32 = const(11)
ADC_JSQR_32 = const(14)
ADC_COMMON_32 = const(0x12304 >> 2)
ADC1_SR_32 = const(0x12000 >> 2)
ADC2_SR_32 = const(0x12100 >> 2)
ADC3_SR_32 = const(0x12200 >> 2)
ADC1_CR2_32 = const(0x12008 >> 2)
ADC1_SQR3_32 = const(0x12034 >> 2)
ADC1_JDR1_32 = const(0x1203C >> 2)
ADC2_JDR1_32 = const(0x1213C >> 2)
ADC3_JDR1_32 = const(0x1223C >> 2)
ADC1_DR_32 = const(0x1204C >> 2)
EOC = const(2)
JEOC = const(4)

# SPI (section 28.5)
SPI1_32 = const(0x13000 >> 2)
SPI3_32 = const(0x3C00 >> 2)
SPI_CR1_32 = const(0)
SPI_CR2_32 = const(1)
SPI_SR_32 = const(2)
SPI_DR_32 = const(3)
RXNE = const(1)
BSY = const(0x80)

# CAN 1 (section 32.9)
CAN_MCR_32 = const(0x6400 >> 2)
CAN_MSR_32 = const(0x6404 >> 2)
CAN_TSR_32 = const(0x6408 >> 2)
CAN_RF0R_32 = const(0x640C >> 2)
CAN_ESR_32 = const(0x6418 >> 2)
CAN_BTR_32 = const(0x641C >> 2)
CAN_TX_32 = const(0x6580 >> 2)  # three mailboxes of TIR, TDTR, TDLR, TDHR
CAN_RX_32 = const(0x65B0 >> 2)  # two FIFOs of RIR, RDTR, RDLR, RDHR
CAN_FMR_32 = const(0x6600 >> 2)
CAN_FM1R_32 = const(0x6604 >> 2)
CAN_FS1R_32 = const(0x660C >> 2)
CAN_FFA1R_32 = const(0x6614 >> 2)
CAN_FA1R_32 = const(0x661C >> 2)
CAN_FILTERS_32 = const(0x6640 >> 2)  # banks of two words

# Flash interface (section 3.9)
FLASH_ACR_32 = const(0x23C00 >> 2)
FLASH_KEYR_32 = const(0x23C04 >> 2)
FLASH_SR_32 = const(0x23C0C >> 2)
FLASH_CR_32 = const(0x23C10 >> 2)

# Independent watchdog (section 21.4)
IWDG_KR_32 = const(0x3000 >> 2)
IWDG_PR_32 = const(0x3004 >> 2)
IWDG_RLR_32 = const(0x3008 >> 2)
IWDG_SR_32 = const(0x300C >> 2)


@hot
def peek(chip, place: int) -> int:
    """Return a register's 32 bits."""
    c = reg32(chip)
    return c[place]


@hot
def poke(chip, place: int, value: int) -> None:
    """Write a register's 32 bits."""
    c = reg32(chip)
    c[place] = value


@hot
def change(chip, place: int, mask: int, bits: int) -> None:
    """Write ``bits`` where ``mask`` has ones, leave the rest."""
    c = reg32(chip)
    c[place] = c[place] & ~mask | bits


@hot
def half(system, place: int) -> int:
    """Return a half word of the system memory, which holds what the factory wrote."""
    s = reg16(system)
    return s[place]
