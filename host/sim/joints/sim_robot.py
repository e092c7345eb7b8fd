"""Twelve simulated joints on a simulated bus with the plane as their body, in simulated time.

Every millisecond: the frames of that time, one tick of each joint, one step of the body. Deterministic for a seed.
"""

import random
import threading
from collections import deque
from collections.abc import Callable, Collection, Sequence

from ...bus.can.pair import PairPort, bus_of
from ...bus.can.port import Port, Received
from ...robot.joint_setups import joint_setups
from ...robot.model import Robot
from .body import TorqueBody
from .bus import Node, SimBus
from .sim_joint import SimJoint
from .vm.inside import Inside
from .vm_joint import VmInside

MS_US = 1000
START_MS = 300  # until the joints have measured their current offsets


class SimRobot:
    """The robot, its bus and its clock. ``in_vm``: the nodes whose firmware runs in a MicroPython VM of its own."""

    def __init__(self, robot: Robot, seed: int = 0, in_vm: Collection[int] = ()) -> None:
        assert robot.bus.kind == "can"
        self.robot = robot
        self.buses = [SimBus(robot.bus.bitrate, seed + i) for i in range(len(robot.bus.channels))]
        self.body = TorqueBody(robot, seed)
        setups = joint_setups(robot)
        bldc = robot.actuator
        assert bldc.kind == "bldc"
        angle = self.body.angle_rad
        self.joints: list[SimJoint] = []
        try:
            for node, setup in enumerate(setups, 1):
                make = VmInside if node in in_vm else Inside
                self.joints.append(SimJoint(bldc, setup, node, angle[node - 1], make=make))
        except BaseException:
            self.close()
            raise
        self.nodes = [self._attach(joint) for joint in self.joints]
        self.ms = 0
        self.lock = threading.RLock()
        self.held = True  # by hand, seated, until all joints hold it themselves
        self.events: dict[int, list[Callable[[], object]]] = {}
        self.each_ms: list[Callable[[int], None]] = []
        self.advance_ms(START_MS)

    def _attach(self, joint: SimJoint) -> Node:
        node = self.bus_of(joint.node).attach(lambda time_us, identifier, data: joint.deliver(identifier, data))
        joint.send, joint.room = node.send, node.room
        return node

    def bus_of(self, node: int) -> SimBus:
        """Return the bus of a node; with two, the rear legs have the second."""
        return self.buses[bus_of(node) if len(self.buses) > 1 else 0]

    @property
    def bus(self) -> SimBus:
        """Return the first bus, or the only one."""
        return self.buses[0]

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self.bus.now_us * 1e-6

    @property
    def torque_free(self) -> bool:
        """True while no joint's bridge is on."""
        return not any(joint.bridge for joint in self.joints)

    def at(self, ms: int, do: Callable[[], object]) -> None:
        """Have something happen at a millisecond from now."""
        self.events.setdefault(self.ms + ms, []).append(do)

    def advance_ms(self, count: int) -> None:
        """Go on by milliseconds."""
        self.advance_us((self.ms + count) * MS_US)

    def advance_us(self, to_us: float) -> None:
        """Go on to a time; one thread at a time."""
        with self.lock:
            while (self.ms + 1) * MS_US <= to_us:
                self._millisecond()
            for bus in self.buses:
                bus.advance(to_us)

    def _millisecond(self) -> None:
        now_us = (self.ms + 1) * MS_US
        for bus in self.buses:
            bus.advance(now_us)
        self.ms += 1
        for do in self.events.pop(self.ms, ()):
            do()
        for call in self.each_ms:
            call(self.ms)
        angle = self.body.angle_rad
        for i, joint in enumerate(self.joints):
            joint.tick(now_us, angle[i])
        if self.held and all(joint.bridge for joint in self.joints):
            self.held = False
        if not self.held:
            self.body.step([joint.torque_Nm for joint in self.joints])

    def close(self) -> None:
        """Remove the joints' saved parameters."""
        for joint in self.joints:
            joint.close()


class SimPort(Port):
    """The host's adapter on the simulated bus; every waking is late by up to ``late_s``, at random."""

    name = "simulated"

    def __init__(self, sim: SimRobot, bus: SimBus | None = None) -> None:
        super().__init__()
        self.sim, self.late_s, self._random = sim, 0.0, random.Random(1)
        self._queue: deque[Received] = deque()
        self.node = (bus or sim.bus).attach(self._deliver)

    def _deliver(self, time_us: int, identifier: int, data: bytes) -> None:
        self._queue.append(Received(time_us * 1e-6, identifier, data))

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port."""
        with self.sim.lock:
            sent = self.node.send(identifier, data)
        if sent:
            self.counters.sent += 1
        else:
            self.counters.full += 1
        return sent

    def send_first(self, identifier: int, data: bytes) -> bool:
        """See Port: all that waits goes, as a socket of higher priority overtakes it on a real bus."""
        with self.sim.lock:
            self.node.waiting.clear()
        return self.send(identifier, data)

    def receive(self) -> Received | None:
        """See Port."""
        if not self._queue:
            return None
        self.counters.received += 1
        return self._queue.popleft()

    def now(self) -> float:
        """See Port."""
        return self.sim.time_s

    def wait_until(self, time_s: float) -> None:
        """See Port: the simulation goes on."""
        late_s = self._random.uniform(0, self.late_s) if self.late_s else 0.0
        self.sim.advance_us((time_s + late_s) * 1e6)


def sim_port(sim: SimRobot) -> Port:
    """Return the host's end of the robot's bus or buses."""
    ports = [SimPort(sim, bus=bus) for bus in sim.buses]
    return PairPort(*ports) if len(ports) == 2 else ports[0]


def power_off(sim: SimRobot, nodes: Sequence[int]) -> None:
    """Take the supply of some joints away."""
    for node in nodes:
        sim.joints[node - 1].power = False
        sim.joints[node - 1].torque_Nm = 0.0
        sim.nodes[node - 1].connected = False
