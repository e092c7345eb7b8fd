"""The planner's notices in a tick, in sentences for the driver."""

from shared.planner import status as core

TOLD_S = 3.0  # an odd reading lasts one tick, too short to be seen (chosen)
WORDS = {
    core.POSE_HELD: "pose out of reach: held at the nearest",
    core.FALLEN: "tilted too far: it sits down",
    core.ODD_READING: "a reading of joints or tilt was odd and was left out",
}


class Notices:
    """Keeps the flags of the last seconds."""

    def __init__(self, rate_hz: int) -> None:
        self._ticks = round(TOLD_S * rate_hz)
        self._flags = self._left = 0

    def look(self, flags: int, armed: bool) -> None:
        """Take the flags of a tick; those of a limp robot do not matter."""
        self._flags = flags if armed else 0
        self._left = self._ticks if self._flags & core.ODD_READING else max(0, self._left - 1)

    def words(self) -> list[str]:
        """Return the notices that are still shown."""
        told = self._flags | (core.ODD_READING if self._left else 0)
        return [words for flag, words in WORDS.items() if told & flag]
