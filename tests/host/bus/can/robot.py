"""A simulated robot on a simulated bus, and a driver that walks it: what the tests of this folder share."""

from host.robot.file import load_robot
from host.sim.joints.sim_robot import SimPort
from host.sim.joints.sim_walk import SESSION, SimWalk

__all__ = ["SESSION", "Walker", "variant"]


def variant(**bus):
    """Return the parallel robot with other values in [bus]."""
    robot = load_robot("parallel")
    return robot.model_copy(update={"bus": robot.bus.model_copy(update=bus)})


class Walker(SimWalk):
    """The walk, with frames that get lost, a host that is late, and the notices kept."""

    def __init__(self, jitter_s=0.0, loss=0.0, seed=0, in_vm=(), **bus):
        self.notices = []
        super().__init__(variant(**bus), seed, in_vm, self.notices.append)
        for port in self.ports:
            port.late_s = jitter_s
        self.loss = loss

    @property
    def ports(self):
        return [self.port] if isinstance(self.port, SimPort) else list(self.port.ports)

    def arm(self):
        super().arm()
        for node in (*self.sim.nodes, *(port.node for port in self.ports)):
            node.loss = self.loss
