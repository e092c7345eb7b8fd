"""Robots of every place without hardware, and a bus whose joints are at once where they are told."""

from contextlib import ExitStack, contextmanager

from host.bus.base import JOINTS, Bus, Measured, checked_fraction, checked_goals
from host.bus.can.joints import CanJoints
from host.bus.dynamixel.bus import ServoBus
from host.bus.dynamixel.calibration.data import nominal, save_calibration
from host.control.hardware import Hardware
from host.imu.absent import AbsentImu
from host.imu.attitude import Attitude
from host.library.places import NO_IMU, Place, SimulatedClock
from host.library.robot import Robot
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from host.sim.joints.sim_robot import SimRobot, sim_port
from host.sim.plant import PlanePlant
from host.sim.servos.bus import Disturbance, EmulatedBus
from host.sim.servos.loopback import LoopbackPort
from host.sim.servos.process import Emulator


class PromptBus(Bus):
    """Twelve joints without mass; keeps the goals of every tick, and can fail or fall silent."""

    kind = "prompt"

    def __init__(self, position_rad, clock):
        super().__init__()
        self.position_rad, self.holds, self._clock = list(position_rad), False, clock
        self.written, self.failure, self.error, self.stops = [], None, [""] * JOINTS, 0

    def open(self):
        self.holds = False

    def now(self):
        return self._clock()

    def read(self):
        if self.failure is not None:
            raise self.failure
        zeros = (0.0,) * JOINTS
        joints = tuple(self.position_rad)
        return Measured(self.now(), joints, zeros, zeros, (25.0,) * JOINTS, (12.0,) * JOINTS, tuple(self.error),
                        age_s=zeros, slow_age_s=zeros)  # fmt: skip

    def write(self, goals_rad):
        self.written.append(list(checked_goals(goals_rad)))
        if self.holds:
            self.position_rad[:] = goals_rad

    def torque(self, on):
        self.holds = on

    def limit_torque(self, fraction):
        checked_fraction(fraction)

    def emergency_stop(self):
        self.holds = False
        self.stops += 1

    def close(self):
        self.holds = False


def prompt(robot="caramelo", real_time=False):
    """Return a Place of a PromptBus; in ``real_time`` the loop has a thread, as on hardware."""
    loaded, clock = load_robot(robot), SimulatedClock()
    if real_time:
        place = Place(Hardware(None, Attitude(loaded, AbsentImu(NO_IMU))))
        bus = PromptBus(seated_pose_rad(loaded), place.clock)
        return Place(Hardware(bus, place.hardware.attitude))
    bus = PromptBus(seated_pose_rad(loaded), clock)
    return Place(Hardware(bus, Attitude(loaded, AbsentImu(NO_IMU))), clock, clock.advance)


@contextmanager
def robot_in(place):
    """Yield an open robot in simulated time: in a simulator, on emulated servos, on a simulated CAN bus."""
    with ExitStack() as stack:
        if place == "servos":
            robot = Robot(_servos())
        elif place == "can":
            robot = Robot(_can(stack), robot="parallel")
        else:
            robot = Robot(place)
        yield stack.enter_context(robot)


def _servos():
    """Return emulated servos on the ground, in their time."""
    loaded, clock = load_robot("caramelo"), SimulatedClock()
    began_s, mounts = clock(), nominal(loaded)
    emulated = EmulatedBus(loaded, PlanePlant(loaded, seated_pose_rad(loaded)), mounts, 2.0, Disturbance())
    bus = ServoBus(loaded, mounts, LoopbackPort(emulated, lambda: clock() - began_s), clock)

    def advance(seconds):
        clock.advance(seconds)
        emulated.advance(clock() - began_s)

    return Place(Hardware(bus, Attitude(loaded, AbsentImu(NO_IMU))), clock, advance)


def _can(stack):
    """Return joints on a simulated CAN bus, in its time."""
    loaded = load_robot("parallel")
    sim = SimRobot(loaded)
    stack.callback(sim.close)
    bus = CanJoints(loaded, sim_port(sim), 17, seated_pose_rad(loaded))
    return Place(Hardware(bus, Attitude(loaded, AbsentImu(NO_IMU))), bus.now, bus.run_for)


@contextmanager
def robot_on_terminal(folder):
    """Yield an open robot on servos behind a pseudo-terminal, which another process emulates in real time."""
    loaded, calibration = load_robot("caramelo"), folder / "nominal.toml"
    save_calibration(calibration, nominal(loaded))
    with ExitStack() as stack:
        port = stack.enter_context(Emulator("--robot", "caramelo")).port
        yield stack.enter_context(Robot("servos", port=port, calibration=calibration, imu=None))
