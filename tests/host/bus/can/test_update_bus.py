"""Firmware over the bus takes its share of a bus of any rate."""

import pytest

from host.bus.can.open import open_port
from host.bus.can.port import Port
from host.bus.can.update_bus import SHARE, UpdateBus

from .robot import variant


class Silent(Port):
    """A bus on which nobody else says anything, and on whose clock only waiting takes time."""

    def __init__(self, bitrate):
        super().__init__()
        self.bitrate, self.time_s = bitrate, 0.0

    def send(self, identifier, data):
        return True

    def receive(self):
        return None

    def now(self):
        return self.time_s

    def wait_until(self, time_s):
        self.time_s = max(self.time_s, time_s)


@pytest.mark.parametrize("bitrate", [125_000, 1_000_000])
def test_blocks_take_their_share_of_the_bus(bitrate):
    port = Silent(bitrate)
    bus = UpdateBus(port, 1)
    for number in range(1000):
        bus.block(0, number, b"\x55" * 6)
    assert bus.bits / port.now() == pytest.approx(SHARE * bitrate, rel=0.01)


@pytest.mark.parametrize("channel", ["caramelo-one", "caramelo-front,caramelo-rear"])
def test_a_port_has_the_rate_of_the_robot_file(channel):
    with open_port(variant(bitrate=250_000).bus, "virtual", channel) as port:
        assert port.bitrate == 250_000
