"""A gait board's whole way over a step in the simulator, tick by tick: what it sensed, and what it answered.

The board's own program walks it here, in CPython; what a VM answers to the same bytes must be the same.
"""

from collections.abc import Sequence
from math import degrees

from firmware import link
from firmware.gait import GaitBoard
from firmware.link import PAYLOAD
from firmware.mpu6050 import Mpu6050
from shared.gait.gaits import GAIT_NAMES
from shared.planner.command import MODE_STAND, MODE_WALK, Command
from shared.record import pack
from sim2d import terrain
from sim2d.run import Sensed, simulate

from ...boards.runtimes.base import RuntimeFailure
from ...protocol.gait_frames import frame
from ...robot.model import Robot
from ...robot.plane import planar_robot
from ...robot.scale import attitude_block, brad, core_params, joints_rad, scale_of

SPEED_M_S = 0.05
LONGEST_S = 300.0
STAND_TICKS = 150  # first: the attitude is aligned while the robot stands still
STEP_M, STEP_AT_M, STEP_LONG_M, WAY_M = 0.03, 0.35, 0.3, 1.0
COMMAND_BYTES, SENSED_BYTES, RAW_BYTES = 58, 30, 14  # frames, and what the inertial sensor's registers hold
ANSWER_BYTES = 24  # twelve joint angles of a SETPOINTS frame
ANGLES_AT = PAYLOAD + 10  # where they lie in it
TICK_BYTES = COMMAND_BYTES + SENSED_BYTES + RAW_BYTES + ANSWER_BYTES
_G_M_S2, _ACCEL_PER_G, _GYRO_PER_DEG_S, _INT16 = 9.80665, 16384, 131, 32767


def _command(robot: Robot, mode: int) -> Command:
    block = Command()
    block.mode, block.gait, block.balance = mode, GAIT_NAMES.index("crawl"), 1
    block.speed.vx = scale_of(robot).lf_per_tick(SPEED_M_S)
    return block


class _Registers:
    """The inertial sensor's registers on the bus."""

    def __init__(self) -> None:
        self.raw = bytes(14)

    def readfrom_mem(self, address: int, register: int, count: int) -> bytes:
        return bytes((0x68 if register == 0x75 else 0,) + (0,) * (count - 1))

    def writeto_mem(self, address: int, register: int, data: bytes) -> None:
        pass

    def readfrom_mem_into(self, address: int, register: int, raw: bytearray) -> None:
        raw[:] = self.raw


class _Walker:
    """The board's program as the simulator's controller; ``ticks`` holds of each the four blocks named above."""

    def __init__(self, robot: Robot) -> None:
        self._i2c = _Registers()
        sensor = Mpu6050(self._i2c, sleep_ms=lambda ms: None)
        self._board = GaitBoard(core_params(robot, planar=True), attitude_block(robot), sensor)
        self._robot = robot
        self.rate_hz = self._board.rate_hz
        self.ticks: list[bytes] = []

    def tick(self, sensed: Sensed) -> Sequence[float]:
        """See sim2d.run.Controller."""
        joints = frame(link.SENSED, [brad(angle) for angle in sensed.joint_position_rad], 2)
        self._i2c.raw = _raw(sensed, len(self.ticks) % 3 - 1)
        wish = pack(_command(self._robot, MODE_STAND if len(self.ticks) < STAND_TICKS else MODE_WALK))
        command = frame(link.COMMAND, wish, 4)
        for one in (command, joints):
            self._board.take(one, len(one))
        self._board.tick()
        answer = bytes(self._board.setpoints[ANGLES_AT : ANGLES_AT + ANSWER_BYTES])
        self.ticks.append(command + joints + self._i2c.raw + answer)
        return joints_rad([link.read_int16(answer, 2 * joint) for joint in range(ANSWER_BYTES // 2)])


def _raw(sensed: Sensed, noise: int) -> bytes:
    """Return acceleration, temperature and turning rate as the sensor's fourteen bytes, ``noise`` counts off.

    A sensor whose last bit stands still is taken for a stuck one.
    """
    force_x, force_z = sensed.specific_force_m_s2
    values = [force / _G_M_S2 * _ACCEL_PER_G for force in (force_x, 0.0, force_z)]
    values += [0.0, 0.0, degrees(sensed.pitch_rate_rad_s) * _GYRO_PER_DEG_S, 0.0]
    counts = [max(-_INT16, min(_INT16, round(value) + noise)) for value in values]
    return b"".join(count.to_bytes(2, "big", signed=True) for count in counts)


def in_plane(robot: Robot) -> list[tuple[int, int]]:
    """Return (place, value) of what a board's PARAMS need so that it does not sway: the simulator holds its roll."""
    usual, plane = pack(core_params(robot)), pack(core_params(robot, planar=True))
    return [(place, value) for place, value in enumerate(plane) if value != usual[place]]


def crawl_walk(robot: Robot, ticks: int = 0) -> list[bytes]:
    """Walk over the step, up and down, and return the ticks. RuntimeFailure if it does not get there.

    ``ticks``: of the beginning alone, 0 for the whole way.
    """
    walker = _Walker(robot)
    ground = terrain.step(STEP_M, STEP_AT_M, STEP_LONG_M)
    recording = simulate(
        planar_robot(robot),
        walker,
        ground,
        duration_s=ticks / walker.rate_hz or LONGEST_S,
        distance_m=WAY_M,
        stuck_after_s=45,
    )
    if not (ticks or recording.outcome.ok):
        raise RuntimeFailure(f"the crawl over {1000 * STEP_M:g} mm: {recording.outcome.sentence}")
    return walker.ticks[: ticks or None]
