"""A robot on a clock that the test moves: the simulated bus, the supervisor, and a loop without waiting."""

from math import inf

from host.control.arbiter import Client
from host.control.loop import Loop
from host.control.supervisor import Supervisor
from host.imu.attitude import Attitude
from host.robot.file import load_robot
from host.sim.bus import SimulatedBus
from host.sim.imu import SimulatedImu

SCRIPT, PAGE, OTHER_PAGE = Client("script", 1), Client("web", 1), Client("web", 2)
KEYS, PAD = Client("keyboard"), Client("gamepad")
STILL = {"type": "drive", "vx_m_s": 0.0, "vy_m_s": 0.0, "wz_rad_s": 0.0, "pose": [0.0] * 6}
AHEAD = {**STILL, "vx_m_s": 0.05}
STAND = {"type": "posture", "posture": "stand"}
SIT = {"type": "posture", "posture": "sit"}
REST = {"type": "posture", "posture": "rest"}
STOP, RESET = {"type": "stop"}, {"type": "reset"}


ALIGNED_S = 5.0  # it lies still by then


class Silence:
    """A source that never says anything."""

    came_s = inf

    def poll(self, timeout_s):
        """See host.control.loop.Source."""


class Rig:
    """One robot, in the plane unless ``plant`` is another.

    ``run`` ticks and sends as ``client``: ``first`` once, ``message`` every 0.1 s; ``each`` is called before each tick.
    """

    def __init__(self, name="caramelo", plant=None):
        self.now_s, self.each = 0.0, lambda: None
        self.robot = load_robot(name)
        self.bus = SimulatedBus(self.robot, self.clock, plant)
        self.bus.open()
        self.attitude = attitude = Attitude(self.robot, SimulatedImu(self.robot, self.bus.plant.inertial))
        self.put_back = 0

        def put_back():
            self.put_back += 1
            self.bus.plant.put_back()
            attitude.align()

        self.supervisor = Supervisor(
            self.robot, self.bus, attitude.update, put_back=put_back, rates=lambda: attitude.rates_rad_s,
            planar=plant is None,
        )
        self.loop = Loop(self.supervisor, clock=self.clock)
        self.arbiter = self.supervisor.arbiter

    def clock(self):
        return self.now_s

    def send(self, message, client=SCRIPT):
        return self.loop.receive(client, message)

    def run(self, seconds, message=None, client=SCRIPT, first=None):
        if first is not None:
            self.send(first, client)
        for tick in range(round(seconds / self.loop.pacer.period_s)):
            if message is not None and tick % 5 == 0:
                self.send(message, client)
            self.each()
            self.loop.tick(Silence())
            self.now_s += self.loop.pacer.period_s

    def stand(self, client=SCRIPT):
        """Stand up once the attitude is known, and return once it stands."""
        self.run(0.2)
        while self.attitude.state == "aligning" and self.now_s < ALIGNED_S:
            self.run(0.1)
        self.run(3.0, STILL, client, first=STAND)
        assert self.supervisor.state == "standing"

    @property
    def reason(self):
        return self.supervisor.reason(self.now_s)

    @property
    def holding(self):
        return any(self.bus.plant.drives.on)
