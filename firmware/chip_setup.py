"""Sets up what a joint uses of its STM32F405, once, before the interrupt starts (RM0090; sections at chip.py).

``set_up_*`` return the place of the first register that did not read back, 0 if all did. Pins are assumed, because the
wiring is not published; firmware/boards/CARAMELO_JOINT/pins.csv names the same.
"""

from shared.runtime import const, hot, reg32

from .chip import (
    ADC1_32,
    ADC_COMMON_32,
    ADC_CR1_32,
    ADC_CR2_32,
    ADC_JSQR_32,
    ADC_SMPR1_32,
    ADC_SMPR2_32,
    ADC_SQR1_32,
    ADC_STEP_32,
    AFRL_32,
    CAN_BTR_32,
    CAN_FA1R_32,
    CAN_FFA1R_32,
    CAN_FILTERS_32,
    CAN_FM1R_32,
    CAN_FMR_32,
    CAN_FS1R_32,
    CAN_MCR_32,
    CAN_MSR_32,
    GPIO_STEP_32,
    GPIOA_32,
    GPIOA_SET_16,
    GPIOC_SET_16,
    IWDG_KR_32,
    IWDG_PR_32,
    IWDG_RLR_32,
    IWDG_SR_32,
    MODER_32,
    OSPEEDR_32,
    PUPDR_32,
    RCC_AHB1ENR_32,
    RCC_APB1ENR_32,
    RCC_APB2ENR_32,
    SPI1_32,
    SPI3_32,
    SPI_CR1_32,
    SPI_CR2_32,
    TIM1_ARR_32,
    TIM1_BDTR_32,
    TIM1_CCER_32,
    TIM1_CCMR1_32,
    TIM1_CCMR2_32,
    TIM1_CCR1_32,
    TIM1_CCR2_32,
    TIM1_CCR3_32,
    TIM1_CNT_32,
    TIM1_CR1_32,
    TIM1_CR2_32,
    TIM1_EGR_32,
    TIM1_PSC_32,
    TIM1_RCR_32,
    TIM1_SMCR_32,
    TIM1_SR_32,
    TIM5_ARR_32,
    TIM5_CR1_32,
    TIM5_EGR_32,
    TIM5_PSC_32,
    change,
    peek,
    poke,
)

PERIOD = const(4200)  # compare counts: 168 MHz / (2 x 20 kHz)
DEAD_TICKS = const(17)  # 100 ns
THERMISTOR_CHANNEL = const(4)
MCU_CHANNEL = const(16)
WATCHDOG_MS = const(200)

_GPIO_A_TO_D = const(0x0F)  # RCC_AHB1ENR
_TIM5_SPI3_CAN1 = const(0x02008008)  # RCC_APB1ENR
_TIM1_ADC123_SPI1 = const(0x1701)  # RCC_APB2ENR

_ANALOG = const(3)
_ALTERNATE = const(2)
_OUTPUT = const(1)
_PULL_UP = const(1)
_FAST = const(2)
# (port, pin, mode, alternate function, pull): data sheet DS8626 table 9
_PINS = (
    (2, 0, _ANALOG, 0, 0), (2, 1, _ANALOG, 0, 0), (2, 2, _ANALOG, 0, 0),  # shunts a, b, c
    (2, 3, _ANALOG, 0, 0), (0, 4, _ANALOG, 0, 0),  # bus, thermistor
    (2, 4, _OUTPUT, 0, 0),  # gate driver: enable, low at first
    (1, 12, _ALTERNATE, 1, _PULL_UP),  # gate driver: nFAULT, the timer's break input
    (2, 6, _OUTPUT, 0, 0), (0, 15, _OUTPUT, 0, 0), (3, 2, _OUTPUT, 0, 0),  # selects: rotor, gate driver, joint
    (0, 5, _ALTERNATE, 5, 0), (0, 6, _ALTERNATE, 5, _PULL_UP), (0, 7, _ALTERNATE, 5, 0),  # SPI 1
    (2, 10, _ALTERNATE, 6, 0), (2, 11, _ALTERNATE, 6, _PULL_UP), (2, 12, _ALTERNATE, 6, 0),  # SPI 3
    (1, 8, _ALTERNATE, 9, _PULL_UP), (1, 9, _ALTERNATE, 9, 0),  # CAN 1
    (0, 8, _ALTERNATE, 1, 0), (0, 9, _ALTERNATE, 1, 0), (0, 10, _ALTERNATE, 1, 0),  # gates, high sides
    (1, 13, _ALTERNATE, 1, 0), (1, 14, _ALTERNATE, 1, 0), (1, 15, _ALTERNATE, 1, 0),  # low sides
)  # fmt: skip

