"""A simulated robot on a simulated bus, and a driver that walks it: what the tests of this folder share."""

from host.buses.can_joints import CanJoints
from host.drive import Driver
from host.emulator.plant import seated_pose_rad
from host.joints.sim_robot import SimPort, SimRobot
from host.robot_file import load_robot

SESSION = 17


class Walker:
    """The robot, its joints' bus and the planner; all in simulated time."""

    def __init__(self, jitter_s=0.0, loss=0.0, loops=None, seed=0, in_vm=()):
        self.robot = load_robot("parallel")
        self.sim = SimRobot(self.robot, seed, in_vm=in_vm)
        self.port = SimPort(self.sim, jitter_s, seed=seed)
        self.notices = []
        self.bus = CanJoints(
            self.robot, self.port, SESSION, seated_pose_rad(self.robot), loops=loops, report=self.notices.append
        )
        self.driver = Driver(self.robot, planar=True)
        self.loss = loss
        self.lowest_m = 1.0

    def arm(self):
        self.bus.open()
        self.bus.torque(True)
        for node in (*self.sim.nodes, self.port.node):
            node.loss = self.loss

    def go(self, seconds, mode="walk", gait="trot", vx_m_s=0.05):
        """Drive for a time; planner ticks at its rate, the bus's cycle at its own."""
        self.driver.set_command(mode=mode, gait=gait, vx_m_s=vx_m_s if mode == "walk" else 0.0)
        sim, bus = self.sim, self.bus
        for _ in range(round(seconds * self.driver.rate_hz)):
            measured = bus.read()
            pitch, rate = sim.body.pitch(sim.time_s)
            self.driver.sense(measured.position_rad, 0.0, pitch, (0.0, rate, 0.0))
            bus.write(self.driver.step())
            bus.run_for(1 / self.driver.rate_hz)
            if mode == "walk":
                self.lowest_m = min(self.lowest_m, sim.body.height_m)

    def stand_up(self):
        self.go(4.0, mode="stand")

    def close(self):
        self.sim.close()
