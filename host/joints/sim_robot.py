"""Twelve simulated joints on a simulated bus with the plane as their body, in simulated time.

Every millisecond: the frames of that time, one tick of each joint, one step of the body. Deterministic for a seed.
"""

import random
from collections import deque
from collections.abc import Callable, Collection, Sequence

from ..can.port import Port, Received
from ..can.simulated import Node, SimBus
from ..robot_model import Robot
from .body import TorqueBody
from .setups import joint_setups
from .sim_joint import SimJoint
from .vm.inside import Inside
from .vm_joint import VmInside

MS_US = 1000
START_MS = 300  # until the joints have measured their current offsets


class SimRobot:
    """The robot, its bus and its clock. ``in_vm``: the nodes whose firmware runs in a MicroPython VM of its own."""

    def __init__(
        self, robot: Robot, seed: int = 0, body: TorqueBody | None = None, in_vm: Collection[int] = ()
    ) -> None:
        self.robot = robot
        self.bus = SimBus(robot.bus.bitrate if robot.bus.kind == "can" else 1_000_000, seed)
        self.body = TorqueBody(robot, seed=seed) if body is None else body
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
        self.held = True  # by hand, seated, until all joints hold it themselves
        self.events: dict[int, list[Callable[[], None]]] = {}
        self.each_ms: list[Callable[[int], None]] = []
        self.advance_ms(START_MS)

    def _attach(self, joint: SimJoint) -> Node:
        node = self.bus.attach(lambda time_us, identifier, data: joint.deliver(identifier, data))
        joint.send, joint.room = node.send, node.room
        return node

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return self.bus.now_us * 1e-6

    @property
    def torque_free(self) -> bool:
        """True while no joint's bridge is on."""
        return not any(joint.bridge for joint in self.joints)

    def at(self, ms: int, do: Callable[[], None]) -> None:
        """Have something happen at a millisecond from now."""
        self.events.setdefault(self.ms + ms, []).append(do)

    def advance_ms(self, count: int) -> None:
        """Go on by milliseconds."""
        self.advance_us((self.ms + count) * MS_US)

    def advance_us(self, to_us: float) -> None:
        """Go on to a time."""
        while (self.ms + 1) * MS_US <= to_us:
            self._millisecond()
        self.bus.advance(to_us)

    def _millisecond(self) -> None:
        now_us = (self.ms + 1) * MS_US
        self.bus.advance(now_us)
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
        """Remove what the joints have saved."""
        for joint in self.joints:
            joint.close()


class SimPort(Port):
    """The host's adapter on the simulated bus; ``jitter_s`` delays every waking by up to that, at random."""

    name = "simulated"

    def __init__(self, sim: SimRobot, jitter_s: float = 0.0, room: int = 64, seed: int = 1) -> None:
        super().__init__()
        self.sim, self._jitter_s, self._random = sim, jitter_s, random.Random(seed)
        self._queue: deque[Received] = deque()
        self.node = sim.bus.attach(self._deliver, room)

    def _deliver(self, time_us: int, identifier: int, data: bytes) -> None:
        self._queue.append(Received(time_us * 1e-6, identifier, data))

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port."""
        if self.node.send(identifier, data):
            self.counters.sent += 1
            return True
        self.counters.full += 1
        return False

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
        late_s = self._random.uniform(0, self._jitter_s) if self._jitter_s else 0.0
        self.sim.advance_us((time_s + late_s) * 1e6)


def power_off(sim: SimRobot, nodes: Sequence[int]) -> None:
    """Take the supply of some joints away."""
    for node in nodes:
        sim.joints[node - 1].power = False
        sim.joints[node - 1].torque_Nm = 0.0
        sim.nodes[node - 1].connected = False
