"""A gait controller board as the host sees it: frames out, set-points back, its flags in sentences."""

from array import array
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from firmware import gait as application
from firmware import link
from firmware.mpu6050 import FAULT_NAMES
from shared.body.params import JOINTS
from shared.planner.command import Command
from shared.planner.status import STATE_NAMES
from shared.record import pack

from ..protocol.gait_frames import FrameReader, frame
from ..util.errors import UserError


class Stream(Protocol):
    """A byte stream to a board: a pipe, a serial port."""

    def read(self, count: int) -> bytes:
        """Return up to ``count`` bytes; an empty answer means that nothing came in time."""

    def write(self, data: bytes) -> object:
        """Send bytes."""

    def flush(self) -> None:
        """Push them out."""


@dataclass(frozen=True)
class Setpoints:
    """What a board planned in one tick."""

    tick: int
    flags: int
    state: str
    gait: int
    joints_brad: tuple[int, ...]

    @property
    def remarks(self) -> list[str]:
        """Return what is not as it should be, as sentences."""
        sentences = []
        if self.flags & application.SENSOR_FAULT:
            name = FAULT_NAMES[self.flags >> 20 & 0xF]
            sentences.append(f"inertial sensor {name}: walking without balance at half speed")
        if self.flags & application.COMMAND_STALE:
            sentences.append(f"no command for {application.STALE_MS} ms: standing")
        if self.flags & application.STOPPED:
            sentences.append("stopped by STOP: drives nothing until RESET")
        if self.flags & application.ALIGNING_NOW:
            sentences.append("aligning the attitude: keep the robot still")
        return sentences


class GaitBoardLink:
    """Talks with a board over a stream; raises UserError when it does not answer."""

    def __init__(self, stream: Stream) -> None:
        self._stream = stream
        self._reader = FrameReader()
        payload = self._wait_for(link.READY)
        self.rate_hz = payload[0] | payload[1] << 8
        self.gaits = payload[2]

    def send_command(self, command: Command) -> None:
        """Send a command."""
        self._send(link.COMMAND, pack(command), 4)

    def send_joints(self, joints_brad: Sequence[int]) -> None:
        """Send the twelve measured joint angles."""
        self._send(link.SENSED, joints_brad[:JOINTS], 2)

    def send_counts(self, counts: Sequence[int]) -> None:
        """Send an inertial reading to a board without a sensor of its own."""
        self._send(link.COUNTS, counts, 2)

    def stop(self) -> None:
        """Emergency stop: the board drives nothing until reset()."""
        self._send(link.STOP)

    def reset(self) -> None:
        """Allow driving again after stop(); the board waits for a new command."""
        self._send(link.RESET)

    def tick(self) -> Setpoints:
        """Pace the board by one tick and return what it planned."""
        self._send(link.TICK)
        return self.receive()

    def receive(self) -> Setpoints:
        """Wait for the next set-points."""
        payload = self._wait_for(link.SETPOINTS)
        numbers = array("h", [link.read_int16(payload, 10 + 2 * joint) for joint in range(JOINTS)])
        return Setpoints(
            tick=int.from_bytes(payload[0:4], "little"),
            flags=int.from_bytes(payload[4:8], "little"),
            state=STATE_NAMES[payload[8]],
            gait=payload[9],
            joints_brad=tuple(numbers),
        )

    def _send(self, kind: int, values: Sequence[int] = (), size: int = 1) -> None:
        self._stream.write(frame(kind, values, size))
        self._stream.flush()

    def _wait_for(self, kind: int) -> bytes:
        """Return the payload of the next frame of this kind."""
        for _ in range(4096):
            byte = self._stream.read(1)
            if not byte:
                raise UserError("gait board: no answer: is it powered, and does it run the gait firmware?")
            for came, payload in self._reader.frames(byte):
                if came == kind:
                    return payload
        raise UserError("gait board: answers, but not in frames: is this the gait board's port?")
