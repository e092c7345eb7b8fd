"""The gait controller: alone, over its link, and in a real MicroPython that walks the simulator over a pipe."""

import math
from array import array

import pytest

from firmware import gait as application
from firmware import link
from firmware.gait import GaitBoard
from firmware.mpu6050 import MISSING, STUCK
from host.protocol.gait_frames import frame
from host.robot.file import load_robot
from host.robot.plane import planar_robot
from host.robot.scale import attitude_block, brad, core_params, joints_rad, scale_of
from shared.planner.command import COMMAND_SIZE, MODE_WALK, Command
from shared.planner.planner import Planner
from shared.record import pack
from shared.sense.attitude import ALIGNING, attitude_step
from shared.sense.sensed import Sensed
from sim2d import terrain
from sim2d.run import simulate
from tests.waiting import PATIENCE_S

from .gait_board_link import GaitBoardLink
from .gait_vm import compile_gait, start_gait_vm
from .piped_gait import COUNTS, TICK, FrameSensor

ROBOT = load_robot("caramelo")
LEVEL = [0, 0, 0, 0, 0, 16384]


def walk_command():
    command = Command()
    command.mode, command.balance = MODE_WALK, 1
    command.speed.vx = scale_of(ROBOT).lf_per_tick(0.05)
    return command


class Loop:
    """A board in this process behind the bytes of its link; ``say`` sends, ``tick`` plans and decodes."""

    def __init__(self):
        self.sensor = FrameSensor()
        self.board = GaitBoard(core_params(ROBOT), attitude_block(ROBOT), self.sensor)
        self.out = bytearray(self.board.ready)
        self.link = GaitBoardLink(self)

    def read(self, count):
        taken, self.out = self.out[:count], self.out[count:]
        return bytes(taken)

    def write(self, data):
        while kind := self.board.take(data, len(data)):
            if kind == COUNTS:
                self.sensor.put(self.board.frame)
            elif kind == TICK:
                self.board.tick()
                self.out += self.board.setpoints

    def flush(self):
        pass

    def run(self, ticks, command=True, counts=LEVEL):
        answer = None
        rest = [brad(a) for a in planar_robot(ROBOT).stand_pose_rad]
        for _ in range(ticks):
            if command:
                self.link.send_command(walk_command())
            if counts:
                self.link.send_counts(counts)
            self.link.send_joints(rest)
            answer = self.link.tick()
        return answer


@pytest.fixture
def loop():
    return Loop()


def test_it_walks_on_command_and_stands_when_commands_stop(loop):
    answer = loop.run(120)
    assert (answer.state, answer.flags) == ("walking", 0)
    answer = loop.run(13, command=False)
    assert not answer.flags & application.COMMAND_STALE
    answer = loop.run(3, command=False)
    assert answer.flags == application.COMMAND_STALE
    answer = loop.run(400, command=False)
    assert answer.state == "standing"
    assert loop.run(60).state == "walking"


def test_without_a_sensor_it_walks_at_half_speed_and_says_so(loop):
    loop.run(300)
    full = loop.board.planner.speed.vx
    answer = loop.run(100, counts=None)
    assert answer.flags == application.SENSOR_FAULT | MISSING << 20
    assert loop.board.planner.speed.vx == full >> 1
    assert answer.state == "walking"
    loop.run(100)
    assert loop.board.planner.speed.vx == full


def test_a_stuck_sensor_is_a_fault_too(loop):
    loop.board.sensor = type("Stuck", (), {"read": staticmethod(lambda counts: STUCK)})()
    assert loop.run(5).flags >> 20 & 0xF == STUCK


@pytest.mark.parametrize("ticks", [0, 5, 100, 180, 250])
def test_stop_works_from_every_state_and_needs_a_reset(loop, ticks):
    loop.run(ticks)
    loop.link.send(link.STOP)
    answer = loop.run(1)
    assert (answer.state, answer.flags & application.STOPPED) == ("limp", application.STOPPED)
    assert loop.run(50).state == "limp"
    loop.link.send(link.RESET)
    assert loop.run(1, command=False).state == "limp"
    assert loop.run(5).state in ("rising", "walking")


def test_broken_frames_are_counted_and_not_obeyed(loop):
    loop.run(10)
    stop = frame(link.STOP)
    for at in range(2, len(stop)):
        broken = bytearray(stop)
        broken[at] ^= 0x10
        loop.write(broken)
        loop.write(bytes(80))  # whatever it waits for ends
    assert loop.board.reader.broken > 0
    assert not loop.board.status.stopped
    loop.write(stop)
    assert loop.board.status.stopped


@pytest.mark.parametrize(
    ("kind", "values", "size"), [(link.COMMAND, [MODE_WALK] * (COMMAND_SIZE - 1), 4), (link.SENSED, [1] * 13, 2)]
)
def test_a_payload_of_another_length_is_not_taken(loop, kind, values, size):
    before = pack(loop.board.command), loop.board.sensed.pack()
    loop.write(frame(kind, values, size))
    assert (pack(loop.board.command), loop.board.sensed.pack()) == before
    assert loop.board.reader.broken == 1


class VirtualBoard:
    """The board's program in the unix VM behind a pipe, and a host planner that gets the same inputs."""

    rate_hz = 50

    def __init__(self, process):
        self.process = process
        self.read, self.write, self.flush = process.stdout.read, process.stdin.write, process.stdin.flush
        self.link = GaitBoardLink(self)
        self.planner, self.attitude = Planner(core_params(ROBOT)), attitude_block(ROBOT)
        self.sensed = Sensed()
        self.sensed.valid.joints = 1
        self.compared = 0

    def tick(self, sensed):
        counts = [0, round(math.degrees(sensed.pitch_rate_rad_s) * 131), 0]
        force_x, force_z = sensed.specific_force_m_s2
        counts += [round(force / 9.80665 * 16384) for force in (force_x, 0.0, force_z)]
        counts = [max(-32768, min(32767, c)) for c in counts]
        joints = [brad(a) for a in sensed.joint_position_rad]
        self.link.send_command(walk_command())
        self.link.send_counts(counts)
        self.link.send_joints(joints)
        answer = self.link.tick()
        expected = self._host(counts, joints)
        assert list(answer.joints_brad) == expected, f"tick {answer.tick}"
        self.compared += 1
        return joints_rad(answer.joints_brad)

    def _host(self, counts, joints):
        aligning = attitude_step(self.attitude, array("i", counts)) & ALIGNING
        self.sensed.valid.tilt = 0 if aligning else 1
        self.sensed.tilt[:] = self.attitude.roll, self.attitude.pitch
        self.sensed.joints[:] = joints
        self.planner.tick(walk_command(), self.sensed)
        return list(self.planner.joints)

    def close(self):
        self.process.stdin.close()
        return self.process.wait(PATIENCE_S)


def test_a_real_micropython_walks_the_simulator_bit_for_bit_like_the_host(tmp_path):
    board = VirtualBoard(start_gait_vm(compile_gait(tmp_path), ROBOT))
    recording = simulate(planar_robot(ROBOT), board, terrain.flat(), duration_s=30, distance_m=0.3)
    assert recording.outcome.ok, recording.outcome.sentence
    assert board.compared > 400
    assert board.close() == 0
