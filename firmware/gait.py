"""The gait controller: a board that runs the whole planner by itself.

Commands come in over a link, the inertial sensor is read, set-points go out; no Raspberry Pi. The
application knows no hardware: a board gives it a sensor with ``read(counts)`` and a stream.

* No command for 300 ms: it stops walking and stands.
* No trustworthy inertial sensor: it walks without balance at half speed, and says so.
* STOP from anywhere: it drives nothing until RESET.
"""

from shared.attitude import A_PITCH, A_ROLL, ALIGNING, attitude_step
from shared.command import (
    C_BALANCE,
    C_MODE,
    C_SPEED,
    COMMAND_SIZE,
    MODE_LIMP,
    MODE_STAND,
    MODE_WALK,
)
from shared.gaits import GAIT_NAMES
from shared.params import JOINTS, P_RATE_HZ
from shared.planner import Planner
from shared.planner_layout import (
    N_GAIT,
    N_STATE,
    S_ATTITUDE_OK,
    S_JOINTS,
    S_JOINTS_OK,
    S_PITCH,
    S_ROLL,
    SENSED_SIZE,
)
from shared.runtime import const

from . import link

STALE_MS = const(300)  # the driver's dead-man time
# Flags of the application, above the planner's
COMMAND_STALE = const(0x10000)
SENSOR_FAULT = const(0x20000)  # bits 20 .. 23: which, firmware/mpu6050.py
STOPPED = const(0x40000)
ALIGNING_NOW = const(0x80000)
_FAULT_SHIFT = const(20)


class GaitBoard:
    """The application. ``attitude`` is an attitude block (shared/attitude.py), ``sensor`` anything with read()."""

    def __init__(self, params, attitude, sensor):
        self.planner = Planner(params)
        self.attitude = attitude
        self.sensor = sensor
        self.command = link.int_block(COMMAND_SIZE)  # as received
        self.obeyed = link.int_block(COMMAND_SIZE)  # as the planner gets it
        self.sensed = link.int_block(SENSED_SIZE)
        self.counts = link.int_block(6)
        self.asked = link.int_block(6)  # what the host gets to read, apart from what the board itself plans with
        self.question = 0
        self.reader = link.Reader()
        self.writer = link.Writer()
        self.rate_hz = params[P_RATE_HZ]
        self.stale_ticks = max(1, STALE_MS * self.rate_hz // 1000)
        self.age = self.stale_ticks  # ticks since the last command
        self.ticks = 0
        self.flags = 0
        self.stopped = False

    def hello(self):
        """Build the first frame, READY, in the writer; return its length."""
        self.writer.open(link.READY)
        self.writer.put(self.rate_hz, 2)
        self.writer.put(len(GAIT_NAMES), 1)
        return self.writer.close()

    def take(self, byte):
        """Take a byte from the stream and do what a complete frame says; return its kind or 0."""
        kind = self.reader.take(byte)
        if kind == link.COMMAND:
            self._take_command()
        elif kind == link.SENSED:
            self._take_joints()
        elif kind == link.READ:
            self.question = self.reader.buffer[2]
        elif kind == link.STOP:
            self.stopped = True
        elif kind == link.RESET:
            self.stopped = False
            self.command[C_MODE] = MODE_LIMP  # what was commanded before is not obeyed after it
        return kind

    def reading(self):
        """Read the sensor for the host, build the READING frame in the writer; return its length."""
        w = self.writer
        w.open(link.READING)
        w.put(self.question, 1)
        w.put(self.sensor.read(self.asked), 1)
        for i in range(6):
            w.put(self.asked[i], 2)
        return w.close()

    def tick(self):
        """Read the sensor, plan one tick, build the SETPOINTS frame in the writer; return its length."""
        fault = self._sense()
        self._obey(fault)
        self.flags = self.planner.tick(self.obeyed, self.sensed) | self._own_flags(fault)
        self.ticks = (self.ticks + 1) & 0x3FFFFFFF
        if self.age < self.stale_ticks:
            self.age += 1
        return self._answer()

    def _take_command(self):
        if self.reader.length != 4 * COMMAND_SIZE:
            self.reader.broken += 1
            return
        for i in range(COMMAND_SIZE):
            self.command[i] = link.read_int30(self.reader.buffer, 2 + 4 * i)
        self.age = 0

    def _take_joints(self):
        if self.reader.length != 2 * JOINTS:
            self.reader.broken += 1
            return
        for joint in range(JOINTS):
            self.sensed[S_JOINTS + joint] = link.read_int16(self.reader.buffer, 2 + 2 * joint)
        self.sensed[S_JOINTS_OK] = 1

    def _sense(self):
        """Update the attitude; return the sensor's fault, 0 if it is well."""
        fault = self.sensor.read(self.counts)
        if fault:
            self.sensed[S_ATTITUDE_OK] = 0
            return fault
        aligning = attitude_step(self.attitude, self.counts) & ALIGNING
        self.sensed[S_ATTITUDE_OK] = 0 if aligning else 1
        self.sensed[S_ROLL] = self.attitude[A_ROLL]
        self.sensed[S_PITCH] = self.attitude[A_PITCH]
        return 0

    def _obey(self, fault):
        """Turn the command as received into what the planner may do now."""
        for i in range(COMMAND_SIZE):
            self.obeyed[i] = self.command[i]
        if self.stopped:
            self.obeyed[C_MODE] = MODE_LIMP
        elif self.age >= self.stale_ticks and self.obeyed[C_MODE] == MODE_WALK:
            self.obeyed[C_MODE] = MODE_STAND
        if fault:
            self.obeyed[C_BALANCE] = 0
            for axis in range(3):
                self.obeyed[C_SPEED + axis] >>= 1

    def _own_flags(self, fault):
        flags = fault << _FAULT_SHIFT
        if fault:
            flags |= SENSOR_FAULT
        elif not self.sensed[S_ATTITUDE_OK]:
            flags |= ALIGNING_NOW
        if self.age >= self.stale_ticks:
            flags |= COMMAND_STALE
        if self.stopped:
            flags |= STOPPED
        return flags

    def _answer(self):
        w = self.writer
        w.open(link.SETPOINTS)
        w.put(self.ticks, 4)
        w.put(self.flags, 4)
        w.put(self.planner.numbers[N_STATE], 1)
        w.put(self.planner.numbers[N_GAIT], 1)
        for joint in range(JOINTS):
            w.put(self.planner.joints[joint], 2)
        return w.close()
