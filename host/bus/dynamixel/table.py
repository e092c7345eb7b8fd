"""The part in use of the MX-28's control table with (2.0) firmware: Robotis e-manual, MX-28(2.0), control table.

The same table holds with protocol 2.0 and 1.0, which that firmware speaks too (register 13).
"""

from math import tau
from typing import NamedTuple


class Register(NamedTuple):
    """One value: its address, its size in bytes, its value in a new servo, and when it may be written."""

    address: int
    size: int
    initial: int
    low: int
    high: int
    writable: bool = True
    eeprom: bool = False
    signed: bool = False


def _eeprom(address: int, size: int, initial: int, low: int, high: int) -> Register:
    return Register(address, size, initial, low, high, eeprom=True)


def _shown(address: int, size: int, initial: int = 0, signed: bool = False, eeprom: bool = False) -> Register:
    return Register(address, size, initial, 0, 0, writable=False, signed=signed, eeprom=eeprom)


FULL_PWM = 885  # 100 % duty
MODEL_NUMBER = _shown(0, 2, 30, eeprom=True)
FIRMWARE = _shown(6, 1, 45, eeprom=True)
ID = _eeprom(7, 1, 1, 0, 252)
BAUD = _eeprom(8, 1, 1, 0, 7)
RETURN_DELAY = _eeprom(9, 1, 250, 0, 254)
DRIVE_MODE = _eeprom(10, 1, 0, 0, 5)
OPERATING_MODE = _eeprom(11, 1, 3, 0, 16)
SHADOW_ID = _eeprom(12, 1, 255, 0, 255)
PROTOCOL = _eeprom(13, 1, 2, 1, 2)
HOMING_OFFSET = Register(20, 4, 0, -1044479, 1044479, eeprom=True, signed=True)
TEMPERATURE_LIMIT = _eeprom(31, 1, 80, 0, 100)
MAX_VOLTAGE = _eeprom(32, 2, 160, 95, 160)
MIN_VOLTAGE = _eeprom(34, 2, 95, 95, 160)
PWM_LIMIT = _eeprom(36, 2, FULL_PWM, 0, FULL_PWM)
MAX_POSITION = _eeprom(48, 4, 4095, 0, 4095)
MIN_POSITION = _eeprom(52, 4, 0, 0, 4095)
SHUTDOWN = _eeprom(63, 1, 52, 0, 255)
TORQUE_ENABLE = Register(64, 1, 0, 0, 1)
LED = Register(65, 1, 0, 0, 1)
STATUS_LEVEL = Register(68, 1, 2, 0, 2)
HARDWARE_ERROR = _shown(70, 1)
D_GAIN = Register(80, 2, 0, 0, 16383)
I_GAIN = Register(82, 2, 0, 0, 16383)
P_GAIN = Register(84, 2, 850, 0, 16383)
WATCHDOG = Register(98, 1, 0, 0, 127, signed=True)
GOAL_PWM = Register(100, 2, FULL_PWM, -FULL_PWM, FULL_PWM, signed=True)
PROFILE_ACCELERATION = Register(108, 4, 0, 0, 32767)
PROFILE_VELOCITY = Register(112, 4, 0, 0, 32767)
GOAL_POSITION = Register(116, 4, 0, 0, 4095, signed=True)
PRESENT_LOAD = _shown(126, 2, signed=True)
PRESENT_VELOCITY = _shown(128, 4, signed=True)
PRESENT_POSITION = _shown(132, 4, signed=True)
PRESENT_VOLTAGE = _shown(144, 2)
PRESENT_TEMPERATURE = _shown(146, 1)

REGISTERS = {name: value for name, value in globals().items() if isinstance(value, Register)}
TABLE_SIZE = 256

MODEL_MX28_V2 = 30
MODEL_MX28_V1 = 29
POSITION_CONTROL = 3
WATCHDOG_FIRMWARE = 38  # the bus watchdog exists from this firmware on
WATCHDOG_TICK_S = 0.020
WATCHDOG_TRIPPED = -1

COUNTS_PER_TURN = 4096
VELOCITY_RAD_S = 0.229 * tau / 60
LOAD_SHARE = 0.001
VOLTS = 0.1

BAUDS = (9600, 57600, 115200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)  # by the value of BAUD

# Blocks that are read at once: each cycle, and for a few servos per cycle.
FAST_BLOCK = (PRESENT_LOAD.address, 10)  # load, velocity, position
SLOW_BLOCK = (PRESENT_VOLTAGE.address, 3)  # voltage, temperature
# Torque, hardware error, watchdog and torque limit.
STATE_BLOCK = (TORQUE_ENABLE.address, GOAL_PWM.address + GOAL_PWM.size - TORQUE_ENABLE.address)

# Hardware error bits and their texts.
HARDWARE_ERRORS = {
    0x01: "supply voltage out of range",
    0x04: "too hot",
    0x08: "encoder error",
    0x10: "electrical shock",
    0x20: "overload",
}
OVERHEATED, OVERLOADED = 0x04, 0x20

# Error field of a status packet, protocol 2.0.
ALERT = 0x80
RESULT_FAIL, INSTRUCTION_ERROR, CRC_ERROR, RANGE_ERROR, LENGTH_ERROR, LIMIT_ERROR, ACCESS_ERROR = range(1, 8)
STATUS_ERRORS = {
    RESULT_FAIL: "could not do it",
    INSTRUCTION_ERROR: "does not know the instruction",
    CRC_ERROR: "got a damaged packet",
    RANGE_ERROR: "value out of range, or its bus watchdog has tripped",
    LENGTH_ERROR: "wrong length",
    LIMIT_ERROR: "value beyond the servo's own limits",
    ACCESS_ERROR: "register can't be written (settings only with torque off)",
}


def hardware_error_text(bits: int) -> str:
    """Return what a hardware error status means, "" for none."""
    return ", ".join(text for bit, text in HARDWARE_ERRORS.items() if bits & bit) or (f"error {bits}" if bits else "")


def pack(register: Register, value: int) -> list[int]:
    """Return a value's bytes, lowest first."""
    return list((value & ((1 << 8 * register.size) - 1)).to_bytes(register.size, "little"))


def unpack(register: Register, data: bytes | bytearray | list[int], offset: int = 0) -> int:
    """Return a register's value from bytes that begin at address ``offset``."""
    at = register.address - offset
    return int.from_bytes(bytes(data[at : at + register.size]), "little", signed=register.signed)
