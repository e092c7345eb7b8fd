// The gait controller's board: an inertial sensor on I2C 1, the link on USB, CAN for later.
#define MICROPY_HW_BOARD_NAME "CARAMELO_GAIT"
#include "common.h"

#define MICROPY_HW_I2C1_SCL (pin_B6)
#define MICROPY_HW_I2C1_SDA (pin_B7)
#define MICROPY_HW_ENABLE_HW_I2C_TARGET (0) // it only asks
