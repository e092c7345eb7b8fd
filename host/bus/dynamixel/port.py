"""A serial port for dynamixel-sdk that sleeps while it waits, gives up in time, and explains its errors.

The SDK's own port polls without a pause and waits at least 34 ms for a lost answer, almost two ticks of a
50 Hz planner; and its packets check the clock only while there are too few bytes, so a line that never falls silent
would hold them up forever. Here the clock ends a read; the packets are the SDK's.
"""

import errno
import select
import time
from pathlib import Path

import serial
from dynamixel_sdk import PortHandler

from ...util.errors import UserError
from .table import BAUDS

# A lost answer is given up this long after its last byte could have come: one USB poll, the latency timer of an
# adapter that is set up well (1 ms), and the scheduler (assumed).
PATIENCE_MS = 4.0
LATENCY_TIMER = "/sys/bus/usb-serial/devices/{tty}/latency_timer"
SLOW_LATENCY_MS = 16
WRITE_S = 0.005  # an adapter that takes no bytes for this long has lost the packet (chosen; the largest takes 1 ms)


class ServoPort(PortHandler):  # type: ignore[misc]
    """A PortHandler on a real serial device or a pseudo-terminal."""

    is_real = True

    def __init__(self, name: str, baud: int) -> None:
        super().__init__(name)
        self.ser: serial.Serial | None = None
        self.baudrate = baud
        self.patience_ms = PATIENCE_MS
        self._sent = 0  # bytes of the last packet
        self._expected = 0  # bytes of the awaited answer
        self._late: int | None = None  # bytes to take although the time is over; None: it is not over

    def open(self) -> None:
        """Open the device for this process only; UserError with what to do if that fails."""
        try:
            self.setupPort(self.baudrate)
        except serial.SerialException as error:
            raise UserError(explain(self.port_name, error)) from None

    def setupPort(self, cflag_baud: int) -> bool:
        """Open at a baud rate; the SDK calls it when the rate changes."""
        if self.ser is not None:
            self.closePort()
        self.ser = serial.Serial(self.port_name, cflag_baud, timeout=0, write_timeout=WRITE_S, exclusive=True)
        self.is_open = True
        self.ser.reset_input_buffer()
        self.baudrate = cflag_baud
        self.tx_time_per_byte = 10_000.0 / cflag_baud
        return True

    def getCFlagBaud(self, baudrate: int) -> int:
        """Return the rate if the servos support it, else -1."""
        return baudrate if baudrate in BAUDS else -1

    def readPort(self, length: int) -> bytes:
        """Return up to ``length`` bytes; sleep until there are some, or until the packet's time is over.

        A program that wakes up too late still takes the bytes that came in time, up to an answer's length.
        """
        assert self.ser is not None
        left_s = (self.packet_timeout - self.getTimeSinceStart()) / 1000
        if left_s > 0 and not self.ser.in_waiting:
            select.select([self.ser.fileno()], [], [], left_s)
            left_s = (self.packet_timeout - self.getTimeSinceStart()) / 1000
            if left_s <= 0:
                self._late = min(self.ser.in_waiting, self._expected)
        if left_s <= 0:
            length = min(length, self._late or 0)
            self._late = (self._late or 0) - length
        data: bytes = self.ser.read(length) if length else b""
        return data

    def writePort(self, packet: list[int]) -> int:
        """Send a packet; return how many bytes went out, 0 if the adapter does not take them: the packet is lost."""
        assert self.ser is not None
        self._sent = len(packet)
        try:
            return self.ser.write(bytes(packet)) or 0
        except serial.SerialTimeoutException:
            self.ser.reset_output_buffer()
            return 0

    def setPacketTimeout(self, packet_length: int) -> None:
        """Allow an answer its time on the wire after that of what was sent, plus the patience."""
        self.setPacketTimeoutMillis(self.tx_time_per_byte * (self._sent + packet_length) + self.patience_ms)
        self._expected, self._late = packet_length, None

    def allow(self, length: int, more_ms: float, most: int) -> None:
        """Allow an answer of ``length`` bytes its time as above, and ``more_ms``; take ``most`` bytes at most."""
        self.setPacketTimeout(length)
        self.packet_timeout += more_ms
        self._expected = most

    def allow_more(self, length: int) -> None:
        """Allow so many further bytes their time on the wire."""
        self.packet_timeout += self.tx_time_per_byte * length

    def getCurrentTime(self) -> float:
        """Return the time in ms, which never jumps, unlike the SDK's wall clock."""
        return time.monotonic() * 1000


def explain(port: str, error: serial.SerialException) -> str:
    """Return why a port can't be opened and what to do about it."""
    number = error.errno
    if number == errno.ENOENT:
        there = ", ".join(ports()) or "none is plugged in"
        return f"{port}: no such port; serial ports here: {there}; name yours with --port"
    if number in (errno.EACCES, errno.EPERM):
        return f"{port}: no permission; run: sudo usermod -aG dialout $USER   and log in again"
    if number in (errno.EBUSY, errno.EWOULDBLOCK, errno.EAGAIN) or "lock" in str(error):
        return f"{port}: another program uses it: stop that (another caramelo?), or find it with: fuser {port}"
    return f"{port}: can't be opened: {error}; check that it is a serial port"


def ports() -> list[str]:
    """Return the names of this machine's serial ports."""
    from serial.tools import list_ports

    return sorted(port.device for port in list_ports.comports() if port.hwid != "n/a")


def latency_path(port: str) -> Path:
    """Return the kernel's file for the latency timer of a USB adapter."""
    return Path(LATENCY_TIMER.format(tty=Path(port).resolve().name))


def latency_ms(port: str) -> int | None:
    """Return the USB adapter's latency timer in ms, or None if it has none."""
    try:
        return int(latency_path(port).read_text())
    except (OSError, ValueError):
        return None


def latency_warning(port: str) -> str | None:
    """Return what to do about an adapter that delays every answer by 16 ms, or None if all is well."""
    waits_ms = latency_ms(port)
    if waits_ms is None or waits_ms < SLOW_LATENCY_MS:
        return None
    return f"{port}: the adapter delays answers by {waits_ms} ms; run: echo 1 | sudo tee {latency_path(port)}"
