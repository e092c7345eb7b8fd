"""Starts a joint's board: its hardware, its application, and the main loop, which never ends by itself."""

import gc

import machine
import micropython
import stm

from shared.runtime import const

from .board_stm32f405 import Stm32F405Board
from .joint import Joint
from .joint_store import BROKEN

WATCHDOG = True  # the board starts it with the interrupt
NODE = "node"  # key of the id that ``caramelo flash --id`` leaves, until the joint has taken it over
_BUS_FULL_SCALE_MV = 42900  # 13:1 divider at 3.3 V
_MAIN_OUTPUT = const(1 << 15)  # MOE in TIM1's BDTR


def motor_supply_mV():
    """Return the motors' supply in mV."""
    return Stm32F405Board().read_bus() * _BUS_FULL_SCALE_MV // 4096


def armed():
    """Return True if the bridge may switch."""
    return bool(machine.mem32[stm.TIM1 + stm.TIM_BDTR] & _MAIN_OUTPUT)


def take_node(joint, journal):
    """Make an id that was left in the journal that of the joint, and save it; return 1 if that was done.

    Parameters that can't be read are left alone, as evidence: then the id stays where it is.
    """
    data = journal.get(NODE)
    if not data or joint.loaded == BROKEN or not 1 <= data[0] <= 12:
        return 0
    joint.set_node(data[0])
    return 1 if joint.parameters.save() and journal.put(NODE, b"") else 0


def start(journal, update):
    """Run the joint until something stops the program; the bridge is off afterwards whatever it was."""
    micropython.alloc_emergency_exception_buf(100)
    board = Stm32F405Board()
    try:
        joint = Joint(board, journal, update)
        take_node(joint, journal)
        gc.collect()
        joint.start()
        while True:
            joint.poll()
    finally:
        board.pwm_off()
