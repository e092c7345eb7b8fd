"""The interface of every inertial sensor: six raw counts in the sensor's axes, gyro x y z, accelerometer x y z."""

from abc import ABC, abstractmethod
from collections.abc import MutableSequence, Sequence

from ..util.errors import NOT_ACHIEVED, UserError

COUNTS = 6
INT16_MAX = 32767


class ImuError(UserError):
    """A sensor that does not answer, or a recording that is over."""

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence, NOT_ACHIEVED)


class ImuLate(ImuError):
    """One reading that did not come in time, or came damaged; the next may be good again."""


class Imu(ABC):
    """One inertial sensor."""

    kind = "abstract"

    @abstractmethod
    def open(self) -> None:
        """Connect and set the ranges; ImuError says what is wrong and what to do."""

    @abstractmethod
    def read(self) -> Sequence[int]:
        """Return six int16 counts in the sensor's axes, well within a tick.

        ImuLate if they did not come in time, ImuError if they will not come at all.
        """

    @abstractmethod
    def close(self) -> None:
        """Disconnect; may be called twice."""


class Axes:
    """Turns sensor axes into body axes by the robot file's imu.axes: the sensor axis along each of the body's."""

    def __init__(self, axes: Sequence[str]) -> None:
        self._rows = [("xyz".index(axis[1]), -1 if axis[0] == "-" else 1) for axis in axes]

    def to_body(self, sensor: Sequence[int], body: MutableSequence[int]) -> None:
        """Write six counts in body axes; -32768 becomes 32767 when its sign changes, the largest int16."""
        for part in (0, 3):
            for axis, (source, sign) in enumerate(self._rows):
                body[part + axis] = min(sign * sensor[part + source], INT16_MAX)

    def to_sensor(self, body: Sequence[float]) -> list[float]:
        """Return six values in sensor axes, from body axes."""
        sensor = [0.0] * COUNTS
        for part in (0, 3):
            for axis, (source, sign) in enumerate(self._rows):
                sensor[part + source] = sign * body[part + axis]
        return sensor
