"""Roll and pitch from a sensor: body axes, bias at rest, the core's filter, and a watch over the sensor itself.

States: ``aligning`` (at rest, measuring the start attitude and the gyro's bias), ``ok``, ``fault``. In the first and
last there is no attitude, so the planner walks without balance; a sensor that comes back aligns again.
"""

from collections.abc import Sequence

from shared.record import pack
from shared.runtime import zeros
from shared.sense.attitude import ACCEL_REJECTED, ALIGNING, MOVED_WHILE_ALIGNING, attitude_reset, attitude_step

from ..robot.model import Robot
from ..robot.scale import attitude_block, rad
from .base import COUNTS, INT16_MAX, Axes, Imu, ImuError, ImuLate

STUCK_S = 0.5  # real readings are never equal for so long: their noise is several counts (measured on simulated noise)
RETRY_S = 0.5  # between tries to open a missing sensor (chosen)
GAP_S = 0.1  # for this long the last reading replaces missing ones: a body turns little meanwhile (chosen)
# A falling robot turns faster than the 250 deg/s of an MPU6050, for up to 0.3 s in space. Meanwhile the attitude lags
# behind, but it still shows the fall.
SATURATED_S = 0.5
STILL = "measuring the gyro's bias: hold the robot still"
MOVED = "it moved, so the gyro's bias is measured again: hold the robot still"


class Attitude:
    """One robot's attitude; ``update`` once a tick."""

    def __init__(self, robot: Robot, source: Imu) -> None:
        self.source = source
        self.raw = zeros(COUNTS)
        self.block = attitude_block(robot)
        self.fault = ""
        self.note = ""
        self.missed = 0  # readings that did not come in time
        self._axes = Axes(robot.imu.axes)
        self._rate_hz = robot.control.rate_hz
        self._stuck_ticks = round(STUCK_S * self._rate_hz)
        self._saturated_ticks = round(SATURATED_S * self._rate_hz)
        self._last: tuple[int, ...] = ()
        self._alike = self._saturated = self._gap = 0
        self._gap_ticks = round(GAP_S * self._rate_hz)
        self._aligned = self._is_open = False
        self._retry_ticks = self._wait_ticks = round(RETRY_S * self._rate_hz)

    def open(self) -> None:
        """Open the sensor and start to align. A missing one is a fault, not an error: later ticks look for it again."""
        self.align()
        self._open()

    def _open(self) -> None:
        self._wait_ticks = self._retry_ticks
        try:
            self.source.open()
            self._is_open = True
        except ImuError as error:
            self._fail(str(error))

    def close(self) -> None:
        """Close the sensor."""
        self.source.close()

    def align(self) -> None:
        """Start again: take attitude and gyro bias from the next readings at rest."""
        attitude_reset(self.block)
        self._aligned, self.note = False, ""

    @property
    def state(self) -> str:
        """``aligning``, ``ok`` or ``fault``."""
        if self.fault:
            return "fault"
        return "ok" if self._aligned else "aligning"

    @property
    def angles_rad(self) -> tuple[float, float] | None:
        """Roll and pitch, or None while they are not known."""
        if self.state != "ok":
            return None
        return rad(self.block.roll), rad(self.block.pitch)

    @property
    def rates_rad_s(self) -> tuple[float, float, float] | None:
        """Turning speeds about the body's x, y, z without bias, or None while they are not known."""
        if self.state != "ok":
            return None
        x, y, z = (turned * self._rate_hz / (1 << 18) for turned in pack(self.block.turned))
        return x, y, z

    def update(self) -> tuple[float, float] | None:
        """Take one reading and return roll and pitch, or None while they are not known."""
        if not self._is_open:
            self._look_again()
            return None
        try:
            counts = tuple(self.source.read())
        except ImuError as error:
            self.missed += 1
            if isinstance(error, ImuLate) and self._bridge():
                return self.angles_rad
            self._fail(str(error))
            self._is_open, self._wait_ticks = False, 0
            return None
        fault = self._examine(counts)
        if fault:
            self._fail(fault)
            return None
        self.fault, self._gap = "", 0
        self._axes.to_body(counts, self.raw)
        self._take(attitude_step(self.block, self.raw))
        return self.angles_rad

    def _bridge(self) -> bool:
        """Go on with the last reading in place of a missing one; False once that has happened too often."""
        self._gap += 1
        if self.fault or not self._last or self._gap > self._gap_ticks:
            return False
        self._take(attitude_step(self.block, self.raw))
        return True

    def _look_again(self) -> None:
        """Try now and then to open a sensor that does not answer: it may have lost power, and so its settings."""
        self._wait_ticks -= 1
        if self._wait_ticks <= 0:
            self._open()

    def _take(self, flags: int) -> None:
        self._aligned = bool(self.block.gathered >= self.block.align_ticks)
        if flags & ACCEL_REJECTED and flags & ALIGNING:
            self.note = "the accelerometer does not read 1 g at rest: check imu.accel_counts_per_g"
        elif self._aligned:
            self.note = ""
        elif flags & MOVED_WHILE_ALIGNING:
            self.note = MOVED
        elif self.note != MOVED:
            self.note = STILL

    def _examine(self, counts: Sequence[int]) -> str:
        """Return what is wrong with the sensor, "" if nothing."""
        self._alike = self._alike + 1 if counts == self._last else 0
        self._last = tuple(counts)
        self._saturated = self._saturated + 1 if max(map(abs, counts)) >= INT16_MAX else 0
        if self._alike >= self._stuck_ticks:
            return "the IMU is stuck and repeats the same reading: switch it off and on, and check its wires"
        if self._saturated >= self._saturated_ticks:
            return "the IMU is at the end of its range: imu.gyro_counts_per_deg_s may be too large for this robot"
        return ""

    def _fail(self, sentence: str) -> None:
        """Note the first cause, and forget the attitude, which is useless after a gap."""
        if not self.fault:
            self.fault = sentence
            self.align()
