"""python-can behind one interface: what is sent arrives, what goes wrong is counted, nothing stops the program."""

import errno
from collections import deque

import can
import pytest

from host.bus.can.adapter import AdapterPort
from host.util.errors import UserError


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
