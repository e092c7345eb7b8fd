"""The simulated robot in real time on a bus that other programs reach: its joints answer as real ones would.

Frames pass between the adapter and the simulated bus, where they take their time and their turn. Faults come at
moments of the robot's own time.
"""

import time
from collections.abc import Callable

from shared.wire import names as w

from ...bus.can.link import RECEIVE_MOST
from ...bus.can.port import Port
from ...util.errors import UserError
from .bus import Node, SimBus
from .sim_robot import SimRobot, power_off

HOT_C = 90.0
BABBLE_ID = 0x07F  # below SYNC, so that no other frame gets through
CATCH_UP_S = 0.1  # farther behind than that, the simulated time stays behind


def _babble(sim: SimRobot) -> None:
    """Have another node fill the bus from now on."""
    extra = sim.bus.attach(lambda time_us, identifier, data: None)

    def talk(ms: int) -> None:
        for _ in range(12):
            extra.send(BABBLE_ID, bytes(8))

    sim.each_ms.append(talk)


FAULTS: dict[str, Callable[[SimRobot, int], object]] = {  # of a node, 1 .. 12
    "power-cycle": lambda sim, node: sim.joints[node - 1].power_cycle(),
    "power-off": lambda sim, node: power_off(sim, [node]),
    "e-stop": lambda sim, node: sim.nodes[node - 1].send(w.E_STOP_ID, b""),
    "babble": lambda sim, node: _babble(sim),
    "under-voltage": lambda sim, node: sim.joints[node - 1].set_volts(12.0),
    "hot": lambda sim, node: sim.joints[node - 1].set_winding(HOT_C),
}


class Gateway:
    """A simulated robot behind a port for each of its buses."""

    def __init__(self, sim: SimRobot, *ports: Port) -> None:
        assert len(ports) == len(sim.buses)
        self.sim = sim
        self._ends = [(port, _attach(bus, port)) for bus, port in zip(sim.buses, ports, strict=True)]
        self.behind_s = 0.0
        self.stopping = False  # another thread may end it

    def inject(self, fault: str) -> None:
        """Have a fault happen: KIND[:NODE]@SECONDS from now. UserError if it is none."""
        text, _, when = fault.partition("@")
        kind, _, number = text.partition(":")
        try:
            after_ms, node = round(1000 * float(when)), int(number or 1)
        except (ValueError, OverflowError):
            after_ms, node = -1, 0
        if kind not in FAULTS or after_ms < 0 or not 1 <= node <= len(self.sim.joints):
            raise UserError(
                f"--fault {fault}: give KIND[:NODE]@SECONDS with KIND one of {', '.join(FAULTS)}, NODE 1..12"
            )
        self.sim.at(max(1, after_ms), lambda: FAULTS[kind](self.sim, node))

    def run(self, seconds: float | None) -> None:
        """Go on for a time, or until Ctrl-C or ``stopping``."""
        began_s, began_ms = time.monotonic(), self.sim.ms
        while not self.stopping and (seconds is None or self.sim.ms - began_ms < 1000 * seconds):
            self._take()
            self.sim.advance_ms(1)
            behind_s = time.monotonic() - began_s - (self.sim.ms - began_ms) / 1000
            if behind_s < 0:
                time.sleep(-behind_s)
            elif behind_s > CATCH_UP_S:
                self.behind_s += behind_s
                began_s += behind_s

    def _take(self) -> None:
        for port, node in self._ends:
            for _ in range(RECEIVE_MOST):
                frame = port.receive()
                if frame is None:
                    break
                node.send(frame.identifier, frame.data)


def _attach(bus: SimBus, port: Port) -> Node:
    """Return the end of a simulated bus whose frames go out through a port."""

    def out(time_us: int, identifier: int, data: bytes) -> None:
        port.send(identifier, data)

    return bus.attach(out, room=4096)
