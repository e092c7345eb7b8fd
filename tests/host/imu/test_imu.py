"""Inertial sensors: the register dialogue, axes, recordings, and a sensor that is stuck, saturated or gone."""

import struct
from math import degrees, radians, sin

import pytest

from host.imu.attitude import MOVED, STILL, Attitude
from host.imu.base import Axes, Imu, ImuError, ImuLate
from host.imu.mpu6050 import Mpu6050
from host.imu.recorded import RecordedImu
from host.robot.file import load_robot
from host.robot.poses import seated_pose_rad
from host.sim.bus import SimulatedBus
from host.sim.imu import SimulatedImu
from host.sim.plant import PlanePlant
from host.util.errors import UserError

CARAMELO = load_robot("caramelo")
RATE_HZ = CARAMELO.control.rate_hz
LEVEL = ((0.0, 0.0, 0.0), (0.0, 0.0, 9.81))


def tilted(pitch_rad, rate_rad_s=0.0):
    """Return the motion of a body with its nose down by ``pitch_rad``: up is then partly behind."""
    return (0.0, rate_rad_s, 0.0), (-9.81 * sin(pitch_rad), 0.0, 9.81 * (1 - sin(pitch_rad) ** 2) ** 0.5)


def updated(attitude, ticks):
    """Return what so many updates give."""
    return [attitude.update() for _ in range(ticks)]


class Chip:
    """An I2C bus with one MPU6050."""

    def __init__(self, identity=0x68, fail=None):
        self.registers, self.fail, self.closed = {0x75: identity}, fail, False
        self.block = struct.pack(">7h", 10, 20, 16384, 0, -1, -2, -32768)

    def __call__(self, number):
        if self.fail and self.fail[0] == "open":
            raise self.fail[1]
        return self

    def read_byte_data(self, address, register):
        assert address == 0x68
        if self.fail and self.fail[0] == "ask":
            raise self.fail[1]
        return self.registers[register]

    def write_byte_data(self, address, register, value):
        self.registers[register] = value

    def read_i2c_block_data(self, address, register, length):
        if self.fail and self.fail[0] == "read":
            raise self.fail[1]
        assert (register, length) == (0x3B, 14)
        return list(self.block)

    def close(self):
        self.closed = True


def test_mpu6050_is_set_up_and_read():
    """Registers and order from the register map: PWR_MGMT_1 6B, CONFIG 1A, GYRO_CONFIG 1B, ACCEL_CONFIG 1C."""
    chip = Chip()
    sensor = Mpu6050(CARAMELO, opener=chip)
    sensor.open()
    assert (chip.registers[0x6B], chip.registers[0x1A], chip.registers[0x1B], chip.registers[0x1C]) == (1, 3, 0, 0)
    assert sensor.read() == (-1, -2, -32768, 10, 20, 16384)
    sensor.close()
    sensor.close()
    assert chip.closed
    with pytest.raises(ImuError, match="not open"):
        sensor.read()


def test_mpu6050_takes_the_robots_ranges():
    imu = CARAMELO.imu.model_copy(update={"gyro_counts_per_deg_s": 32.8, "accel_counts_per_g": 2048})
    chip = Chip()
    Mpu6050(CARAMELO.model_copy(update={"imu": imu}), opener=chip).open()
    assert (chip.registers[0x1B], chip.registers[0x1C]) == (0x10, 0x18)


@pytest.mark.parametrize(
    ("chip", "words"),
    [
        (Chip(identity=0x70), "answers as 0x70, an MPU6050 answers as 0x68"),
        (Chip(fail=("ask", OSError(121, "Remote I/O error"))), "no MPU6050 answers (Remote I/O error)"),
        (Chip(fail=("open", FileNotFoundError(2, "No such file"))), "raspi-config nonint do_i2c 0"),
        (Chip(fail=("open", ModuleNotFoundError("smbus2"))), "no library for the I2C bus on this machine"),
        (Chip(fail=("open", PermissionError(13, "denied"))), "usermod -aG i2c"),
    ],
)
def test_no_sensor_says_what_to_do(chip, words):
    with pytest.raises(ImuError) as wrong:
        Mpu6050(CARAMELO, opener=chip).open()
    assert words in str(wrong.value)


