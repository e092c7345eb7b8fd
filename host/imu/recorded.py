"""A recorded sensor: one line of six counts per reading, gyro x y z, accelerometer x y z, comma-separated.

A first line with names, empty lines and lines that begin with # are skipped.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path

from ..util.errors import UserError
from ..util.files import read_text
from .base import COUNTS, INT16_MAX, Imu, ImuError

HEADER = "gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z"


class RecordedImu(Imu):
    """Plays a file once, a line per reading."""

    kind = "recorded"

    def __init__(self, path: Path) -> None:
        self._path = path
        self._readings: Iterator[Sequence[int]] = iter(())

    def open(self) -> None:
        """See Imu; the whole file is checked first."""
        try:
            lines = read_text(self._path).splitlines()
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"{self._path}: can't be read: {getattr(error, 'strerror', None) or error}") from None
        self._readings = iter([self._parse(number, line) for number, line in enumerate(lines, 1) if _is_data(line)])

    def _parse(self, number: int, line: str) -> tuple[int, ...]:
        try:
            counts = tuple(int(word) for word in line.split(","))
        except ValueError:
            counts = ()
        if len(counts) != COUNTS or max(map(abs, counts)) > INT16_MAX + 1:
            wanted = f"{COUNTS} whole numbers within +-{INT16_MAX}: {HEADER}"
            raise UserError(f"{self._path}:{number}: {line[:60]!r}: allowed: {wanted}")
        return counts

    def read(self) -> Sequence[int]:
        """See Imu."""
        reading = next(self._readings, None)
        if reading is None:
            raise ImuError(f"{self._path}: the recording is over")
        return reading

    def close(self) -> None:
        """See Imu."""
        self._readings = iter(())


def _is_data(line: str) -> bool:
    return bool(line.strip()) and not line.startswith(("#", "gyro_x"))
