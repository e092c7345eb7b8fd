"""No inertial sensor: if another program simulates the joints, there is none on this side of the bus."""

from collections.abc import Sequence

from .base import Imu, ImuError


class AbsentImu(Imu):
    """A missing sensor; ``why`` is a sentence about it."""

    kind = "absent"

    def __init__(self, why: str) -> None:
        self._why = why

    def open(self) -> None:
        """See Imu."""
        raise ImuError(self._why)

    def read(self) -> Sequence[int]:
        """See Imu."""
        raise ImuError(self._why)

    def close(self) -> None:
        """See Imu."""
