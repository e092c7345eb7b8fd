"""The gait controller: a board that runs the whole planner by itself.

Commands come in over a link, the inertial sensor is read, set-points go out; no Raspberry Pi. The
application knows no hardware: a board gives it a sensor with ``read(counts)`` and a stream. What happens
at a stream's or the clock's pace is one hot function each, on blocks made at the start.

* No command for 300 ms: it stops walking and stands.
* No trustworthy inertial sensor: it walks without balance at half speed, and says so.
* STOP from anywhere: it drives nothing until RESET.
"""

from shared.attitude import A_PITCH, A_ROLL, ALIGNING, attitude_step
from shared.command import C_BALANCE, C_MODE, C_SPEED, COMMAND_SIZE, MODE_LIMP, MODE_STAND, MODE_WALK
from shared.gaits import GAIT_NAMES
from shared.params import JOINTS, Params
from shared.planner import Planner, plan
from shared.planner_layout import N_GAIT, N_STATE, S_ATTITUDE_OK, S_JOINTS, S_JOINTS_OK, S_PITCH, S_ROLL, SENSED_SIZE
from shared.record import field, record
from shared.runtime import Ints, const, hot, ptr8

from .link import (
    COMMAND,
    PAYLOAD,
    READ,
    READER_BYTES,
    READING,
    READY,
    RESET,
    SENSED,
    SETPOINTS,
    STOP,
    TAKEN,
    Reader,
    close_frame,
    int_block,
    next_frame,
    put,
    put_each,
    read_each,
    read_int30,
)

STALE_MS = const(300)  # the driver's dead-man time
# Flags of the application, above the planner's
COMMAND_STALE = const(0x10000)
SENSOR_FAULT = const(0x20000)  # bits 20 .. 23: which, firmware/mpu6050.py
STOPPED = const(0x40000)
ALIGNING_NOW = const(0x80000)
_FAULT_SHIFT = const(20)

SETPOINTS_BYTES = const(40)  # whole frames: link.OVERHEAD and what link.py says is in them
READING_BYTES = const(20)
READY_BYTES = const(9)
_COUNTS = const(6)
_MASK = const(0x3FFFFFFF)


@record
class BoardStatus:
    """What the board knows of its commands and ticks."""

    command_age: int = field("ticks", "since the last command, up to stale_age")
    stale_age: int = field("ticks", "the age from which on a command is stale")
    tick_count: int = field("", "ticks planned, modulo 2^30")
    flags: int = field("", "of the last tick: the planner's and the application's")
    stopped: int = field("", "1: from STOP until RESET")
    question: int = field("", "number of the last READ")


