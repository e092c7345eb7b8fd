"""Which signals reach which pins of the STM32F405: alternate functions (DS8626) and analog inputs (table 7)."""

# alternate function number -> signal -> pins. Only the blocks that are modelled, and the USB device.
_FUNCTIONS = {
    1: {
        "TIM1_CH1": "PA8 PE9",
        "TIM1_CH1N": "PA7 PB13 PE8",
        "TIM1_CH2": "PA9 PE11",
        "TIM1_CH2N": "PB0 PB14 PE10",
        "TIM1_CH3": "PA10 PE13",
        "TIM1_CH3N": "PB1 PB15 PE12",
        "TIM1_CH4": "PA11 PE14",
        "TIM1_BKIN": "PA6 PB12 PE15",
        "TIM1_ETR": "PA12 PE7",
    },
    5: {
        "SPI1_NSS": "PA4 PA15",
        "SPI1_SCK": "PA5 PB3",
        "SPI1_MISO": "PA6 PB4",
        "SPI1_MOSI": "PA7 PB5",
        "SPI2_NSS": "PB9 PB12 PI0",
        "SPI2_SCK": "PB10 PB13 PI1",
        "SPI2_MISO": "PB14 PC2 PI2",
        "SPI2_MOSI": "PB15 PC3 PI3",
    },
    6: {
        "SPI3_NSS": "PA4 PA15",
        "SPI3_SCK": "PB3 PC10",
        "SPI3_MISO": "PB4 PC11",
        "SPI3_MOSI": "PB5 PC12",
    },
    9: {
        "CAN1_RX": "PA11 PB8 PD0 PI9",
        "CAN1_TX": "PA12 PB9 PD1 PH13",
        "CAN2_RX": "PB5 PB12",
        "CAN2_TX": "PB6 PB13",
    },
    10: {"OTG_FS_SOF": "PA8", "OTG_FS_ID": "PA10", "OTG_FS_DM": "PA11", "OTG_FS_DP": "PA12"},
}
_ADC12 = [
    "PA0", "PA1", "PA2", "PA3", "PA4", "PA5", "PA6", "PA7",
    "PB0", "PB1", "PC0", "PC1", "PC2", "PC3", "PC4", "PC5",
]  # fmt: skip
_ADC3 = [
    "PA0", "PA1", "PA2", "PA3", "PF6", "PF7", "PF8", "PF9",
    "PF10", "PF3", "PC0", "PC1", "PC2", "PC3", "PF4", "PF5",
]  # fmt: skip

SIGNAL_ON = {
    (pin, number): signal
    for number, signals in _FUNCTIONS.items()
    for signal, pins in signals.items()
    for pin in pins.split()
}
SIGNALS = frozenset(SIGNAL_ON.values())
ANALOG_PIN = {
    (adc, channel): pin
    for adc, pins in (("ADC1", _ADC12), ("ADC2", _ADC12), ("ADC3", _ADC3))
    for channel, pin in enumerate(pins)
}
# Section 13.3.3: inside the chip, on ADC1 only. On the F42x the temperature sensor is on channel 18 instead.
INTERNAL = {("ADC1", 16): "TEMPERATURE", ("ADC1", 17): "VREFINT", ("ADC1", 18): "VBAT"}
