"""A CAN bus behind python-can: socketcan, slcan, gs_usb and other adapters by name, virtual and udp_multicast.

A full send buffer (ENOBUFS) is counted and the frame is gone; nothing waits for room. After bus-off the adapter is
opened again, at most ten times a second, and ``trouble`` says so until a frame comes through again.

An emergency stop goes first. On socketcan it has a socket of its own, whose frames Linux puts into the first of its
three queues (SO_PRIORITY, pfifo_fast): it overtakes waiting frames, and finds room even if the other queue is full.
Only the two or three frames in the controller's mailboxes go before it. On slcan the serial port's waiting output is
thrown away. On gs_usb nothing can be overtaken; the cycle repeats a stop until the joints have heard it.
"""

import errno
import logging
import os
import socket
import struct
import sys
import termios
import threading
import time
from collections import deque
from contextlib import suppress
from ipaddress import ip_address
from typing import Any

import can

from ...util.errors import UserError
from ...util.extras import how_to_get
from .port import Port, Received

INTERFACES = ("socketcan", "slcan", "gs_usb", "virtual", "udp_multicast")
REOPEN_S = 0.1
LAST_ID, LONGEST = 0x7FF, 8  # of a classical frame with a short identifier
SKIP_MOST = 32  # frames of other kinds to skip while looking for one of ours
FIRST_PRIORITY = 6  # the highest that needs no privileges (socket(7)); pfifo_fast sends it before all others
FRAME = struct.Struct("=IB3x8s")  # linux/can.h: struct can_frame
IP_MULTICAST_ALL, IPV6_MULTICAST_ALL = 49, 29  # linux/in.h, linux/in6.h
LOCKED_S = 0.005  # a sender that takes longer hangs in its driver
ECHO_S = 5.0  # one of our own frames that has not come back by then was lost; a busy machine may delay it (chosen)
SERIAL_BAUD = 115200
MULTICAST = "ff15:7079:7468:6f6e:6465:6d6f:6d63:6173"  # python-can's own group

logging.getLogger("can").addHandler(logging.NullHandler())  # an error is one line, and that is ours

_FULL = (errno.ENOBUFS, errno.EAGAIN)
_DOWN = (errno.ENETDOWN, errno.ENETUNREACH, errno.ENODEV, errno.EIO)
_BUS_OFF_BIT = 0x40  # linux/can/error.h: CAN_ERR_BUSOFF
_HINTS = {
    "socketcan": "is it up? run: sudo ip link set {} up type can bitrate {}",
    "slcan": "check that the adapter is plugged in and that you may use the port (group dialout)",
    "gs_usb": "check that the adapter is plugged in, and that its library is installed: pip install gs_usb",
    "udp_multicast": "does a network that is up carry multicast? see: ip link; ip route",
    "virtual": "virtual buses exist only within one process",
}


