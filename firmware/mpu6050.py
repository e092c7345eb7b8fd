"""The MPU6050 inertial sensor over I2C (register map and descriptions, revision 4.2).

``Mpu6050(i2c)`` finds the sensor, runs its built-in self-test, sets +-250 deg/s, +-2 g and the
42 Hz low-pass filter, and then ``read(counts)`` writes gyro x y z and accelerometer x y z as int16
counts without allocating. A reading that can't be trusted returns a fault instead:

    MISSING    the bus did not answer: unplugged, or no power
    STUCK      the same six numbers STUCK_READS times in a row: a live sensor's noise never does that
    SATURATED  a number at the end of its range SATURATED_READS times in a row
    SELF_TEST  the self-test differed from the factory's trim by more than 14 %

The gyro's bias is not this file's: shared/sense/attitude.py averages it while the robot stands still.
"""

import time

from shared.record import field, record
from shared.runtime import Ints, const, hot, ptr8

OK = const(0)
MISSING = const(1)
STUCK = const(2)
SATURATED = const(3)
SELF_TEST = const(4)
FAULT_NAMES = ("ok", "missing", "stuck", "saturated", "self-test failed")

STUCK_READS = const(25)  # half a second at 50 Hz (chosen)
SATURATED_READS = const(5)  # a tenth of a second: longer than any bump (assumed)

_ADDRESS = const(0x68)  # AD0 low (section 6.1)
_SELF_TEST_X = const(0x0D)
_SMPLRT_DIV = const(0x19)
_CONFIG = const(0x1A)
_GYRO_CONFIG = const(0x1B)
_ACCEL_CONFIG = const(0x1C)
_ACCEL_XOUT_H = const(0x3B)
_PWR_MGMT_1 = const(0x6B)
_WHO_AM_I = const(0x75)
_SELF_TEST_SHARE = const(14)  # per cent, section 4.1
_RAW_BYTES = const(14)  # accelerometer, temperature, gyro
_TEMPERATURE = const(6)  # where its two bytes lie
_GYRO = const(8)


@record
class Runs:
    """Readings in a row, up to now."""

    alike: int = field("", "0 .. STUCK_READS")
    at_end: int = field("", "with a number at the end of its range, 0 .. SATURATED_READS")


class Mpu6050:
    """One sensor; ``fault`` is what is wrong with it now, ``faults`` how often each was."""

    def __init__(self, i2c, address=_ADDRESS, sleep_ms=None):
        self._i2c = i2c
        self._read_into = i2c.readfrom_mem_into
        self._address = address
        self._sleep_ms = sleep_ms or getattr(time, "sleep_ms", None)
        self._raw = bytearray(_RAW_BYTES)
        self._last = bytearray(_RAW_BYTES)
        self._runs = Runs()
        self.fault = OK
        self.self_test_percent = [0] * 6
        self.start()

    def start(self):
        """Wake the sensor, test it and set it up; return the fault."""
        try:
            if self._i2c.readfrom_mem(self._address, _WHO_AM_I, 1)[0] != 0x68:
                self.fault = MISSING
                return self.fault
            self._write(_PWR_MGMT_1, 0x01)  # awake, clock from the x gyro (section 4.28)
            self._sleep_ms(30)  # gyro start-up time (product specification, section 6.1)
            self.fault = OK if self._self_test() else SELF_TEST
            self._write(_GYRO_CONFIG, 0x00)  # +-250 deg/s
            self._write(_ACCEL_CONFIG, 0x00)  # +-2 g
            self._write(_CONFIG, 0x03)  # 44 / 42 Hz low-pass
            self._write(_SMPLRT_DIV, 4)  # 200 readings a second
        except OSError:
            self.fault = MISSING
        return self.fault

    def read(self, counts):
        """Write the six counts, gyro first; return OK or the fault, and leave ``counts`` alone on a fault."""
        try:
            self._read_into(self._address, _ACCEL_XOUT_H, self._raw)
        except OSError:
            self.fault = MISSING
            return MISSING
        self.fault = judge(self._raw, self._last, self._runs, counts, self.fault)
        return self.fault

    def _write(self, register, value):
        self._i2c.writeto_mem(self._address, register, bytes((value,)))

    def _mean(self, count=8):
        """Return the mean of ``count`` readings, accelerometer first."""
        sums = [0] * 6
        for _ in range(count):
            self._sleep_ms(5)
            self._read_into(self._address, _ACCEL_XOUT_H, self._raw)
            for i in range(6):
                sums[i] += count_at(self._raw, 2 * i if i < 3 else 2 * i + 2)
        return [total / count for total in sums]

    def _self_test(self):
        """Compare the answer to the built-in stimulus with the factory's trim (section 4.1); return True if it fits."""
        self._write(_CONFIG, 0x00)
        self._write(_SMPLRT_DIV, 0)
        self._write(_GYRO_CONFIG, 0x00)  # the trims hold at +-250 deg/s
        self._write(_ACCEL_CONFIG, 0x10)  # and at +-8 g
        off = self._mean()
        self._write(_GYRO_CONFIG, 0xE0)
        self._write(_ACCEL_CONFIG, 0xF0)
        self._sleep_ms(50)
        on = self._mean()
        trims = factory_trims(self._i2c.readfrom_mem(self._address, _SELF_TEST_X, 4))
        passed = True
        for i in range(6):
            if trims[i] == 0:
                self.self_test_percent[i] = 0  # no factory value: nothing to compare with
                continue
            self.self_test_percent[i] = round(100 * (on[i] - off[i] - trims[i]) / trims[i])
            passed = passed and abs(self.self_test_percent[i]) <= _SELF_TEST_SHARE
        return passed


