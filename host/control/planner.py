"""The planner as a controller in SI, which drives the simulator, the servos and the joints.

Converts a driver's command and sensed SI values into the core's blocks, runs one tick, and converts
the twelve angles back. Between these two conversions there are only the core's integers.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from shared.gait.table import MOVER_CRAWL, MOVER_TABLE, Gait
from shared.planner import command as core
from shared.planner.command import MODE_FOLD, MODE_LIMP, MODE_SIT, MODE_STAND, MODE_WALK
from shared.planner.planner import Planner
from shared.planner.status import CARRIES, RISING, STANDING, STATE_NAMES
from shared.record import pack
from shared.sense.odometry import odometry_restart
from shared.sense.sensed import PITCH, ROLL, Sensed

from ..robot.gait_names import gait_index
from ..robot.model import Robot
from ..robot.scale import brad, core_params, joints_rad, scale_of
from ..robot.trot_tuning import limit
from .odometry import Odometry, read_odometry

MODES = {"limp": MODE_LIMP, "stand": MODE_STAND, "walk": MODE_WALK, "sit": MODE_SIT, "fold": MODE_FOLD}

PUT_DOWN = "lifted off the ground, it holds its legs still: put it down"
LET_GO = "it was off the ground: let go of the sticks, then drive again"


@dataclass(frozen=True)
class Command:
    """A driver's command: m/s, rad/s, m, rad; ``height_m`` 0 is the gait's own swing height."""

    mode: str = "stand"
    gait: str = "trot"
    vx_m_s: float = 0.0
    vy_m_s: float = 0.0
    wz_rad_s: float = 0.0
    pose: tuple[float, float, float, float, float, float] = (0.0,) * 6
    balance: bool = True
    height_m: float = 0.0


class Driver:
    """One robot's planner with SI on both sides; ``rate_hz`` ticks a second."""

    def __init__(self, robot: Robot, planar: bool = False) -> None:
        """``planar``: the robot moves in the sagittal plane, where it neither sways sideways nor turns."""
        self.robot = robot
        self.scale = scale_of(robot)
        self.rate_hz = self.scale.rate_hz
        self.planner = Planner(core_params(robot, planar=planar), tuple(own.entry for own in robot.gait.own))
        self.command = Command(gait=robot.gait.default)
        self._command = core.Command()
        self._sensed = Sensed()
        self.flags = 0

    @property
    def command_integers(self) -> list[int]:
        """The core's command of the last tick (shared/planner/command.py); a record keeps it."""
        return list(pack(self._command))

    @property
    def sensed_integers(self) -> list[int]:
        """The core's sensed values of the last tick (shared/sense/sensed.py)."""
        return list(self._sensed.pack())

    @property
    def state(self) -> str:
        """The planner's state as a word."""
        return STATE_NAMES[self.planner.status.state]

    @property
    def lifted(self) -> str:
        """Return what to do with a robot that was lifted off the ground and holds its legs still; "" if it was not."""
        status = self.planner.status
        if not status.lifted or status.state not in (RISING, STANDING):
            return ""
        return LET_GO if status.carries_weight == CARRIES else PUT_DOWN

    @property
    def odometry(self) -> Odometry:
        """Where the robot has walked to since the start, or since it was put down."""
        return read_odometry(self.planner.params, self.planner.odometry)

    def restart_odometry(self) -> None:
        """Count from here: the robot has been put down elsewhere."""
        odometry_restart(self.planner.odometry)

    def _gait(self, name: str) -> Gait:
        return self.planner.gaits[gait_index(self.robot, name)]

    def speed_limit(self, gait: str) -> tuple[float, str]:
        """Return a gait's top forward command, m/s, and what limits it: a key, or the legs.

        The crawl has its own speed; its figure is that of the trot that takes over from it.
        """
        walked = self._gait(gait)
        most, key = walked.speed_max.vx, "speed_limits.stride_m"
        if walked.mover != MOVER_TABLE:
            key = limit(self.robot)
        elif most == self.planner.params.speed_max.vx:
            key = "speed_limits.vx_m_s"
        return self.scale.metres_per_second(most), key

    def has_own_speed(self, gait: str) -> bool:
        """Return whether a gait walks at its own speed, whatever is commanded: the crawl does."""
        return self._gait(gait).mover == MOVER_CRAWL

    def fastest(self, gait: str) -> tuple[float, float, float]:
        """Return a gait's top commands: forward and sideways, m/s, and turning, rad/s."""
        most, scale = self._gait(gait).speed_max, self.scale
        return scale.metres_per_second(most.vx), scale.metres_per_second(most.vy), scale.rad_per_second(most.wz)

    def set_command(self, **wish: object) -> None:
        """Change some of the command's fields for the ticks to come."""
        self.command = replace(self.command, **wish)  # type: ignore[arg-type]

    def sense(
        self,
        joints_rad: Sequence[float] | None,
        roll_rad: float | None = None,
        pitch_rad: float | None = None,
        rates_rad_s: Sequence[float] | None = None,
    ) -> None:
        """Fill in the sensed values; None if unknown. ``rates_rad_s``: about x, y, z, without bias."""
        sensed, valid = self._sensed, self._sensed.valid
        valid.turned = int(rates_rad_s is not None)
        for axis, rate in enumerate(rates_rad_s or ()):
            sensed.turned[axis] = self.scale.yaw18_per_tick(rate)
        valid.joints = int(joints_rad is not None)
        for joint, angle_rad in enumerate(joints_rad or ()):
            sensed.joints[joint] = brad(angle_rad)
        valid.tilt = int(roll_rad is not None and pitch_rad is not None)
        if roll_rad is not None and pitch_rad is not None:
            sensed.tilt[ROLL] = brad(roll_rad)
            sensed.tilt[PITCH] = brad(pitch_rad)

    def step(self) -> list[float]:
        """Plan one tick and return the twelve joint goals in rad."""
        self._fill_command()
        self.flags = self.planner.tick(self._command, self._sensed)
        return joints_rad(self.planner.joints)

    def _fill_command(self) -> None:
        wish, scale, block = self.command, self.scale, self._command
        block.mode = MODES[wish.mode]
        block.gait = gait_index(self.robot, wish.gait)
        block.speed.vx = scale.lf_per_tick(wish.vx_m_s)
        block.speed.vy = scale.lf_per_tick(wish.vy_m_s)
        block.speed.wz = scale.yaw18_per_tick(wish.wz_rad_s)
        for axis in range(3):
            block.pose[axis] = scale.lu(wish.pose[axis])
            block.pose[3 + axis] = brad(wish.pose[axis + 3])
        block.balance = int(wish.balance)
        block.height = scale.lu(wish.height_m)
