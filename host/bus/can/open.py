"""The bus or the two buses of a robot, opened by the names that the robot file or the command line gives."""

from ...robot.actuators import CanBus
from ...util.errors import UserError
from .adapter import AdapterPort
from .pair import PairPort
from .port import Port


def open_port(bus: CanBus, interface: str | None = None, channel: str | None = None) -> Port:
    """Return the port; the robot file gives what is not named. UserError with a hint if it can't be opened."""
    interface = interface or bus.interface
    channels = bus.channels if channel is None else tuple(channel.split(","))
    if len(channels) > 2 or "" in channels or len(set(channels)) < len(channels):
        raise UserError(f"--channel {','.join(channels)}: give one channel, or two different ones with a comma")
    front = AdapterPort(interface, channels[0], bus.bitrate)
    if len(channels) == 1:
        return front
    try:
        return PairPort(front, AdapterPort(interface, channels[1], bus.bitrate))
    except BaseException:
        front.close()
        raise
