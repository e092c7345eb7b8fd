"""A gait controller board as a computer sees it: frames out, set-points back, its flags in sentences."""

from collections import namedtuple

from firmware import gait as application
from firmware import link
from firmware.mpu6050 import FAULT_NAMES
from host.protocol.gait_frames import FrameReader, frame
from shared.body.params import JOINTS
from shared.planner.status import STATE_NAMES
from shared.record import pack


class Setpoints(namedtuple("Setpoints", "tick flags state gait joints_brad")):
    """What a board planned in one tick."""

    @property
    def remarks(self):
        """Return what is not as it should be, as sentences."""
        name = FAULT_NAMES[self.flags >> 20 & 0xF]
        told = {
            application.SENSOR_FAULT: f"inertial sensor {name}: walking without balance at half speed",
            application.COMMAND_STALE: f"no command for {application.STALE_MS} ms: standing",
            application.STOPPED: "stopped by STOP: drives nothing until RESET",
            application.ALIGNING_NOW: "aligning the attitude: keep the robot still",
        }
        return [sentence for flag, sentence in told.items() if self.flags & flag]


class GaitBoardLink:
    """Talks with a board over a stream with read(count), write(bytes) and flush()."""

    def __init__(self, stream):
        self._stream, self._reader = stream, FrameReader()
        payload = self._wait_for(link.READY)
        self.rate_hz, self.gaits = payload[0] | payload[1] << 8, payload[2]

    def send(self, kind, values=(), size=1):
        """Send a frame of numbers of ``size`` bytes each."""
        self._stream.write(frame(kind, values, size))
        self._stream.flush()

    def send_command(self, command):
        self.send(link.COMMAND, pack(command), 4)

    def send_joints(self, joints_brad):
        self.send(link.SENSED, joints_brad[:JOINTS], 2)

    def send_counts(self, counts):
        self.send(link.COUNTS, counts, 2)

    def tick(self):
        """Pace the board by one tick and return what it planned."""
        self.send(link.TICK)
        payload = self._wait_for(link.SETPOINTS)
        tick, flags = (int.from_bytes(payload[at : at + 4], "little") for at in (0, 4))
        joints = tuple(link.read_int16(payload, 10 + 2 * joint) for joint in range(JOINTS))
        return Setpoints(tick, flags, STATE_NAMES[payload[8]], payload[9], joints)

    def _wait_for(self, kind):
        """Return the payload of the next frame of this kind."""
        for _ in range(4096):
            byte = self._stream.read(1)
            assert byte, "no answer"
            for came, payload in self._reader.frames(byte):
                if came == kind:
                    return payload
        raise AssertionError("answers, but not in frames")
