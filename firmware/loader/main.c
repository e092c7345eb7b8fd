// The chip's side of the loader: from reset to a slot's first instruction, or to ST's loader in ROM (USB, DFU).
// Runs at the reset's 16 MHz, leaves every peripheral as the reset left it. Register names: RM0090.
#include "loader.h"

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define FLASH_BASE 0x08000000u
#define SYSTEM_MEMORY 0x1FFF0000u
#define FLASH_KEYR REGISTER(0x40023C04)
#define FLASH_SR REGISTER(0x40023C0C)
#define FLASH_CR REGISTER(0x40023C10)
#define RCC_APB2ENR REGISTER(0x40023844)
#define SYSCFG_MEMRMP REGISTER(0x40013800)
#define SCB_VTOR REGISTER(0xE000ED08)

#define SR_BSY (1u << 16)
#define SR_ERRORS 0xF2u // of a former operation; they are cleared by writing ones
#define CR_PG (1u << 0)
#define CR_PSIZE_WORD (2u << 8) // needs 2.7 V at least
#define CR_LOCK (1u << 31)
#define SYSCFG_ENABLE (1u << 14)

void reset(void);

__attribute__((section(".vectors"), used)) static const uint32_t vectors[] = {
    0x20020000, // the stack ends the RAM: MicroPython keeps a note to itself at the end of the core-coupled memory
    (uint32_t)reset,
    (uint32_t)reset, // NMI and faults
    (uint32_t)reset,
};

static void program(uint32_t at, uint32_t word) {
    FLASH_KEYR = 0x45670123;
    FLASH_KEYR = 0xCDEF89AB;
    FLASH_SR = SR_ERRORS;
    FLASH_CR = CR_PG | CR_PSIZE_WORD;
    REGISTER(FLASH_BASE + at) = word;
    while (FLASH_SR & SR_BSY) {
    }
    FLASH_CR = CR_LOCK;
}

static __attribute__((noreturn)) void jump(const uint32_t *table) {
    __asm volatile("msr msp, %0\n"
                   "movs r0, #0\n" // what MicroPython takes as how it was started: normally
                   "bx %1\n"
                   :
                   : "r"(table[0]), "r"(table[1])
                   : "r0");
    __builtin_unreachable();
}

void reset(void) {
    int slot = choose_slot((const uint8_t *)FLASH_BASE, program);
    if (slot == NO_SLOT) {
        RCC_APB2ENR |= SYSCFG_ENABLE;
        SYSCFG_MEMRMP = 1; // system memory at address 0, as after a reset with BOOT0
        jump((const uint32_t *)SYSTEM_MEMORY);
    }
    uint32_t table = FLASH_BASE + slot_at(slot) + HEADER_BYTES;
    SCB_VTOR = table;
    jump((const uint32_t *)table);
}