def test_axes_follow_the_robot_file():
    """Sensor turned: its x to the left, its y to the rear."""
    axes, body = Axes(["-y", "+x", "+z"]), [0] * 6
    axes.to_body([1, 2, 3, 10, 20, -32768], body)
    assert body == [-2, 1, 3, -20, 10, -32768]
    axes.to_body([0, -32768, 0, 0, 0, 0], body)
    assert body[0] == 32767
    assert axes.to_sensor([-2, 1, 3, -20, 10, 5]) == [1, 2, 3, 10, 20, 5]


@pytest.mark.parametrize("axes", [["+x", "+y", "+z"], ["-y", "+x", "+z"], ["+x", "-y", "-z"]])
def test_attitude_from_a_turned_sensor(axes):
    """However the sensor is mounted, the robot file's axes give the body's pitch, with the gyro's bias removed."""
    robot = CARAMELO.model_copy(update={"imu": CARAMELO.imu.model_copy(update={"axes": tuple(axes)})})
    pitch_rad, rate_rad_s = 0.0, 0.0
    attitude = Attitude(robot, SimulatedImu(robot, lambda: tilted(pitch_rad, rate_rad_s)))
    attitude.open()
    for _ in range(RATE_HZ):
        assert attitude.state == "aligning"
        attitude.update()
    assert attitude.state == "ok"
    rate_rad_s = radians(30)
    for _ in range(RATE_HZ // 2):
        pitch_rad += rate_rad_s / RATE_HZ
        attitude.update()
    roll, pitch = attitude.angles_rad
    assert degrees(pitch) == pytest.approx(15, abs=0.7)
    assert abs(degrees(roll)) < 0.7


def test_the_bias_is_measured_at_rest_only():
    motion = [((0.0, radians(40), 0.0), LEVEL[1])]
    attitude = Attitude(CARAMELO, SimulatedImu(CARAMELO, lambda: motion[0]))
    attitude.open()
    updated(attitude, 3 * RATE_HZ)
    assert attitude.state == "aligning"
    assert attitude.note == MOVED
    motion[0] = LEVEL
    attitude.update()
    assert attitude.note == MOVED  # still the reason why it takes longer
    updated(attitude, RATE_HZ)
    assert attitude.state == "ok"
    assert attitude.note == ""
    attitude.align()
    attitude.update()
    assert attitude.note == STILL


def test_a_wrong_accelerometer_scale_is_told():
    attitude = Attitude(CARAMELO, SimulatedImu(CARAMELO, lambda: (LEVEL[0], (0.0, 0.0, 19.6))))
    attitude.open()
    updated(attitude, RATE_HZ)
    assert "does not read 1 g at rest" in attitude.note


class Script(Imu):
    """Readings from a function of the tick; an exception is raised."""

    def __init__(self, reading):
        self.reading, self.tick = reading, 0

    def open(self):
        pass

    def read(self):
        self.tick += 1
        value = self.reading(self.tick)
        if isinstance(value, Exception):
            raise value
        return value

    def close(self):
        pass


def noisy(tick):
    return (tick % 3, 1, 2, 0, 0, 16384)


@pytest.mark.parametrize(
    ("reading", "after", "words"),
    [
        (lambda tick: (5, 1, 2, 0, 0, 16384), RATE_HZ // 2 + 1, "the IMU is stuck"),
        (lambda tick: (32767, tick % 7, 0, 0, 0, 16384), RATE_HZ // 2, "the IMU is at the end of its range"),
        (lambda tick: (0, tick % 7, 0, 0, -32768, 16384), RATE_HZ // 2, "the IMU is at the end of its range"),
        (lambda tick: ImuError("I2C 1: stopped answering"), 1, "stopped answering"),
    ],
)
def test_a_bad_sensor_is_a_fault_until_it_is_good_again(reading, after, words):
    bad = False
    attitude = Attitude(CARAMELO, Script(lambda tick: reading(tick) if bad else noisy(tick)))
    attitude.open()
    updated(attitude, RATE_HZ + 1)
    assert attitude.state == "ok"
    bad = True
    assert None not in updated(attitude, after - 1)
    assert updated(attitude, 2) == [None, None]
    assert attitude.state == "fault"
    assert words in attitude.fault
    bad = False
    assert attitude.update() is None
    assert attitude.state == "aligning"
    updated(attitude, RATE_HZ)
    assert attitude.state == "ok"


@pytest.mark.parametrize("gone", [1, 5, 6])
def test_a_short_gap_is_bridged_and_a_longer_one_is_a_fault(gone):
    """Five ticks are 0.1 s at 50 Hz; the core gets the last reading again, so it turns on at the last speed."""
    late = range(0)
    attitude = Attitude(
        CARAMELO, Script(lambda tick: ImuLate("I2C 1: stopped answering") if tick in late else noisy(tick))
    )
    attitude.open()
    updated(attitude, RATE_HZ + 1)
    late = range(RATE_HZ + 2, RATE_HZ + 2 + gone)
    known = [angles is not None for angles in updated(attitude, gone)]
    assert known == [tick < 5 for tick in range(gone)]
    assert attitude.missed == gone
    assert attitude.state == ("ok" if gone <= 5 else "fault")


def test_one_failed_transfer_of_the_mpu6050_is_only_late():
    chip = Chip()
    sensor = Mpu6050(CARAMELO, opener=chip)
    sensor.open()
    chip.fail = ("read", OSError(121, "Remote I/O error"))
    with pytest.raises(ImuLate, match="stopped answering"):
        sensor.read()


def test_a_sensor_that_is_missing_at_the_start_is_taken_when_it_comes():
    chip = Chip(fail=("open", FileNotFoundError(2, "No such file")))
    attitude = Attitude(CARAMELO, Mpu6050(CARAMELO, opener=chip))
    attitude.open()
    assert attitude.state == "fault"
    assert "no such bus" in attitude.fault
    assert updated(attitude, RATE_HZ) == [None] * RATE_HZ
    chip.fail = None
    for tick in range(2 * RATE_HZ):
        chip.block = struct.pack(">7h", 0, tick % 5, 16384, 0, 3, 4, 5)
        attitude.update()
    assert attitude.state == "ok"
    assert attitude.fault == ""


def test_recordings(tmp_path):
    path = tmp_path / "rest.csv"
    path.write_text("gyro_x,gyro_y,gyro_z,accel_x,accel_y,accel_z\n# at rest\n1,2,3,4,5,16384\n\n-1,0,0,0,0,16380\n")
    sensor = RecordedImu(path)
    sensor.open()
    assert sensor.read() == (1, 2, 3, 4, 5, 16384)
    assert sensor.read() == (-1, 0, 0, 0, 0, 16380)
    with pytest.raises(ImuError, match="the recording is over"):
        sensor.read()
    sensor.close()


@pytest.mark.parametrize("line", ["1,2,3", "1,2,3,4,5,x", "1,2,3,4,5,40000", "1,2,3,4,5,6.5"])
def test_wrong_recordings_are_refused_with_the_line(tmp_path, line):
    path = tmp_path / "bad.csv"
    path.write_text(f"1,2,3,4,5,6\n{line}\n")
    with pytest.raises(UserError, match=r"bad.csv:2: .*allowed: 6 whole numbers"):
        RecordedImu(path).open()
    with pytest.raises(UserError, match="can't be read"):
        RecordedImu(tmp_path / "none.csv").open()


def test_the_simulated_robot_feels_its_pitch():
    """The plane's body and the attitude from its sensor agree, after a push of the legs that tilts it."""
    now = [0.0]
    plant = PlanePlant(CARAMELO, seated_pose_rad(CARAMELO))
    bus = SimulatedBus(CARAMELO, lambda: now[0], plant)
    attitude = Attitude(CARAMELO, SimulatedImu(CARAMELO, plant.inertial))
    with bus:
        attitude.open()
        bus.torque(True)
        goals = list(bus.read().position_rad)
        for tick in range(8 * RATE_HZ):
            if 4 * RATE_HZ < tick < 5 * RATE_HZ:  # it lies still by then
                for joint in (1, 4):  # the front thighs swing back: the nose goes down or up
                    goals[joint] += 0.008
            bus.write(goals)
            now[0] += 1 / RATE_HZ
            bus.read()
            attitude.update()
    body_pitch = -plant.world.parts.bodies[0].angle
    assert abs(degrees(body_pitch)) > 1
    assert degrees(attitude.angles_rad[1]) == pytest.approx(degrees(body_pitch), abs=1.0)
