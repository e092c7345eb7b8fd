"""A host's end of a bus on which joints with the full motor model lie, each on its bench: for commissioning."""

from array import array
from collections import deque
from collections.abc import Sequence

from ...bus.can.port import Port, Received
from ...robot.actuators import Bldc
from ...robot.joint_setups import joint_setups
from ...robot.model import Robot
from .bench import Bench
from .model import Load

ECCENTRIC_RAD = 0.015  # 0.9 degrees, so that there is something to find (chosen)
OFFSET_RAD = 2.345


class BenchPort(Port):
    """Frames need no time here; the benches go on together, by milliseconds."""

    name = "benches"

    def __init__(self, robot: Robot, nodes: Sequence[int]) -> None:
        super().__init__()
        assert isinstance(robot.actuator, Bldc)
        setups, self.benches = joint_setups(robot), []
        for node in nodes:
            setup = setups[node - 1]
            load = Load(inertia_kg_m2=setup.inertia_kg_m2)
            bench = Bench(robot.actuator, load, setup, False, OFFSET_RAD, node, node=node)
            bench.wrong.eccentric_rad = ECCENTRIC_RAD
            self.benches.append(bench)
        self._ms = 0
        self._queue: deque[Received] = deque()
        self._frame = array("H", [0] * 4)

    def send(self, identifier: int, data: bytes) -> bool:
        """See Port."""
        frame = array("H", data.ljust(8, b"\0"))
        for bench in self.benches:
            bench.board.deliver(identifier, frame, len(data))
        self.counters.sent += 1
        return True

    def receive(self) -> Received | None:
        """See Port."""
        if not self._queue:
            return None
        self.counters.received += 1
        return self._queue.popleft()

    def now(self) -> float:
        """See Port."""
        return self._ms / 1000

    def wait_until(self, time_s: float) -> None:
        """See Port: the benches go on."""
        while self._ms < round(time_s * 1000):
            self._ms += 1
            for bench in self.benches:
                bench.run(1)
                self._hear(bench)

    def _hear(self, bench: Bench) -> None:
        sent = bench.board.sent
        while (identifier := sent.take(self._frame)) >= 0:
            self._queue.append(Received(self.now(), identifier, self._frame.tobytes()[: sent.length]))
