// The joint's board. Its pins are assumed, because the wiring is not published; pins.csv names them by function.
#define MICROPY_HW_BOARD_NAME "CARAMELO_JOINT"
#include "common.h"

// SPI 1: rotor encoder, which only the interrupt reads. SPI 3: gate driver and joint encoder.
#define MICROPY_HW_SPI1_SCK (pin_A5)
#define MICROPY_HW_SPI1_MISO (pin_A6)
#define MICROPY_HW_SPI1_MOSI (pin_A7)
#define MICROPY_HW_SPI3_SCK (pin_C10)
#define MICROPY_HW_SPI3_MISO (pin_C11)
#define MICROPY_HW_SPI3_MOSI (pin_C12)