class GaitBoard:
    """The application. ``attitude`` is an attitude block (shared/attitude.py), ``sensor`` anything with read().

    The frames it answers with lie in ``ready``, ``setpoints`` and ``reading``, each as many bytes as are to be sent.
    """

    def __init__(self, params: Params, attitude, sensor):
        self.planner = Planner(params)
        self.sensor = sensor
        self.command = int_block(COMMAND_SIZE)  # as received
        self.sensed = int_block(SENSED_SIZE)
        self.counts = int_block(_COUNTS)
        self.asked = int_block(_COUNTS)  # what the host gets to read, apart from what the board itself plans with
        self.reader = Reader()
        self.frame = bytearray(READER_BYTES)  # as received
        self.setpoints = bytearray(SETPOINTS_BYTES)
        self.reading = bytearray(READING_BYTES)
        self.ready = bytearray(READY_BYTES)
        self.rate_hz = params.rate_hz
        self.status = BoardStatus()
        self.status.stale_age = self.status.command_age = max(1, STALE_MS * self.rate_hz // 1000)
        at = put(self.ready, put(self.ready, PAYLOAD, self.rate_hz, 2), len(GAIT_NAMES), 1)
        close_frame(self.ready, READY, at)
        self.attitude = attitude
        self.obeyed = int_block(COMMAND_SIZE)  # the command as the planner gets it

    def take(self, data, count):
        """Take data[:count] of the stream: see take_frames."""
        return take_frames(self.reader, self.frame, self.status, self.command, self.sensed, data, count)

    def answer(self):
        """Read the sensor for the host into the frame ``reading``."""
        write_reading(self.reading, self.status, self.sensor.read(self.asked), self.asked)

    def tick(self):
        """Read the sensor and plan one tick into the frame ``setpoints``; return the flags."""
        fault = self.sensor.read(self.counts)
        return tick(self, self.planner, self.status, self.command, self.obeyed, self.sensed, fault)


@hot
def take_frames(reader: Reader, frame, status: BoardStatus, command, sensed, data, count: int) -> int:
    """Take data[:count] and do what complete frames say; return the kind of one that is left to the caller, else 0.

    After a kind that is not 0, call again with the same data: it goes on behind that frame (link.next_frame).
    """
    f = ptr8(frame)
    kind = next_frame(reader, frame, data, count)
    while kind:
        if kind == COMMAND:
            take_command(reader, frame, status, command)
        elif kind == SENSED:
            take_joints(reader, frame, sensed)
        elif kind == STOP:
            status.stopped = 1
        elif kind == RESET:
            reset(status, command)
        else:
            if kind == READ:
                status.question = f[TAKEN]
            return kind
        kind = next_frame(reader, frame, data, count)
    return 0


@hot
def take_command(reader: Reader, frame, status: BoardStatus, command: Ints) -> int:
    """Take the payload of a COMMAND frame; return 1, or 0 if it has another length."""
    if is_length(reader, frame, 4 * COMMAND_SIZE) == 0:
        return 0
    for i in range(COMMAND_SIZE):
        command[i] = read_int30(frame, TAKEN + 4 * i)
    status.command_age = 0
    return 1


@hot
def take_joints(reader: Reader, frame, sensed: Ints) -> int:
    """Take the payload of a SENSED frame; return 1, or 0 if it has another length."""
    if is_length(reader, frame, 2 * JOINTS) == 0:
        return 0
    read_each(frame, TAKEN, sensed, S_JOINTS, JOINTS)
    sensed[S_JOINTS_OK] = 1
    return 1


@hot
def is_length(reader: Reader, frame, length: int) -> int:
    """Return 1 if the frame's payload has this length; else count it as broken and return 0."""
    f = ptr8(frame)
    if f[1] == length:
        return 1
    reader.broken = (reader.broken + 1) & _MASK
    return 0


@hot
def reset(status: BoardStatus, command: Ints) -> int:
    """Drive again; what was commanded before is not obeyed after it. Return 0."""
    status.stopped = 0
    command[C_MODE] = MODE_LIMP
    return 0


@hot
def tick(board, planner, status: BoardStatus, command, obeyed, sensed, fault: int) -> int:
    """Plan one tick, from what the sensor counted if it has no fault; write the frame SETPOINTS; return its flags."""
    sense(board.attitude, board.counts, sensed, fault)
    obey(status, command, obeyed, fault)
    flags = plan(planner, obeyed, sensed)
    status.flags = flags | own_flags(status, sensed, fault)
    status.tick_count = (status.tick_count + 1) & _MASK
    if status.command_age < status.stale_age:
        status.command_age += 1
    return write_setpoints(board.setpoints, status, planner.numbers, planner.joints)


@hot
def sense(attitude: Ints, counts, sensed: Ints, fault: int) -> int:
    """Update the attitude, if the sensor is well; return 1 if the planner may use it."""
    sensed[S_ATTITUDE_OK] = 0
    if fault:
        return 0
    aligning = attitude_step(attitude, counts) & ALIGNING
    if aligning == 0:
        sensed[S_ATTITUDE_OK] = 1
    sensed[S_ROLL] = attitude[A_ROLL]
    sensed[S_PITCH] = attitude[A_PITCH]
    return sensed[S_ATTITUDE_OK]


@hot
def obey(status: BoardStatus, command: Ints, obeyed: Ints, fault: int) -> int:
    """Turn the command as received into what the planner may do now; return its mode."""
    for i in range(COMMAND_SIZE):
        obeyed[i] = command[i]
    if status.stopped:
        obeyed[C_MODE] = MODE_LIMP
    elif status.command_age >= status.stale_age and obeyed[C_MODE] == MODE_WALK:
        obeyed[C_MODE] = MODE_STAND
    if fault:
        obeyed[C_BALANCE] = 0
        for axis in range(3):
            obeyed[C_SPEED + axis] = command[C_SPEED + axis] >> 1
    return obeyed[C_MODE]


@hot
def own_flags(status: BoardStatus, sensed: Ints, fault: int) -> int:
    """Return the application's flags."""
    flags = fault << _FAULT_SHIFT
    if fault:
        flags |= SENSOR_FAULT
    elif sensed[S_ATTITUDE_OK] == 0:
        flags |= ALIGNING_NOW
    if status.command_age >= status.stale_age:
        flags |= COMMAND_STALE
    if status.stopped:
        flags |= STOPPED
    return flags


@hot
def write_setpoints(frame, status: BoardStatus, planned: Ints, joints) -> int:
    """Write the SETPOINTS frame; return the flags in it."""
    at = put(frame, PAYLOAD, status.tick_count, 4)
    at = put(frame, at, status.flags, 4)
    at = put(frame, at, planned[N_STATE], 1)
    at = put(frame, at, planned[N_GAIT], 1)
    close_frame(frame, SETPOINTS, put_each(frame, at, joints, JOINTS, 2))
    return status.flags


@hot
def write_reading(frame, status: BoardStatus, fault: int, counts) -> int:
    """Write the READING frame; return its length."""
    at = put(frame, PAYLOAD, status.question, 1)
    at = put(frame, at, fault, 1)
    return close_frame(frame, READING, put_each(frame, at, counts, _COUNTS, 2))
