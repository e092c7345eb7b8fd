"""The gait controller: a board that runs the whole planner by itself.

Commands come in over a link, the inertial sensor is read, set-points go out; no Raspberry Pi. The
application knows no hardware: a board gives it a sensor with ``read(counts)`` and a stream. What happens
at a stream's or the clock's pace is one hot function each, on blocks made at the start.

* No command for 300 ms: it stops walking and stands.
* No trustworthy inertial sensor: it walks without balance at half speed, and says so.
* STOP from anywhere: it drives nothing until RESET.
"""

from shared.body.axes import POSE_AXES, TWIST_AXES
from shared.body.params import JOINTS, Params
from shared.gait.gaits import GAIT_NAMES
from shared.planner.command import COMMAND_SIZE, MODE_LIMP, MODE_STAND, MODE_WALK, Command, copy_command
from shared.planner.planner import Planner, plan
from shared.planner.status import Status
from shared.record import field, record
from shared.runtime import const, hot, ptr8
from shared.sense.attitude import ALIGNING, Attitude, attitude_step
from shared.sense.sensed import PITCH, ROLL, Sensed

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
    """The application. ``attitude`` is an attitude block (shared/sense/attitude.py), ``sensor`` anything with read().

    The frames it answers with lie in ``ready``, ``setpoints`` and ``reading``, each as many bytes as are to be sent.
    """

    def __init__(self, params: Params, attitude, sensor):
        self.planner = Planner(params)
        self.sensor = sensor
        self.command = Command()  # as received
        self.sensed = Sensed()
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
        self.obeyed = Command()  # the command as the planner gets it

    def take(self, data, count):
        """Take data[:count] of the stream: see take_frames."""
        return take_frames(self.reader, self.frame, self.status, self.command, self.sensed, data, count)

    def answer(self):
        """Read the sensor for the host into the frame ``reading``."""
        write_reading(self.reading, self.status, self.sensor.read(self.asked), self.asked)

    def tick(self):
        """Read the sensor and plan one tick into the frame ``setpoints``; return the flags."""
        fault = self.sensor.read(self.counts)
        return tick(self, fault)


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
def take_command(reader: Reader, frame, status: BoardStatus, command: Command) -> None:
    """Take the payload of a COMMAND frame, unless it has another length."""
    if is_length(reader, frame, 4 * COMMAND_SIZE) == 0:
        return
    command.mode = read_int30(frame, TAKEN)
    command.gait = read_int30(frame, TAKEN + 4)
    at = TAKEN + 8
    for axis in range(TWIST_AXES):
        command.speed[axis] = read_int30(frame, at)
        at += 4
    for axis in range(POSE_AXES):
        command.pose[axis] = read_int30(frame, at)
        at += 4
    command.balance = read_int30(frame, at)
    command.height = read_int30(frame, at + 4)
    status.command_age = 0


@hot
def take_joints(reader: Reader, frame, sensed: Sensed) -> None:
    """Take the payload of a SENSED frame, unless it has another length."""
    if is_length(reader, frame, 2 * JOINTS) == 0:
        return
    read_each(frame, TAKEN, sensed.joints, 0, JOINTS)
    sensed.valid.joints = 1


@hot
def is_length(reader: Reader, frame, length: int) -> int:
    """Return 1 if the frame's payload has this length; else count it as broken and return 0."""
    f = ptr8(frame)
    if f[1] == length:
        return 1
    reader.broken = (reader.broken + 1) & _MASK
    return 0


@hot
def reset(status: BoardStatus, command: Command) -> None:
    """Drive again; what was commanded before is not obeyed after it."""
    status.stopped = 0
    command.mode = MODE_LIMP


@hot
def tick(board: GaitBoard, fault: int) -> int:
    """Plan one tick, from what the sensor counted if it has no fault; write the frame SETPOINTS; return its flags."""
    status = board.status
    sense(board.attitude, board.counts, board.sensed, fault)
    obey(board.status, board.command, board.obeyed, fault)
    flags = plan(board.planner, board.obeyed, board.sensed)
    status.flags = flags | own_flags(board.status, board.sensed, fault)
    status.tick_count = (status.tick_count + 1) & _MASK
    if status.command_age < status.stale_age:
        status.command_age += 1
    return write_setpoints(board.setpoints, board.status, board.planner.status, board.planner.joints)


@hot
def sense(attitude: Attitude, counts, sensed: Sensed, fault: int) -> None:
    """Update the attitude, if the sensor is well: the planner may use what is valid."""
    valid = sensed.valid
    valid.tilt = 0
    valid.turned = 0
    if fault:
        return
    aligning = attitude_step(attitude, counts) & ALIGNING
    if aligning == 0:
        valid.tilt = 1
        valid.turned = 1
    sensed.turned.x = attitude.turned.x
    sensed.turned.y = attitude.turned.y
    sensed.turned.z = attitude.turned.z
    sensed.tilt[ROLL] = attitude.roll
    sensed.tilt[PITCH] = attitude.pitch


@hot
def obey(status: BoardStatus, command: Command, obeyed: Command, fault: int) -> None:
    """Turn the command as received into what the planner may do now."""
    copy_command(command, obeyed)
    if status.stopped:
        obeyed.mode = MODE_LIMP
    elif status.command_age >= status.stale_age and obeyed.mode == MODE_WALK:
        obeyed.mode = MODE_STAND
    if fault:
        obeyed.balance = 0
        for axis in range(TWIST_AXES):
            obeyed.speed[axis] = command.speed[axis] >> 1


@hot
def own_flags(status: BoardStatus, sensed: Sensed, fault: int) -> int:
    """Return the application's flags."""
    flags = fault << _FAULT_SHIFT
    if fault:
        flags |= SENSOR_FAULT
    elif sensed.valid.tilt == 0:
        flags |= ALIGNING_NOW
    if status.command_age >= status.stale_age:
        flags |= COMMAND_STALE
    if status.stopped:
        flags |= STOPPED
    return flags


@hot
def write_setpoints(frame, status: BoardStatus, planned: Status, joints) -> int:
    """Write the SETPOINTS frame; return the flags in it."""
    at = put(frame, PAYLOAD, status.tick_count, 4)
    at = put(frame, at, status.flags, 4)
    at = put(frame, at, planned.state, 1)
    at = put(frame, at, planned.gait, 1)
    close_frame(frame, SETPOINTS, put_each(frame, at, joints, JOINTS, 2))
    return status.flags


@hot
def write_reading(frame, status: BoardStatus, fault: int, counts) -> None:
    """Write the READING frame."""
    at = put(frame, PAYLOAD, status.question, 1)
    at = put(frame, at, fault, 1)
    close_frame(frame, READING, put_each(frame, at, counts, _COUNTS, 2))
