"""python-can behind one interface: what is sent arrives, what goes wrong is counted, nothing stops the program."""

import errno
import os
import pty
import socket
import sys
import tty
from collections import deque

import can
import pytest

from host.bus.can.adapter import AdapterPort
from host.bus.can.open import open_port
from host.robot.file import load_can_robot
from host.util.errors import UserError
from tests.waiting import wait_until


@pytest.fixture
def pair():
    with (
        AdapterPort("virtual", "caramelo-test", 1_000_000) as a,
        AdapterPort("virtual", "caramelo-test", 1_000_000) as b,
    ):
        yield a, b


def test_frames_go_from_one_node_to_the_other(pair):
    a, b = pair
    assert a.send(0x123, b"\x01\x02")
    received = b.receive()
    assert received is not None
    assert (received.identifier, received.data) == (0x123, b"\x01\x02")
    assert b.receive() is None
    assert (a.counters.sent, b.counters.received) == (1, 1)


def test_an_own_frame_that_comes_back_late_is_no_other_board(pair, monkeypatch):
    """As of a multicast group on a busy machine: it passed for another board of the same node."""
    a, b = pair
    a._echoes = deque()
    sent_s = a.now()
    assert a.send(0x123, b"\x01")
    assert b.send(0x123, b"\x01")
    assert b.send(0x123, b"\x01")
    monkeypatch.setattr(a, "now", lambda: sent_s + 2.0)
    received = a.receive()
    assert received is not None, "the second one is somebody else's"
    assert a.receive() is None


class Failing:
    """An adapter whose driver fails."""

    def __init__(self, error):
        self.error = error

    def send(self, message, timeout):
        raise self.error

    def recv(self, timeout):
        raise self.error

    def shutdown(self):
        return


def test_a_full_send_buffer_is_counted(pair):
    a, _ = pair
    a._shut()
    a._bus = Failing(can.CanOperationError("No buffer space available", errno.ENOBUFS))
    assert not a.send(1, b"")
    assert (a.counters.full, a.counters.bus_off) == (1, 0)
    assert a.trouble == ""


def test_bus_off_is_told_and_recovered_from(pair):
    a, b = pair
    a._shut()
    a._bus = Failing(can.CanOperationError("Network is down", errno.ENETDOWN))
    assert not a.send(1, b"")
    assert a.counters.bus_off == 1
    assert "is bus-off" in a.trouble
    a.wait_until(a.now() + 0.11)
    assert a.send(2, b"")
    assert "is back" in a.trouble
    b.send(3, b"")
    assert a.receive() is not None
    assert a.trouble == ""


def test_an_adapter_that_is_not_there_is_one_line():
    with pytest.raises(UserError, match=r"can't open socketcan nocan7.*run: sudo ip link set nocan7 up"):
        AdapterPort("socketcan", "nocan7", 1_000_000)
    with pytest.raises(UserError, match="allowed socketcan"):
        AdapterPort("pigeon", "0", 1_000_000)


@pytest.mark.parametrize("channel", ["", "0", "1.2.3.4", "/tmp"])
def test_udp_multicast_takes_only_a_multicast_address(channel):
    with pytest.raises(UserError, match=f"--channel {channel}: with udp_multicast give default, or a multicast"):
        AdapterPort("udp_multicast", channel, 1_000_000)


