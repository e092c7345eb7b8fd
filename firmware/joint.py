"""A joint's application, hardware-free: bus, set-points, replies, status, requests, session; the control beside it.

The board calls ``control.step`` 10 000 times a second; ``poll`` is the main loop's body, as often as it goes: frames
that have arrived, and the motion tick when a millisecond is over. Nothing is allocated after ``start``, except while
disarmed (saving parameters).
"""

from array import array

from shared.joint.faults import FAULT_DUPLICATE_ID, FAULT_STORAGE
from shared.joint.layout import (
    IO_CURRENT,
    IO_DAMPING,
    IO_HASH_OK,
    IO_MODE,
    IO_POSITION,
    IO_SEQUENCE,
    IO_SESSION,
    IO_STIFFNESS,
    IO_VELOCITY,
    S_DRIVE,
    S_FAULT_CODE,
    S_FAULT_TICK,
    S_FAULT_VALUE,
    S_HOMED,
    S_LIMITS,
    S_MCU,
    S_MODE,
    S_WINDING,
)
from shared.joint.report import report_bus, report_current, report_position, report_temperature, report_velocity
from shared.runtime import const
from shared.wire.codec import encode_fault, encode_heartbeat, encode_reply, encode_slow_status
from shared.wire.framing import FILTERS, joint_filters
from shared.wire.names import (
    COMMAND_REBOOT_TO_LOADER,
    FAULT_CODE,
    FAULT_FIELDS,
    FAULT_ID,
    FAULT_LENGTH,
    FAULT_TICK,
    FAULT_VALUE,
    HEARTBEAT_FAULT,
    HEARTBEAT_FIELDS,
    HEARTBEAT_FIRMWARE_MAJOR,
    HEARTBEAT_FIRMWARE_MINOR,
    HEARTBEAT_FIRMWARE_PATCH,
    HEARTBEAT_ID,
    HEARTBEAT_LENGTH,
    HEARTBEAT_MODE,
    HEARTBEAT_PROTOCOL_HASH,
    HEARTBEAT_SESSION,
    HEARTBEAT_STATE,
    NOT_AVAILABLE,
    PROTOCOL_HASH,
    REPLY_CURRENT,
    REPLY_FIELDS,
    REPLY_ID,
    REPLY_LENGTH,
    REPLY_POSITION,
    REPLY_VELOCITY,
    SERVICE_REQUEST_ID,
    SERVICE_RESPONSE_ID,
    SERVICE_RESPONSE_LENGTH,
    SLOW_STATUS_BUS_VOLTAGE,
    SLOW_STATUS_FIELDS,
    SLOW_STATUS_ID,
    SLOW_STATUS_LENGTH,
    SLOW_STATUS_LIMITS,
    SLOW_STATUS_LOST_SYNC,
    SLOW_STATUS_MCU_TEMPERATURE,
    SLOW_STATUS_OVERRUNS,
    SLOW_STATUS_WINDING_TEMPERATURE,
    STATE_FAULT,
    STATE_SWITCH_ON_DISABLED,
)
from shared.wire.receive import (
    FRAME_BAD,
    FRAME_E_STOP,
    FRAME_REQUEST,
    FRAME_SYNC,
    FRAME_SYNC_SETPOINT,
    FRAME_TWIN,
    KIND_CURRENT,
    KIND_CURRENT_FEEDFORWARD,
    KIND_DAMPING,
    KIND_STIFFNESS,
    KIND_VELOCITY,
    KIND_VELOCITY_FEEDFORWARD,
    LINK_LATCHED,
    LINK_LOST,
    LINK_MODE,
    LINK_SIZE,
    accept_frame,
    end_session,
    link_reset,
)

from .joint_control import PART_BUS, Control
from .joint_service import ANSWER, ANSWER_LATER, Service
from .joint_store import BROKEN, Parameters

VERSION = (0, 1, 0)  # major, minor, patch
_STATUS_MS = const(200)  # heartbeat and slow status, five times a second
_FAULT_MS = const(1000)  # a latched fault is told again
_FRAMES_MOST = const(8)  # taken in one go, so that a flooded bus cannot hold up the motion tick
_MASK = const(0x3FFFFFFF)


