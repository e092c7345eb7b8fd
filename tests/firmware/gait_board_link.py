"""A gait controller board as a computer sees it: frames out, set-points back."""

from collections import namedtuple

from firmware import link
from host.protocol.gait_frames import FrameReader, frame
from shared.body.params import JOINTS
from shared.planner.status import STATE_NAMES
from shared.record import pack

from .piped_gait import COUNTS, TICK

Setpoints = namedtuple("Setpoints", "tick flags state joints_brad")  # what a board planned in one tick


class GaitBoardLink:
    """Talks with a board over a stream with read(count), write(bytes) and flush()."""

    def __init__(self, stream):
        self._stream, self._reader = stream, FrameReader()
        self._wait_for(link.READY)

    def send(self, kind, values=(), size=1):
        """Send a frame of numbers of ``size`` bytes each."""
        self._stream.write(frame(kind, values, size))
        self._stream.flush()

    def send_command(self, command):
        self.send(link.COMMAND, pack(command), 4)

    def send_joints(self, joints_brad):
        self.send(link.SENSED, joints_brad[:JOINTS], 2)

    def send_counts(self, counts):
        self.send(COUNTS, counts, 2)

    def tick(self):
        """Pace the board by one tick and return what it planned."""
        self.send(TICK)
        payload = self._wait_for(link.SETPOINTS)
        tick, flags = (int.from_bytes(payload[at : at + 4], "little") for at in (0, 4))
        joints = tuple(link.read_int16(payload, 10 + 2 * joint) for joint in range(JOINTS))
        return Setpoints(tick, flags, STATE_NAMES[payload[8]], joints)

    def _wait_for(self, kind):
        """Return the payload of the next frame of this kind."""
        for _ in range(4096):
            byte = self._stream.read(1)
            assert byte, "no answer"
            for came, payload in self._reader.frames(byte):
                if came == kind:
                    return payload
        raise AssertionError("answers, but not in frames")
