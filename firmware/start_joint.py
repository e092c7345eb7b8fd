"""Starts a joint's board: its hardware, its application, and the main loop, which never ends by itself."""

import gc

import micropython

from .board_stm32f405 import Stm32F405Board
from .joint import Joint
from .node_id import take_node

WATCHDOG = True  # the board starts it with the interrupt
PARAMETER_FILE = "/flash/joint.bin"
_BUS_FULL_SCALE_MV = 42900  # 13:1 divider at 3.3 V


def motor_supply_mV():
    """Return the motors' supply in mV."""
    return Stm32F405Board().read_bus() * _BUS_FULL_SCALE_MV // 4096


def start():
    """Run the joint until something stops the program; the bridge is off afterwards whatever it was."""
    micropython.alloc_emergency_exception_buf(100)
    board = Stm32F405Board()
    try:
        joint = Joint(board, PARAMETER_FILE)
        take_node(joint)
        gc.collect()
        joint.start()
        while True:
            joint.poll()
    finally:
        board.pwm_off()
