"""The inertial sensor of a gait board: the real firmware in the unix VM behind pipes, and what goes wrong."""

import os
import select
import signal
import time

import pytest

from firmware import gait_main, link
from firmware.mpu6050 import STUCK
from host.imu.attitude import Attitude
from host.imu.base import ImuError, ImuLate
from host.imu.choose import open_source
from host.imu.gait_board import GaitBoardImu
from host.protocol.gait_frames import FrameReader, frame
from host.robot.file import load_robot
from host.robot.scale import attitude_block, core_params
from host.util.child import end_child
from host.util.errors import UserError
from tests.firmware import piped_gait
from tests.firmware.gait_vm import compile_gait, start_gait_vm
from tests.waiting import PATIENCE_S

ROBOT = load_robot("caramelo")
COUNTS = (-3, 7, -32768, 120, -4, 16384)


class VmStream:
    """The board's program in a process; its sensor gets ``counts`` before each question, if there are any."""

    def __init__(self, process):
        self.process = process
        self.counts = COUNTS

    def fileno(self):
        return self.process.stdout.fileno()

    def read(self, count):
        if not select.select([self.fileno()], [], [], 0)[0]:
            return b""
        data = os.read(self.fileno(), count)
        if not data:
            raise OSError("the other side has closed")
        return data

    def write(self, data):
        counts = frame(piped_gait.COUNTS, self.counts, 2) if self.counts else b""
        return os.write(self.process.stdin.fileno(), counts + data)

    def close(self):
        """The process is the test's."""


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return compile_gait(tmp_path_factory.mktemp("gait"))


@pytest.fixture
def vm(tree):
    stream = VmStream(start_gait_vm(tree, ROBOT, bufsize=0))
    yield stream
    end_child(stream.process, 0.0)


def opened(vm):
    """Return the sensor once the program runs: MicroPython takes a moment to load it."""
    sensor = GaitBoardImu("vm", lambda port: vm)
    for _ in range(20):
        try:
            sensor.open()
        except ImuError:
            continue
        return sensor
    raise AssertionError("the board does not answer")


def reading(sensor):
    """Return a reading; a busy machine may be late for a few."""
    for _ in range(1000):
        try:
            return sensor.read()
        except ImuLate:
            continue
    raise AssertionError("no reading")


def test_the_real_firmware_answers_with_its_sensors_counts(vm):
    sensor = opened(vm)
    assert reading(sensor) == COUNTS
    vm.counts = (1, 2, 3, 4, 5, 6)
    assert reading(sensor) == (1, 2, 3, 4, 5, 6)
    os.kill(vm.process.pid, signal.SIGSTOP)
    vm.counts = (6, 5, 4, 3, 2, 1)
    for _ in range(3):
        with pytest.raises(ImuLate, match="vm: the gait board does not answer in time"):
            sensor.read()
    vm.counts = (7, 7, 7, 7, 7, 7)
    os.kill(vm.process.pid, signal.SIGCONT)
    assert reading(sensor) == (7, 7, 7, 7, 7, 7), "late answers are not taken for this one"
    sensor.close()
    with pytest.raises(ImuError, match="not open"):
        sensor.read()


def test_the_robots_attitude_comes_from_the_board(vm):
    attitude = Attitude(ROBOT, opened(vm))
    attitude.open()
    for tick in range(5000):
        vm.counts = (tick % 3, 1, 2, 0, 0, 16384)
        if attitude.update() is not None:
            break
    assert attitude.state == "ok"
    assert attitude.angles_rad == pytest.approx((0.0, 0.0), abs=0.01)
    vm.process.kill()
    vm.process.wait(PATIENCE_S)
    attitude.update()
    assert "vm: the gait board is gone" in attitude.fault


def test_the_boards_sensor_fault_is_told(vm):
    sensor = opened(vm)
    vm.counts = None
    with pytest.raises(ImuError, match="vm: the gait board's inertial sensor is missing: check its wires"):
        reading(sensor)


class Board:
    """run_board's stream: bytes in, frames out; ends when all is taken."""

    def __init__(self, data):
        self.waiting, self.out = bytearray(data), bytearray()

    def readinto(self, buffer):
        if not self.waiting:
            raise EOFError
        count = min(len(buffer), len(self.waiting))
        buffer[:count], self.waiting[:count] = self.waiting[:count], b""
        return count

    def write(self, data):
        self.out += bytes(data)


class Clock:
    """Each look at it takes a millisecond."""

    def __init__(self):
        self.us = 0

    def ticks_us(self):
        self.us += 1000
        return self.us

    def ticks_add(self, a, b):
        return a + b

    def ticks_diff(self, a, b):
        return a - b


def test_a_board_that_plans_by_itself_answers_between_its_ticks():
    stream, sensor = Board(frame(link.READ, (9,)) + frame(link.READ, (10,))), piped_gait.FrameSensor()
    sensor.read = lambda counts: STUCK
    with pytest.raises(EOFError):
        gait_main.run_board(core_params(ROBOT), attitude_block(ROBOT), sensor, stream, Clock())
    answers = [payload[:2] for kind, payload in FrameReader().frames(bytes(stream.out)) if kind == link.READING]
    assert answers == [bytes((9, STUCK)), bytes((10, STUCK))]


def test_a_flooded_stream_does_not_hold_up_the_ticks():
    stream, sensor = Board(frame(link.STOP) * 10_000), piped_gait.FrameSensor()
    with pytest.raises(EOFError):
        gait_main.run_board(core_params(ROBOT), attitude_block(ROBOT), sensor, stream, Clock())
    kinds = [kind for kind, _ in FrameReader().frames(bytes(stream.out))]
    assert kinds[0] == link.READY
    blocks = 60_000 // gait_main.BLOCK_BYTES
    assert kinds.count(link.SETPOINTS) == pytest.approx(blocks / 20, abs=2)  # one in 20 ms


def test_a_port_without_a_board_says_so(silent_port):
    sensor = GaitBoardImu(silent_port)
    began_s = time.monotonic()
    with pytest.raises(ImuError, match="no gait board answers: install its firmware with caramelo flash"):
        sensor.open()
    assert time.monotonic() - began_s < 10
    with pytest.raises(ImuError, match="no such port"):
        GaitBoardImu("/dev/ttyACM97").open()


@pytest.mark.parametrize(
    ("where", "kind"), [("i2c", "mpu6050"), ("/dev/ttyACM0", "gait board"), ("walk.csv", "recorded")]
)
def test_the_option_names_a_source(where, kind):
    assert open_source(ROBOT, where).kind == kind


def test_another_option_is_refused():
    with pytest.raises(UserError, match="--imu ttyACM0: allowed: i2c, a gait board's port"):
        open_source(ROBOT, "ttyACM0")
