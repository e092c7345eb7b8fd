// What both boards' mpconfigboard.h have in common: an STM32F405 with a 12 MHz crystal, USB without VBUS and ID pins.
#define MICROPY_HW_MCU_NAME "STM32F405RG"

// Where the vectors lie only the linker knows, so that both slots' images are linked from the same objects. ST's
// start-up code points at the loader's; this comes right after it.
#undef MICROPY_HW_VTOR
#define MICROPY_BOARD_STARTUP caramelo_startup
extern char caramelo_vectors[];
void powerctrl_check_enter_bootloader(void);
static inline void caramelo_startup(void) {
    *(volatile unsigned int *)0xE000ED08 = (unsigned int)caramelo_vectors;
    powerctrl_check_enter_bootloader();
}

// machine.bootloader() enters ST's loader in ROM.
#define MICROPY_BOARD_ENTER_BOOTLOADER(nargs, args)

// 12 MHz / 12 * 336 / 2 = 168 MHz; / 7 = 48 MHz for USB
#define MICROPY_HW_CLK_PLLM (12)
#define MICROPY_HW_CLK_PLLN (336)
#define MICROPY_HW_CLK_PLLP (RCC_PLLP_DIV2)
#define MICROPY_HW_CLK_PLLQ (7)
#define MICROPY_HW_CLK_LAST_FREQ (1)

// USB: one serial port. PA9 and PA10 carry the motor, not VBUS and ID.
#define MICROPY_HW_ENABLE_USB (1)
#define MICROPY_HW_USB_FS (1)
#define MICROPY_HW_USB_MSC (0)
#define MICROPY_HW_USB_HID (0)
#define MICROPY_HW_USB_CDC_NUM (1)
#define MICROPY_HW_USB_MANUFACTURER_STRING "caramelo"
#define MICROPY_HW_USB_PRODUCT_FS_STRING MICROPY_HW_BOARD_NAME
#define MICROPY_HW_USB_CONFIGURATION_FS_STRING "serial"
#define MICROPY_HW_USB_INTERFACE_FS_STRING "prompt"

// CAN 1
#define MICROPY_HW_CAN1_NAME "JOINTS"
#define MICROPY_HW_CAN1_TX (pin_B9)
#define MICROPY_HW_CAN1_RX (pin_B8)

// No file system anywhere: the code is frozen, settings lie in a journal (firmware/settings.py).
#define MICROPY_HW_ENABLE_INTERNAL_FLASH_STORAGE (0)
#define MICROPY_HW_HAS_FLASH (0)
#define MICROPY_HW_FLASH_MOUNT_AT_BOOT (0)
#define MICROPY_HW_ENABLE_SDCARD (0)

// Hardware that the boards do not have or the applications do not use
#define MICROPY_HW_HAS_SWITCH (0)
#define MICROPY_HW_ENABLE_RTC (0)
#define MICROPY_HW_ENABLE_RNG (1) // the challenge that arming carries
#define MICROPY_HW_ENABLE_DAC (0)
#define MICROPY_HW_ENABLE_ADC (0)
#define MICROPY_HW_ENABLE_SERVO (0)

// Machine code runs only from flash, where it is frozen: nothing compiles it here.
#define MICROPY_EMIT_INLINE_THUMB (0)

// The interpreter without what neither application nor the service prompt uses
#define MICROPY_PY_NETWORK (0)
#define MICROPY_PY_ONEWIRE (0)
#define MICROPY_PY_MACHINE_BITSTREAM (0)
#define MICROPY_PY_ASYNCIO (0)
#define MICROPY_PY_FRAMEBUF (0)
#define MICROPY_PY_CMATH (0)
#define MICROPY_PY_MATH (0)
#define MICROPY_PY_RE (0)
#define MICROPY_PY_HEAPQ (0)
#define MICROPY_PY_RANDOM (0)
#define MICROPY_PY_SELECT (0)
#define MICROPY_PY_PLATFORM (0)
#define MICROPY_PY_BUILTINS_HELP (0)
#define MICROPY_PY_COLLECTIONS_DEQUE (0)
#define MICROPY_PY_BUILTINS_COMPLEX (0)