class Joint:
    """One joint on its board; ``parameter_file`` is where its parameters are kept."""

    def __init__(self, board, parameter_file="joint.bin"):
        self.board = board
        self.control = Control(board)
        self.parameters = Parameters(self.control, parameter_file)
        self.loaded = self.parameters.load()
        self.link = array("i", [0] * LINK_SIZE)
        self.service = Service(self, self.control, self.parameters, board.unique_id())
        self.send_failures = 0
        self._frame = array("H", [0] * 4)
        self._out = array("H", [0] * 4)
        self._filters = array("H", [0] * (2 * FILTERS))
        self._reply = array("i", [0] * REPLY_FIELDS)
        self._status = array("i", [0] * SLOW_STATUS_FIELDS)
        self._heartbeat = array("i", [0] * HEARTBEAT_FIELDS)
        self._fault = array("i", [0] * FAULT_FIELDS)
        self._version = array("i", VERSION)
        self._ms = board.ticks_ms()
        self._told_state = -1
        self._told_fault = 0
        self._discover_ms = -1
        self._status_ms = 0
        self._fault_ms = 0
        self._fed_steps = -1
        self.set_node(self.parameters.node)

    def start(self):
        """Set the hardware up and start the interrupt; from here on ``poll`` has to be called."""
        self.control.start()
        if self.loaded == BROKEN:
            self.control.raise_fault(FAULT_STORAGE, 0)
        self.board.start(self.control.step)

    def set_node(self, node):
        """Become node 0 .. 12: link, hardware filters, and when its status is due, so that joints take turns."""
        self.parameters.node = node
        link_reset(self.link, node)
        self.board.can_filters(self._filters, joint_filters(self._filters, node))
        self._status_ms = node * 16

    def poll(self):
        """Do what is due; return 1 if a motion tick was done."""
        try:
            self._take_frames()
        except Exception:
            self.control.stop(PART_BUS)
        if ((self.board.ticks_ms() - self._ms) & _MASK) == 0:
            return 0
        self._ms = (self._ms + 1) & _MASK
        self.control.motion()
        try:
            self._after_motion()
        except Exception:
            self.control.stop(PART_BUS)
        return 1

    def _take_frames(self):
        for _ in range(_FRAMES_MOST):
            identifier = self.board.can_receive(self._frame)
            if identifier < 0:
                return
            self._take(identifier, self.board.can_length)

    def _take(self, identifier, length):
        found = accept_frame(self.link, identifier, self._frame, length)
        if found == FRAME_SYNC_SETPOINT:
            self._use_setpoint()
            self._send_reply()
        elif found == FRAME_SYNC:
            self._send_reply()
        elif found == FRAME_E_STOP:
            self.control.emergency_stop()
        elif found == FRAME_REQUEST:
            self._serve(identifier)
        elif found == FRAME_TWIN:
            self.control.raise_fault(FAULT_DUPLICATE_ID, self.parameters.node)
        elif found == FRAME_BAD:
            return

    def _serve(self, identifier):
        answer = self.service.take(self._frame, identifier == SERVICE_REQUEST_ID)
        if answer == ANSWER:
            self._send(SERVICE_RESPONSE_ID + self.parameters.node, self.service.frame, SERVICE_RESPONSE_LENGTH)
        elif answer == ANSWER_LATER:
            self._discover_ms = self.service.discover_ms

    def _use_setpoint(self):
        """Copy the latched set-point to where the control reads it; only this feeds the watchdog."""
        io = self.control.io
        link = self.link
        mode = link[LINK_MODE]
        velocity = KIND_VELOCITY if mode == KIND_VELOCITY + 1 else KIND_VELOCITY_FEEDFORWARD
        current = KIND_CURRENT if mode == KIND_CURRENT + 1 else KIND_CURRENT_FEEDFORWARD
        io[IO_MODE] = mode
        io[IO_POSITION] = link[LINK_LATCHED + mode - 1]
        io[IO_VELOCITY] = link[LINK_LATCHED + velocity]
        io[IO_CURRENT] = link[LINK_LATCHED + current]
        io[IO_STIFFNESS] = link[LINK_LATCHED + KIND_STIFFNESS]
        io[IO_DAMPING] = link[LINK_LATCHED + KIND_DAMPING]
        io[IO_SEQUENCE] = (io[IO_SEQUENCE] + 1) & _MASK

    def _after_motion(self):
        self._end_session_when_disarmed()
        self._send_discover()
        self._status_ms += 1
        state = self.control.state[S_DRIVE]
        if state != self._told_state or self._status_ms >= _STATUS_MS:
            self._send_heartbeat()
            self._told_state = state
        if self._status_ms >= _STATUS_MS:
            self._status_ms = 0
            self._send_slow_status()
        self._tell_fault()
        if self.control.steps != self._fed_steps:
            self._fed_steps = self.control.steps
            self.board.feed_watchdog()
        if self.service.reboot:
            self.board.pwm_off()
            self.board.reset(self.service.reboot == COMMAND_REBOOT_TO_LOADER)

    def _end_session_when_disarmed(self):
        """A session lasts from arming to the end of torque; afterwards every set-point is forgotten."""
        io = self.control.io
        state = self.control.state[S_DRIVE]
        if io[IO_SESSION] and self.control.armed() == 0 and (state == STATE_FAULT or state == STATE_SWITCH_ON_DISABLED):
            end_session(self.link)
            io[IO_SESSION] = 0
            io[IO_HASH_OK] = 0
            io[IO_MODE] = 0

    def _send_discover(self):
        if self._discover_ms >= 0:
            if self._discover_ms == 0:
                self._send(SERVICE_RESPONSE_ID + self.parameters.node, self.service.frame, SERVICE_RESPONSE_LENGTH)
            self._discover_ms -= 1

    def _send_reply(self):
        if self.parameters.node == 0:
            return
        c = self.control
        self._reply[REPLY_POSITION] = report_position(c.cfg, c.state) if c.state[S_HOMED] else NOT_AVAILABLE
        self._reply[REPLY_VELOCITY] = report_velocity(c.cfg, c.state)
        self._reply[REPLY_CURRENT] = report_current(c.foc, c.cfg)
        encode_reply(self._out, self._reply, 0)
        self._send(REPLY_ID + self.parameters.node, self._out, REPLY_LENGTH)

    def _send_heartbeat(self):
        h = self._heartbeat
        state = self.control.state
        h[HEARTBEAT_STATE] = state[S_DRIVE]
        h[HEARTBEAT_MODE] = state[S_MODE]
        h[HEARTBEAT_FAULT] = state[S_FAULT_CODE]
        h[HEARTBEAT_PROTOCOL_HASH] = PROTOCOL_HASH
        h[HEARTBEAT_SESSION] = self.control.io[IO_SESSION]
        h[HEARTBEAT_FIRMWARE_MAJOR] = self._version[0]
        h[HEARTBEAT_FIRMWARE_MINOR] = self._version[1]
        h[HEARTBEAT_FIRMWARE_PATCH] = self._version[2]
        encode_heartbeat(self._out, h, 0)
        self._send(HEARTBEAT_ID + self.parameters.node, self._out, HEARTBEAT_LENGTH)

    def _send_slow_status(self):
        if self.parameters.node == 0:
            return
        s = self._status
        state = self.control.state
        s[SLOW_STATUS_WINDING_TEMPERATURE] = report_temperature(state[S_WINDING])
        s[SLOW_STATUS_MCU_TEMPERATURE] = report_temperature(state[S_MCU])
        s[SLOW_STATUS_BUS_VOLTAGE] = report_bus(self.control.cfg, state)
        s[SLOW_STATUS_LIMITS] = state[S_LIMITS]
        s[SLOW_STATUS_LOST_SYNC] = self.link[LINK_LOST] & 0xFF
        s[SLOW_STATUS_OVERRUNS] = self.control.late & 0xFF
        encode_slow_status(self._out, s, 0)
        self._send(SLOW_STATUS_ID + self.parameters.node, self._out, SLOW_STATUS_LENGTH)

    def _tell_fault(self):
        """Send the fault record when a fault latches, and once a second while it is latched."""
        state = self.control.state
        code = state[S_FAULT_CODE]
        self._fault_ms += 1
        if code and self.parameters.node and (code != self._told_fault or self._fault_ms >= _FAULT_MS):
            self._fault_ms = 0
            self._fault[FAULT_CODE] = code
            self._fault[FAULT_VALUE] = state[S_FAULT_VALUE]
            self._fault[FAULT_TICK] = state[S_FAULT_TICK]
            encode_fault(self._out, self._fault, 0)
            self._send(FAULT_ID + self.parameters.node, self._out, FAULT_LENGTH)
        self._told_fault = code

    def _send(self, identifier, frame, length):
        if self.board.can_send(identifier, frame, length) == 0:
            self.send_failures = (self.send_failures + 1) & _MASK