_OFF_BREAK = const(0x1C00)  # BDTR: BKE, active low (BKP 0); OSSR, OSSI: without MOE the pins are driven low
_CENTRE_PRELOAD = const(0xA0)  # CR1: ARPE, CMS 01
_ENABLE = const(1)  # CR1: CEN
_TRGO_UPDATE = const(0x20)  # CR2: MMS 010; idle states low
_PWM1_BOTH = const(0x6868)  # CCMR: OCxM 110, OCxPE
_PWM1_LOW = const(0x0068)
_OUTPUTS = const(0x555)  # CCER: CC1 .. CC3 and their complements, all active high
_EACH = const(0)  # RCR: an update at each half period
_FOURTH = const(3)  # at each fourth: 10 kHz of 20
_DOWN = const(0x10)  # CR1: DIR, the counter counts down
_UPDATED = const(1)  # SR: UIF
_PERIOD_POLLS = const(5000)  # reads of 4 cycles and more: two updates are 0.2 ms apart at the most
_UPDATE = const(1)  # EGR: UG
_US = const(83)  # PSC of timer 5: 84 MHz / 84; it counts to 2^30

_PCLK2_BY_4_AND_SENSOR = const(0x00810000)  # 21 MHz; TSVREFE: the temperature sensor is on
_SMPR1 = const(0x07FFFE49)  # channels 10 .. 12 15 cycles (0.7 us), 13 .. 18 480 cycles (23 us)
_SMPR2 = const(0x3FFFFFFF)  # channels 0 .. 9 480 cycles
_INJECTED_BY_TRGO = const(0x00110001)  # JEXTEN rising edge, JEXTSEL 0001 (timer 1's TRGO), ADON
_SHUNT_A = const(10)

_SPI_MODE_1 = const(0x0B45)  # CR1: DFF 16 bits, SSM, SSI, SPE, master, CPHA; BR is added
_SPI1_BY_16 = const(0x18)  # 84 MHz / 16 = 5.25 MHz; the encoders bear 10
_SPI3_BY_8 = const(0x10)  # 42 MHz / 8

_CAN_INIT = const(1)  # MCR: INRQ; MSR: INAK
_CAN_RUN = const(0x40)  # MCR: ABOM, back from bus-off by itself; awake, by identifier, with repetition
_CAN_1M = const(0x00290002)  # BTR: SJW 1, BS2 3, BS1 10, BRP 3: 42 MHz / 3 / 14
_HANDSHAKE = const(100000)  # polls; leaving needs 11 recessive bits, 11 us
_FILTER_INIT = const(1)
_BANKS = ((0, 1), (2, 3), (4, 7), (5, 6))  # e-stop, SYNC; requests; set-points, update; own heartbeat and reply
_FIFO_OF_BANKS = const(0x0A)  # set-points and SYNC share FIFO 0, because their order counts
_EXACT = const(0x18)  # of a filter's mask: RTR and IDE count, data frames with 11 bits only

_IWDG_UNLOCK = const(0x5555)
_IWDG_START = const(0xCCCC)
_IWDG_FEED = const(0xAAAA)
_IWDG_BY_256 = const(6)
_IWDG_MOST = const(0xFFF)
_IWDG_BY_32 = const(3)  # 32 kHz (17 .. 47, DS8626 table 37) / 32: 1 kHz


def set_up_pins(chip):
    """Give the peripherals their clocks, then every pin but the bridge's its part. Selects are high, enable is low."""
    change(chip, RCC_AHB1ENR_32, _GPIO_A_TO_D, _GPIO_A_TO_D)
    change(chip, RCC_APB1ENR_32, _TIM5_SPI3_CAN1, _TIM5_SPI3_CAN1)
    change(chip, RCC_APB2ENR_32, _TIM1_ADC123_SPI1, _TIM1_ADC123_SPI1)
    peek(chip, RCC_APB2ENR_32)  # a clock needs two cycles (errata ES0182 section 2.1.13)
    for port, bits in ((0, 0x8000), (2, 0x40), (3, 4)):
        _set_pins(chip, port, bits)
    for row in _PINS[:-6]:
        _set_pin(chip, row)


