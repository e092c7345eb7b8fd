"""No inertial sensor: joints that another program simulates have none on this side of the bus."""

from collections.abc import Sequence

from .base import Imu, ImuError


class AbsentImu(Imu):
    """A sensor that is not there; ``why`` says so in a sentence."""

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
