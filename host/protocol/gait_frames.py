"""Frames to and from a gait board (firmware/link.py), for a computer: makes frames, and finds them in a stream."""

from collections.abc import Sequence

from firmware import link


def frame(kind: int, values: Sequence[int] = (), size: int = 1) -> bytes:
    """Return the frame with these numbers as payload, each of ``size`` bytes."""
    made = bytearray(link.OVERHEAD + size * len(values))
    end = link.put_each(made, link.PAYLOAD, list(values), len(values), size)
    link.close_frame(made, kind, end)
    return bytes(made)


class FrameReader:
    """Finds frames in a stream that comes in pieces; ``broken`` counts those dropped."""

    def __init__(self) -> None:
        self._reader = link.Reader()
        self._frame = bytearray(link.READER_BYTES)

    @property
    def broken(self) -> int:
        """Number of frames dropped because of a wrong CRC or an impossible length."""
        return self._reader.broken

    def frames(self, data: bytes) -> list[tuple[int, bytes]]:
        """Return (kind, payload) of each frame that ends in ``data``."""
        found = []
        while kind := link.next_frame(self._reader, self._frame, data, len(data)):
            found.append((kind, bytes(self._frame[link.TAKEN : link.TAKEN + self._frame[1]])))
        return found