def set_up_bridge_pins(chip):
    """Hand the six gates to the timer; it drives them low until the bridge is switched on."""
    for row in _PINS[-6:]:
        _set_pin(chip, row)


def _set_pins(chip, port, bits):
    """Set outputs of a port high."""
    place = (GPIOA_SET_16 >> 1) + port * GPIO_STEP_32
    poke(chip, place, bits)


def _set_pin(chip, row):
    port, pin, mode, function, pull = row
    base = GPIOA_32 + port * GPIO_STEP_32
    change(chip, base + AFRL_32 + (pin >> 3), 15 << 4 * (pin & 7), function << 4 * (pin & 7))
    change(chip, base + OSPEEDR_32, 3 << 2 * pin, _FAST << 2 * pin)
    change(chip, base + PUPDR_32, 3 << 2 * pin, pull << 2 * pin)
    change(chip, base + MODER_32, 3 << 2 * pin, mode << 2 * pin)


def enable_driver(chip, on):
    """Wake the gate driver, or let it sleep."""
    poke(chip, GPIOC_SET_16 >> 1, 0x10 if on else 0x100000)


def _write(chip, rows):
    """Write (place, value) rows and return the place of the first that reads back differently, 0 if none."""
    wrong = 0
    for place, value in rows:
        poke(chip, place, value)
        if peek(chip, place) != value and wrong == 0:
            wrong = place
    return wrong


