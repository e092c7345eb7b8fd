# What both boards' mpconfigboard.mk have in common. SLOT says where the image is to run: a or b (firmware/flash_map.py).
MCU_SERIES = f4
CMSIS_MCU = STM32F405xx
AF_FILE = boards/stm32f405_af.csv

BOARDS = $(BOARD_DIR)/..
SLOT ?= a
LD_FILES = $(BOARDS)/slot_$(SLOT).ld $(BOARDS)/memory.ld
CFLAGS += -I$(BOARDS)
# Unused: the linker scripts say where the image lies.
TEXT0_ADDR = 0
# A change of the common settings changes the names that the interpreter knows.
QSTR_GLOBAL_DEPENDENCIES += $(BOARDS)/common.h

# `caramelo firmware image` names a manifest of its own; without one this is the bare interpreter.
FROZEN_MANIFEST ?=

# Nothing of these: the core computes in integers, and there is no file system and no network.
MICROPY_FLOAT_IMPL = float
MICROPY_VFS_FAT = 0
MICROPY_VFS_LFS1 = 0
MICROPY_VFS_LFS2 = 0
MICROPY_PY_NETWORK_WIZNET5K = 0
MICROPY_PY_LWIP = 0
MICROPY_PY_SSL = 0
MICROPY_PY_BTREE = 0
MICROPY_PY_OPENAMP = 0