def factory_trims(registers):
    """Return the six factory trims in counts, accelerometer first, from SELF_TEST_X, _Y, _Z and _A (section 4.1)."""
    shared = registers[3]
    trims = []
    for axis in range(3):
        code = registers[axis] >> 5 << 2 | shared >> (4 - 2 * axis) & 3
        trims.append(4096 * 0.34 * (0.92 / 0.34) ** ((code - 1) / 30) if code else 0)
    for axis in range(3):
        code = registers[axis] & 31
        sign = -1 if axis == 1 else 1
        trims.append(sign * 25 * 131 * 1.046 ** (code - 1) if code else 0)
    return trims


@hot
def judge(raw, last, runs: Runs, counts: Ints, fault: int) -> int:
    """Return what is wrong with a reading, OK if nothing is; then the six counts, gyro first, are in ``counts``.

    ``last``, ``runs``: the reading before and the runs up to it, kept here. ``fault``: the one before this reading;
    SELF_TEST and MISSING stay, as only start() clears them: the settings are gone after a power loss.
    """
    found = _runs_of(raw, last, runs)
    if fault == SELF_TEST or fault == MISSING:
        return fault
    if found == OK:
        for axis in range(3):
            counts[axis] = count_at(raw, _GYRO + 2 * axis)
            counts[axis + 3] = count_at(raw, 2 * axis)
    return found


@hot
def _runs_of(raw, last, runs: Runs) -> int:
    """Continue or end the runs with a reading, and keep it; return STUCK, SATURATED or OK. Temperature is left out."""
    r = ptr8(raw)
    before = ptr8(last)
    same = runs.alike
    if same < STUCK_READS:
        same += 1
    longer = runs.at_end
    if longer < SATURATED_READS:
        longer += 1
    full = 0
    for i in range(0, _RAW_BYTES, 2):
        if i != _TEMPERATURE:
            if r[i] != before[i] or r[i + 1] != before[i + 1]:
                same = 0
            count = count_at(raw, i)
            if count == 32767 or count == -32768:
                full = longer
        before[i] = r[i]
        before[i + 1] = r[i + 1]
    runs.alike = same
    runs.at_end = full
    if same == STUCK_READS:
        return STUCK
    if full == SATURATED_READS:
        return SATURATED
    return OK


@hot
def count_at(raw, at: int) -> int:
    """Return the signed number at ``at``, high byte first."""
    r = ptr8(raw)
    value = r[at] << 8 | r[at + 1]
    if value & 0x8000:
        value -= 0x10000
    return value