def set_up_timers(chip):
    """Timer 1: three complementary pairs round the middle, outputs off. Timer 5: microseconds."""
    change(chip, TIM1_CR1_32, _ENABLE, 0)  # MicroPython left it running; its mode may change once it stands
    poke(chip, TIM1_CR1_32, 0)
    rows = (
        (TIM1_BDTR_32, _OFF_BREAK | DEAD_TICKS),  # first: outputs off, whatever they were
        (TIM1_CCER_32, 0), (TIM1_SMCR_32, 0),
        (TIM1_CCMR1_32, _PWM1_BOTH), (TIM1_CCMR2_32, _PWM1_LOW),
        (TIM1_PSC_32, 0), (TIM1_ARR_32, PERIOD), (TIM1_RCR_32, _EACH),
        (TIM1_CCR1_32, PERIOD // 2), (TIM1_CCR2_32, PERIOD // 2), (TIM1_CCR3_32, PERIOD // 2),
        (TIM1_CR2_32, _TRGO_UPDATE), (TIM1_CCER_32, _OUTPUTS), (TIM1_CR1_32, _CENTRE_PRELOAD),
        (TIM5_PSC_32, _US), (TIM5_ARR_32, 0x3FFFFFFF),
    )  # fmt: skip
    wrong = _write(chip, rows)
    poke(chip, TIM1_EGR_32, _UPDATE)  # take the preloaded values over
    poke(chip, TIM5_EGR_32, _UPDATE)
    poke(chip, TIM1_SR_32, 0)
    poke(chip, TIM5_CR1_32, _ENABLE)
    poke(chip, TIM1_CR1_32, _CENTRE_PRELOAD | _ENABLE)
    if align_updates(chip) == 0 and wrong == 0:
        return TIM1_RCR_32
    return wrong


@hot
def align_updates(chip) -> int:
    """Let each fourth update event come, at the top; return 1 if it does, 0 if not.

    Where the events of an odd RCR fall is told differently in RM0090 section 17.3.3 and in later manuals. So it is
    written while the counter, with an update at each end, goes up: the next update, at the top, takes it over.
    """
    c = reg32(chip)
    for _ in range(_PERIOD_POLLS):
        if c[TIM1_CR1_32] & _DOWN == 0 and c[TIM1_CNT_32] < PERIOD // 2:
            break
    c[TIM1_RCR_32] = _FOURTH
    for _ in range(2):
        c[TIM1_SR_32] = 0
        for _ in range(_PERIOD_POLLS):
            if c[TIM1_SR_32] & _UPDATED:
                break
    return (c[TIM1_CR1_32] & _DOWN) >> 4


def set_up_adcs(chip):
    """Let the three ADCs sample the shunts together at timer 1's update; regular channels by software on ADC 1."""
    rows = [(ADC_COMMON_32, _PCLK2_BY_4_AND_SENSOR)]
    for number in range(3):
        base = ADC1_32 + number * ADC_STEP_32
        rows += [
            (base + ADC_CR2_32, 0), (base + ADC_CR1_32, 0), (base + ADC_SMPR1_32, _SMPR1),
            (base + ADC_SMPR2_32, _SMPR2), (base + ADC_SQR1_32, 0), (base + ADC_JSQR_32, (_SHUNT_A + number) << 15),
            (base + ADC_CR2_32, _INJECTED_BY_TRGO),
        ]  # fmt: skip
    return _write(chip, rows)


def set_up_spis(chip):
    """SPI 1 for the rotor's encoder, SPI 3 for gate driver and joint encoder: 16 bits, mode 1, 5.25 MHz."""
    rows = ((SPI1_32 + SPI_CR2_32, 0), (SPI1_32 + SPI_CR1_32, _SPI_MODE_1 | _SPI1_BY_16),
            (SPI3_32 + SPI_CR2_32, 0), (SPI3_32 + SPI_CR1_32, _SPI_MODE_1 | _SPI3_BY_8))  # fmt: skip
    return _write(chip, rows)


def set_up_can(chip):
    """CAN 1 at 1 Mbit, sample point 79 %; returns 0 also while nobody else is on the bus."""
    poke(chip, CAN_MCR_32, _CAN_RUN | _CAN_INIT)
    _await(chip, CAN_MSR_32, _CAN_INIT, _CAN_INIT)
    wrong = _write(chip, ((CAN_BTR_32, _CAN_1M),))
    poke(chip, CAN_MCR_32, _CAN_RUN)
    _await(chip, CAN_MSR_32, _CAN_INIT, 0)  # without a bus this ends unheard: the chip goes on by itself
    return wrong


def set_filters(chip, pairs, count):
    """Let only frames pass that match one of ``count`` (identifier, mask) pairs, 2, 4 or 8; other banks are off."""
    change(chip, CAN_FMR_32, _FILTER_INIT, _FILTER_INIT)
    poke(chip, CAN_FA1R_32, 0)
    poke(chip, CAN_FM1R_32, 0)  # masks
    poke(chip, CAN_FS1R_32, 0)  # of 16 bits
    poke(chip, CAN_FFA1R_32, _FIFO_OF_BANKS)
    for bank in range(count // 2):
        for half in range(2):
            at = 2 * _BANKS[bank][half]
            word = pairs[at] << 5 | (pairs[at + 1] << 5 | _EXACT) << 16
            poke(chip, CAN_FILTERS_32 + 2 * bank + half, word)
    poke(chip, CAN_FA1R_32, (1 << count // 2) - 1)
    change(chip, CAN_FMR_32, _FILTER_INIT, 0)


def start_watchdog(chip):
    """Start the watchdog: 201 ms, 136 .. 378 by the spread of its clock. Nothing stops it but a reset."""
    poke(chip, IWDG_KR_32, _IWDG_START)
    poke(chip, IWDG_KR_32, _IWDG_UNLOCK)
    poke(chip, IWDG_PR_32, _IWDG_BY_32)
    poke(chip, IWDG_RLR_32, WATCHDOG_MS)
    _await(chip, IWDG_SR_32, 3, 0)


def slow_watchdog(chip):
    """Give the watchdog its longest time, 32 s (22 .. 62): an erase stops the processor for up to 2 s."""
    poke(chip, IWDG_KR_32, _IWDG_UNLOCK)
    poke(chip, IWDG_PR_32, _IWDG_BY_256)
    poke(chip, IWDG_RLR_32, _IWDG_MOST)
    _await(chip, IWDG_SR_32, 3, 0)
    poke(chip, IWDG_KR_32, _IWDG_FEED)


def _await(chip, place, mask, bits):
    """Wait until the bits of a register are as wanted, but not for ever."""
    polls = 0
    while peek(chip, place) & mask != bits and polls < _HANDSHAKE:
        polls += 1
