"""A robot on emulated servos in this process, on a clock that the test moves: a minute of walking takes seconds."""

from host.bus.dynamixel.bus import ServoBus
from host.bus.dynamixel.calibration.data import nominal
from host.control.planner import Driver
from host.control.safety import Safety, torque_limit
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from host.sim.plant import JointPlant, PlanePlant
from host.sim.servos.bus import Disturbance, EmulatedBus
from host.sim.servos.loopback import LoopbackPort

CARAMELO = load_robot("caramelo")
PERIOD_S = 1 / CARAMELO.control.rate_hz


def speaking(protocol):
    """Return Caramelo with a bus of that protocol."""
    return CARAMELO.model_copy(update={"bus": CARAMELO.bus.model_copy(update={"protocol": protocol})})


class Rig:
    """Emulated servos, the bus that talks to them, and what a control loop does with it."""

    def __init__(self, protocol=2.0, lost=0.0, corrupted=0.0, seed=0, ground=False, calibration=None):
        self.robot = speaking(protocol)
        self.time_s = 0.0
        self.truth = nominal(self.robot)
        plant = PlanePlant if ground else JointPlant
        self.plant = plant(self.robot, seated_pose_rad(self.robot))
        self.noise = Disturbance(lost, corrupted, seed)
        self.emulated = EmulatedBus(self.robot, self.plant, self.truth, protocol, self.noise)
        self.port = LoopbackPort(self.emulated, lambda: self.time_s)
        self.bus = ServoBus(self.robot, calibration or self.truth, self.port, lambda: self.time_s)
        self.safety = Safety(self.robot, self.bus.name)
        self.driver = Driver(self.robot)
        self.measured = None

    @property
    def servos(self):
        return self.emulated.servos

    def wait(self, seconds):
        """Let time pass with nobody talking."""
        self.time_s += seconds
        self.emulated.advance(self.time_s)

    def read(self, cycles=1):
        """Read for some cycles, and look for faults; return the last reading."""
        for _ in range(cycles):
            self.wait(PERIOD_S)
            self.measured = self.bus.read()
            self.safety.update(self.measured)
        return self.measured

    def tick(self, **wish):
        """One control cycle: read, plan, write; sits down when safety says so, lets go when it must."""
        self.read()
        if wish:
            self.driver.set_command(**wish)
        if self.safety.action == "sit":
            self.driver.set_command(mode="sit")
        if self.safety.action == "limp":
            self.bus.emergency_stop()
        self.driver.sense(self.measured.position_rad, 0.0, 0.0)
        goals = self.driver.step()
        self.bus.limit_torque(torque_limit(self.robot, self.driver.state))
        self.bus.write(goals)
        return goals

    def stand_up(self):
        """Switch on and stand."""
        self.bus.open()
        self.read(8)
        self.bus.torque(True)
        for _ in range(150):
            self.tick(mode="stand")
        assert self.driver.state == "standing", self.safety.sentence
