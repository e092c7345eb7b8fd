"""The planner, the joints' bus and the simulated robot in simulated time, to walk over CAN without hardware."""

from collections.abc import Callable, Collection

from ...bus.can.guard import Notice
from ...bus.can.joints import CanJoints
from ...control.planner import Driver
from ...robot.model import Robot
from ...robot.poses import seated_pose_rad
from .sim_robot import SimRobot, sim_port

SESSION = 17
STAND_MOST_S = 6.0
SPEED_M_S = 0.05


class SimWalk:
    """A seated robot; ``arm`` it, then ``go``. Use as a context, or call close()."""

    def __init__(
        self,
        robot: Robot,
        seed: int = 0,
        in_vm: Collection[int] = (),
        report: Callable[[Notice], None] | None = None,
    ) -> None:
        self.robot = robot
        self.sim = SimRobot(robot, seed, in_vm=in_vm)
        self.port = sim_port(self.sim)
        self.bus = CanJoints(robot, self.port, SESSION, seated_pose_rad(robot), report=report)
        self.driver = Driver(robot, planar=True)
        self.lowest_m = 1.0

    def __enter__(self) -> "SimWalk":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def arm(self) -> None:
        """Check the joints and arm them where they are."""
        self.bus.open()
        self.bus.torque(True)

    def go(self, seconds: float, mode: str = "walk", gait: str = "trot") -> None:
        """Drive for a time; planner ticks at its rate, the bus's cycle at its own."""
        self.driver.set_command(mode=mode, gait=gait, vx_m_s=SPEED_M_S if mode == "walk" else 0.0)
        for _ in range(round(seconds * self.driver.rate_hz)):
            self._tick()
            if mode == "walk":
                self.lowest_m = min(self.lowest_m, self.sim.body.height_m)

    def _tick(self) -> None:
        measured = self.bus.read()
        pitch, rate = self.sim.body.pitch(self.sim.time_s)
        self.driver.sense(measured.position_rad, 0.0, pitch, (0.0, rate, 0.0))
        self.bus.write(self.driver.step())
        self.bus.run_for(1 / self.driver.rate_hz)

    def stand_up(self) -> None:
        """Stand up from sitting, and stand still for a moment."""
        end_s = self.sim.time_s + STAND_MOST_S
        while self.driver.state != "standing" and self.sim.time_s < end_s:
            self.go(0.1, mode="stand")
        self.go(0.2, mode="stand")

    def close(self) -> None:
        """Remove the joints' saved parameters."""
        self.sim.close()
