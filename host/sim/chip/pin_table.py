"""Which signals reach which pins of the STM32F405: alternate functions (DS8626) and analog inputs (table 7).

Of ports A to D, and of the blocks that are modelled.
"""

# alternate function number -> signal -> pins.
_FUNCTIONS = {
    1: {
        "TIM1_CH1": "PA8", "TIM1_CH1N": "PA7 PB13",
        "TIM1_CH2": "PA9", "TIM1_CH2N": "PB0 PB14",
        "TIM1_CH3": "PA10", "TIM1_CH3N": "PB1 PB15",
        "TIM1_BKIN": "PA6 PB12",
    },
    5: {"SPI1_SCK": "PA5 PB3", "SPI1_MISO": "PA6 PB4", "SPI1_MOSI": "PA7 PB5"},
    6: {"SPI3_SCK": "PB3 PC10", "SPI3_MISO": "PB4 PC11", "SPI3_MOSI": "PB5 PC12"},
    9: {"CAN1_RX": "PA11 PB8 PD0", "CAN1_TX": "PA12 PB9 PD1"},
}  # fmt: skip
_ADC12 = (*(f"PA{n}" for n in range(8)), "PB0", "PB1", *(f"PC{n}" for n in range(6)))
_ADC3 = {0: "PA0", 1: "PA1", 2: "PA2", 3: "PA3", 10: "PC0", 11: "PC1", 12: "PC2", 13: "PC3"}

SIGNAL_ON = {
    (pin, number): signal
    for number, signals in _FUNCTIONS.items()
    for signal, pins in signals.items()
    for pin in pins.split()
}
SIGNALS = frozenset(SIGNAL_ON.values())
ANALOG_PIN = {
    **{(adc, channel): pin for adc in ("ADC1", "ADC2") for channel, pin in enumerate(_ADC12)},
    **{("ADC3", channel): pin for channel, pin in _ADC3.items()},
}
TEMPERATURE = ("ADC1", 16)  # section 13.3.3: inside the chip