class AdapterPort(Port):
    """One adapter; UserError with a hint if it can't be opened."""

    def __init__(self, interface: str, channel: str, bitrate: int) -> None:
        super().__init__()
        if interface not in INTERFACES:
            raise UserError(f"--interface {interface}: allowed {', '.join(INTERFACES)}")
        self.name, self.bitrate = f"{interface} {channel}", bitrate
        self._how = (interface, channel)
        self._sending = threading.Lock()  # an emergency stop may come from another thread
        self._off_s: float | None = None
        self._reopen_s = 0.0
        self._echoes: deque[tuple[float, int, bytes]] | None = deque() if interface == "udp_multicast" else None
        self._first: socket.socket | None = None
        self._bus: Any = self._open()

    def _open(self) -> Any:
        interface, channel = self._how
        options: dict[str, Any] = {"interface": interface, "channel": channel, "bitrate": self.bitrate}
        if interface == "slcan":
            options["tty_baudrate"] = SERIAL_BAUD
        if interface == "gs_usb":
            options["index"] = options["channel"] = _number(channel)
        if interface == "udp_multicast":
            options["channel"] = _multicast(channel)
        if interface not in ("virtual", "slcan"):
            options["receive_own_messages"] = False
        try:
            first = _first_socket(channel) if interface == "socketcan" else None
            bus = can.Bus(**options)
        except (can.CanError, can.CanInterfaceNotImplementedError, OSError, ValueError, ImportError) as error:
            if "msgpack" in str(error):
                how = how_to_get("msgpack")
                raise UserError(f"udp_multicast needs msgpack, which is not installed: {how}") from error
            hint = _HINTS[interface].format(channel, self.bitrate)
            raise UserError(f"can't open {self.name}: {error.__cause__ or error}; {hint}") from error
        if interface == "udp_multicast" and sys.platform == "linux":
            _hear_only_its_group(bus)
        self._first = first
        return bus

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port."""
        with self._sending:
            return self._send(identifier, data)

    def send_first(self, identifier: int, data: bytes) -> bool:
        """See Port: never waits for a sender that hangs."""
        if self._first is not None:
            try:
                self._first.send(FRAME.pack(identifier, len(data), data))
            except OSError:
                self.counters.full += 1
                return False
            self.counters.sent += 1
            return True
        if not self._sending.acquire(timeout=LOCKED_S):
            self.counters.full += 1
            return False
        try:
            with suppress(OSError, termios.error):  # sending then fails too, and that is counted
                for line in _serial_lines(self._bus):
                    line.reset_output_buffer()
            return self._send(identifier, data)
        finally:
            self._sending.release()

    def _send(self, identifier: int, data: bytes) -> bool:
        if not self._ready():
            self.counters.full += 1
            return False
        try:
            self._bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False), timeout=0)
        except (can.CanError, OSError, BufferError) as error:
            self._failed(error)
            return False
        self.counters.sent += 1
        if self._echoes is not None:
            self._echoes.append((self.now(), identifier, data))
        return True

    def _failed(self, error: Exception) -> None:
        code = getattr(error, "error_code", None) or getattr(error.__cause__ or error, "errno", None)
        if code in _DOWN:
            self._bus_off()
        elif code in _FULL or code is None:
            self.counters.full += 1
        else:
            raise UserError(f"{self.name}: can't send: {error}") from error

    def receive(self) -> Received | None:
        """See Port."""
        for _ in range(SKIP_MOST):
            if not self._ready():
                return None
            try:
                message = self._bus.recv(timeout=0)
            except (can.CanError, OSError, ValueError, IndexError) as error:
                self._not_received(error)
                continue
            if message is None:
                return None
            if message.is_error_frame:
                if message.arbitration_id & _BUS_OFF_BIT:
                    self._bus_off()
            elif _is_ours(message) and not self._is_echo(message):
                self._off_s = None
                self.counters.received += 1
                return Received(self.now(), message.arbitration_id, bytes(message.data))
        return None

    def _not_received(self, error: Exception) -> None:
        """Go off the bus if the system refused; count what came but is no frame, such as noise on a serial line."""
        if isinstance(error.__cause__ or error, OSError):
            self._bus_off()
            return
        self.counters.unreadable += 1
        if self._how[0] == "slcan":
            self._bus._buffer.clear()  # noise that is no text would stay before all that follows

    def _is_echo(self, message: can.Message) -> bool:
        """Return whether a frame is one of our own: a multicast group returns each to its sender, in order."""
        echoes = self._echoes
        if not echoes:
            return False
        while echoes and echoes[0][0] < self.now() - ECHO_S:
            echoes.popleft()
        for place, (_, identifier, data) in enumerate(echoes):
            if identifier == message.arbitration_id and data == bytes(message.data):
                del echoes[place]
                return True
        return False

    def _bus_off(self) -> None:
        self.counters.bus_off += 1
        self._off_s = self.now()
        self._reopen_s = self.now() + REOPEN_S
        self._shut()

    def _ready(self) -> bool:
        """Open the adapter again after bus-off, once it is time; False while it is not open."""
        if self._bus is None and self.now() >= self._reopen_s:
            try:
                self._bus = self._open()
            except UserError:
                self._reopen_s = self.now() + REOPEN_S
        return self._bus is not None

    @property
    def trouble(self) -> str:
        """See Port."""
        if self._off_s is None:
            return ""
        what = "was bus-off and is back, but receives nothing" if self._bus is not None else "is bus-off"
        return f"{self.name} {what}: check the cable, both terminators, and that all nodes have the same bit rate"

    def now(self) -> float:
        """See Port."""
        return time.monotonic()

    def wait_until(self, time_s: float) -> None:
        """See Port."""
        left_s = time_s - time.monotonic()
        if left_s > 0:
            time.sleep(left_s)

    def _shut(self) -> None:
        bus, self._bus = self._bus, None
        first, self._first = self._first, None
        if first is not None:
            first.close()
        if bus is not None:
            lines = _serial_lines(bus)
            with suppress(can.CanError, OSError):  # slcan says good-bye on a line that may be gone
                bus.shutdown()
            for line in lines:
                line.close()

    def close(self) -> None:
        """See Port."""
        self._shut()
        self._reopen_s = float("inf")


def _hear_only_its_group(bus: Any) -> None:
    """Close a multicast socket to the groups of other programs: Linux gives it all that this machine has joined."""
    with socket.socket(fileno=os.dup(bus.fileno())) as same:
        if same.family == socket.AF_INET6:
            same.setsockopt(socket.IPPROTO_IPV6, IPV6_MULTICAST_ALL, 0)
        else:
            same.setsockopt(socket.IPPROTO_IP, IP_MULTICAST_ALL, 0)


def _serial_lines(bus: Any) -> list[Any]:
    """Return the serial port of an slcan adapter; other buses have none."""
    return [bus.serialPortOrig] if hasattr(bus, "serialPortOrig") else []


def _is_ours(message: can.Message) -> bool:
    """Return whether it is a frame of the kind that we use; other nodes may send any, noise becomes any."""
    special = message.is_extended_id or message.is_remote_frame or message.is_fd
    return not special and 0 <= message.arbitration_id <= LAST_ID and len(message.data) <= LONGEST


def _first_socket(channel: str) -> socket.socket:
    """Return a socket that receives nothing and whose frames go first."""
    first = socket.socket(socket.PF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    try:
        first.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, b"")
        first.setsockopt(socket.SOL_SOCKET, socket.SO_PRIORITY, FIRST_PRIORITY)
        first.setblocking(False)
        first.bind((channel,))
    except BaseException:
        first.close()
        raise
    return first


def _multicast(channel: str) -> str:
    """Return the group's address; python-can would hand a number or an empty name to the resolver as it is."""
    group = MULTICAST if channel == "default" else channel
    try:
        good = ip_address(group).is_multicast
    except ValueError:
        good = False
    if not good:
        raise UserError(f"--channel {channel}: with udp_multicast give default, or a multicast address as {MULTICAST}")
    return group


def _number(channel: str) -> int:
    if not channel.isdecimal():
        raise UserError(f"--channel {channel}: with gs_usb give the adapter's number, 0 for the first")
    return int(channel)
