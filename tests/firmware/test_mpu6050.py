"""The inertial sensor's driver against a register file that behaves like the chip's."""

import random

import pytest

from firmware import mpu6050
from firmware.mpu6050 import MISSING, OK, SATURATED, SELF_TEST, STUCK, Mpu6050, Runs, factory_trims, judge

CODES = (0b10101, 0b01110, 0b10011, 0b01101, 0b10010, 0b11001)  # accelerometer x y z, gyro x y z


class Chip:
    """The registers the driver uses, gravity on z, and a stimulus when self-test bits are set."""

    def __init__(self, health=1.0):
        self.registers = bytearray(128)
        self.registers[0x75] = 0x68
        for axis in range(3):
            self.registers[0x0D + axis] = (CODES[axis] >> 2) << 5 | CODES[axis + 3]
        self.registers[0x10] = (CODES[0] & 3) << 4 | (CODES[1] & 3) << 2 | (CODES[2] & 3)
        self.health = health
        self.counts = [0, 0, 16384, 0, 0, 0]
        self.noise = 0
        self.alive = True
        self.writes = []

    def readfrom_mem(self, address, register, count):
        self._check(address)
        return bytes(self.registers[register : register + count])

    def readfrom_mem_into(self, address, register, buffer):
        self._check(address)
        assert register == 0x3B
        self.noise ^= 1
        values = [c + self.noise for c in self._now()]
        for i, value in enumerate([*values[:3], 0, *values[3:]]):
            clipped = max(-32768, min(32767, round(value))) & 0xFFFF
            buffer[2 * i], buffer[2 * i + 1] = clipped >> 8, clipped & 0xFF

    def writeto_mem(self, address, register, data):
        self._check(address)
        self.writes.append((register, data[0]))
        self.registers[register] = data[0]

    def _now(self):
        values = list(self.counts)
        trims = factory_trims(self.registers[0x0D:0x11])
        if self.registers[0x1B] & 0xE0:
            values[3:] = [c + self.health * t for c, t in zip(values[3:], trims[3:], strict=True)]
        if self.registers[0x1C] & 0xE0:
            values[:3] = [c + self.health * t for c, t in zip(values[:3], trims[:3], strict=True)]
        return values

    def _check(self, address):
        if not self.alive or address != 0x68:
            raise OSError(5)


def sensor(chip):
    return Mpu6050(chip, sleep_ms=lambda ms: None)


def test_a_well_sensor_is_set_up_and_read():
    chip = Chip()
    imu = sensor(chip)
    assert imu.fault == OK
    assert chip.writes[-4:] == [(0x1B, 0), (0x1C, 0), (0x1A, 3), (0x19, 4)]
    chip.counts = [100, -200, 16000, -5, 6, -7]
    counts = [0] * 6
    assert imu.read(counts) == OK
    assert [c - chip.noise for c in counts] == [-5, 6, -7, 100, -200, 16000]


@pytest.mark.parametrize(("health", "fault"), [(1.0, OK), (1.10, OK), (0.90, OK), (1.2, SELF_TEST), (0.0, SELF_TEST)])
def test_the_self_test_allows_14_percent(health, fault):
    assert sensor(Chip(health)).fault == fault


def test_trims_follow_the_register_map():
    trims = factory_trims(bytes((0xFF, 0x21, 0x00, 0x30)))
    assert trims[0] == pytest.approx(4096 * 0.34 * (0.92 / 0.34) ** (30 / 30), rel=1e-12)
    assert trims[3] == pytest.approx(25 * 131 * 1.046**30)
    assert trims[4] == pytest.approx(-25 * 131)
    assert trims[2] == trims[5] == 0


def test_a_missing_sensor_is_missing_and_can_come_back():
    chip = Chip()
    imu = sensor(chip)
    chip.alive = False
    counts = [9] * 6
    assert imu.read(counts) == MISSING
    assert counts == [9] * 6
    chip.alive = True
    assert imu.read(counts) == MISSING, "after a power loss the settings are gone: start() must run first"
    assert imu.start() == OK
    assert imu.read(counts) == OK


def test_another_chip_at_the_address_is_not_taken():
    chip = Chip()
    chip.registers[0x75] = 0x70
    assert sensor(chip).fault == MISSING


class FirstJudge:
    """How readings were judged before it was a hot function."""

    def __init__(self):
        self.last, self.same, self.full, self.fault = bytearray(14), 0, 0, OK

    def read(self, raw, counts):
        same, full = True, False
        for i in range(14):
            if i not in (6, 7):
                same = same and raw[i] == self.last[i]
            self.last[i] = raw[i]
        for i in range(0, 14, 2):
            if i != 6:
                full = full or not -32768 < self.count(raw, i) < 32767
        self.same = self.same + 1 if same else 0
        self.full = self.full + 1 if full else 0
        if self.fault in (SELF_TEST, MISSING):
            return self.fault
        self.fault = OK
        if self.same >= mpu6050.STUCK_READS:
            self.fault = STUCK
        elif self.full >= mpu6050.SATURATED_READS:
            self.fault = SATURATED
        else:
            counts[:] = [self.count(raw, at) for at in (8, 10, 12, 0, 2, 4)]
        return self.fault

    def count(self, raw, at):
        return int.from_bytes(raw[at : at + 2], "big", signed=True)


@pytest.mark.parametrize("start", [OK, SELF_TEST, MISSING])
def test_readings_are_judged_as_they_were(start):
    noise = random.Random(5)
    first, last, runs, fault = FirstJudge(), bytearray(14), Runs(), start
    first.fault = start
    counts, expected, seen = [9] * 6, [9] * 6, set()
    raw = bytes(14)
    for _ in range(400):
        kind = noise.choice(("same", "warmer", "live", "full", "full"))
        for _ in range(noise.randrange(1, 60)):
            if kind == "warmer":
                raw = raw[:6] + noise.randbytes(2) + raw[8:]
            elif kind != "same":
                raw = noise.randbytes(14)
            if kind == "full":
                at = noise.choice((0, 2, 4, 8, 10, 12))
                raw = raw[:at] + noise.choice((b"\x7f\xff", b"\x80\x00")) + raw[at + 2 :]
            fault = judge(raw, last, runs, counts, fault)
            assert fault == first.read(raw, expected)
            assert counts == expected
            seen.add(fault)
    assert seen == ({OK, STUCK, SATURATED} if start == OK else {start})


def test_a_stuck_sensor_is_noticed_and_a_live_one_is_not():
    chip = Chip()
    imu = sensor(chip)
    counts = [0] * 6
    assert {imu.read(counts) for _ in range(100)} == {OK}
    chip._now = lambda: [1 - chip.noise] * 6  # the same sum whatever the noise
    faults = [imu.read(counts) for _ in range(mpu6050.STUCK_READS + 2)]
    assert faults[0] == OK
    assert faults[-1] == STUCK


def test_a_saturated_sensor_is_noticed_after_a_bump_is_forgiven():
    chip = Chip()
    imu = sensor(chip)
    counts = [0] * 6
    chip.counts = [40000, 0, 0, 0, 0, 0]
    faults = [imu.read(counts) for _ in range(mpu6050.SATURATED_READS)]
    assert faults == [OK] * (mpu6050.SATURATED_READS - 1) + [SATURATED]
    chip.counts = [0, 0, 16384, 0, 0, 0]
    assert imu.read(counts) == OK