FOREIGN = {
    "of the long kind": can.Message(arbitration_id=0x18DB33F1, data=bytes(8)),
    "remote": can.Message(arbitration_id=0x181, is_extended_id=False, is_remote_frame=True, dlc=8),
    "FD, 64 bytes": can.Message(arbitration_id=0x181, is_extended_id=False, is_fd=True, data=bytes(64)),
    "nine bytes": can.Message(arbitration_id=0x181, is_extended_id=False, data=bytes(9)),
    "twelve bits": can.Message(arbitration_id=0xFFF, is_extended_id=False),
    "negative": can.Message(arbitration_id=-18, is_extended_id=False),
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_frames_of_no_kind_of_ours_are_passed_over(pair, kind):
    """One of 64 bytes ended `joints sim` with a traceback."""
    a, b = pair
    b._bus.queue.put(FOREIGN[kind])
    a.send(0x123, b"")
    received = b.receive()
    assert received is not None
    assert received.identifier == 0x123
    assert b.receive() is None


@pytest.fixture
def serial_line():
    """A serial adapter, and the end of its line that the test holds."""
    line, theirs = pty.openpty()
    tty.setraw(line)
    with AdapterPort("slcan", os.ttyname(theirs), 1_000_000) as port:
        os.close(theirs)
        yield port, line
    os.close(line)


@pytest.mark.parametrize("noise", [b"\xff\xfe\r", b"tXYZ2\r", b"t18\r", b"t1812A\r", b"\xc3"])
def test_noise_on_a_serial_line_is_counted_and_costs_no_frame_but_its_own(serial_line, noise):
    """It ended the program, or made every later frame unreadable."""
    port, line = serial_line
    os.write(line, noise + (b"t1811AA\r" if noise == b"\xc3" else b"") + b"t1811BB\r")
    received = wait_until(port.receive, "nothing received")
    assert received.data == b"\xbb"
    assert (port.counters.unreadable, port.counters.bus_off) == (1, 0)


def test_a_serial_adapter_that_is_pulled_out_is_bus_off_and_closed(serial_line):
    """Leaving it raised, an emergency stop too; the port stayed open, so the adapter came back under another name."""
    port, line = serial_line
    descriptor = port._bus.serialPortOrig.fileno()
    os.dup2(os.open(os.devnull, os.O_RDWR), line)
    assert port.send_first(0, b"") is False
    wait_until(lambda: port.receive() is None and port.counters.bus_off, "not noticed")
    assert "is bus-off" in port.trouble
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(descriptor)


def test_a_datagram_that_is_no_frame_is_counted(multicast):
    """It passed for bus-off, and closed the bus for a tenth of a second."""
    (a, group), (b, _) = multicast("239.74.163.91"), multicast("239.74.163.91")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.sendto(b"\xc1 no frame", (group, 43113))
    a.send(0x123, b"")
    received = wait_until(b.receive, "nothing received")
    assert received.identifier == 0x123
    assert (b.counters.unreadable, b.counters.bus_off) == (1, 0)


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux mixes the groups")
def test_two_multicast_groups_are_two_buses(multicast):
    (a, _), (b, _), (c, _) = multicast("239.74.163.92"), multicast("239.74.163.93"), multicast("239.74.163.93")
    a.send(0x100, b"")
    b.send(0x200, b"")
    received = wait_until(c.receive, "nothing received")
    assert received.identifier == 0x200


@pytest.fixture
def multicast():
    """Make ports of a multicast group; each with its group."""
    opened = []

    def join(group):
        try:
            opened.append(AdapterPort("udp_multicast", group, 1_000_000))
        except UserError as error:
            pytest.skip(f"no network here carries multicast: {error}")
        return opened[-1], group

    yield join
    for port in opened:
        port.close()


def test_a_network_that_is_gone_is_no_full_buffer(pair):
    a, _ = pair
    a._shut()
    error = can.CanOperationError("failed to send via socket")
    error.__cause__ = OSError(errno.ENETUNREACH, "Network is unreachable")
    a._bus = Failing(error)
    assert not a.send(1, b"")
    assert (a.counters.full, a.counters.bus_off) == (0, 1)


@pytest.mark.parametrize("channel", ["", ",", "a,", "a,b,c", "a,a"])
def test_channels_are_one_or_two(channel):
    """A third was forgotten in silence, and ended `joints sim` with a traceback."""
    _, bus = load_can_robot("parallel")
    with pytest.raises(UserError, match=f"--channel {channel}: give one channel, or two different ones with a comma"):
        open_port(bus, "virtual", channel)
