"""Register addresses as the e-manual's MX-28(2.0) page lists them, and values to bytes and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from host.bus.dynamixel import table as t

# Name, address, size, value when new, where the manual gives one.
MANUAL = """
MODEL_NUMBER 0 2 30
FIRMWARE 6 1 -
ID 7 1 1
BAUD 8 1 1
RETURN_DELAY 9 1 250
DRIVE_MODE 10 1 0
OPERATING_MODE 11 1 3
SHADOW_ID 12 1 255
PROTOCOL 13 1 2
HOMING_OFFSET 20 4 0
TEMPERATURE_LIMIT 31 1 80
MAX_VOLTAGE 32 2 160
MIN_VOLTAGE 34 2 95
PWM_LIMIT 36 2 885
MAX_POSITION 48 4 4095
MIN_POSITION 52 4 0
SHUTDOWN 63 1 52
TORQUE_ENABLE 64 1 0
LED 65 1 0
STATUS_LEVEL 68 1 2
HARDWARE_ERROR 70 1 0
D_GAIN 80 2 0
I_GAIN 82 2 0
P_GAIN 84 2 850
WATCHDOG 98 1 0
GOAL_PWM 100 2 -
PROFILE_ACCELERATION 108 4 0
PROFILE_VELOCITY 112 4 0
GOAL_POSITION 116 4 -
PRESENT_LOAD 126 2 -
PRESENT_VELOCITY 128 4 -
PRESENT_POSITION 132 4 -
PRESENT_VOLTAGE 144 2 -
PRESENT_TEMPERATURE 146 1 -
"""
ROWS = [line.split() for line in MANUAL.split("\n") if line]


def test_every_register_is_in_the_manual():
    assert set(t.REGISTERS) == {row[0] for row in ROWS}


@pytest.mark.parametrize("row", ROWS, ids=lambda row: row[0])
def test_addresses(row):
    name, address, size, initial = row
    register = t.REGISTERS[name]
    assert (register.address, register.size) == (int(address), int(size))
    assert initial == "-" or register.initial == int(initial)
    assert register.eeprom == (register.address < 64)


def test_blocks_hold_what_is_read_from_them():
    for (address, length), registers in (
        (t.FAST_BLOCK, (t.PRESENT_LOAD, t.PRESENT_VELOCITY, t.PRESENT_POSITION)),
        (t.SLOW_BLOCK, (t.PRESENT_VOLTAGE, t.PRESENT_TEMPERATURE)),
        (t.STATE_BLOCK, (t.TORQUE_ENABLE, t.HARDWARE_ERROR, t.WATCHDOG, t.GOAL_PWM)),
    ):
        for register in registers:
            assert address <= register.address
            assert register.address + register.size <= address + length


@given(st.sampled_from(sorted(t.REGISTERS)), st.data())
def test_values_survive_as_bytes(name, data):
    register = t.REGISTERS[name]
    value = data.draw(st.integers(register.low, register.high))
    assert t.unpack(register, t.pack(register, value), register.address) == value


def test_hardware_errors_in_words():
    assert t.hardware_error_text(0) == ""
    assert t.hardware_error_text(0x24) == "too hot, overload"
    assert t.hardware_error_text(0x80) == "error 128"
