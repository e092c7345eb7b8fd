"""A joint's application, hardware-free: bus, replies, status, requests; the control beside it.

The board's interrupt does a current step 10 000 times a second; ``poll`` is the main loop's body, as often as it goes:
frames that have arrived, and the motion tick when a millisecond is over. Nothing is allocated after ``start``, except
while disarmed (saving parameters).
"""

from array import array

from shared.joint.faults import FAULT_DUPLICATE_ID, FAULT_STORAGE
from shared.joint.report import report_bus, report_temperature
from shared.runtime import const
from shared.wire.codec import Fault, Heartbeat, SlowStatus, encode_fault, encode_heartbeat, encode_slow_status
from shared.wire.framing import FILTERS, joint_filters
from shared.wire.names import (
    COMMAND_REBOOT_TO_LOADER,
    FAULT_ID,
    FAULT_LENGTH,
    HEARTBEAT_ID,
    HEARTBEAT_LENGTH,
    PROTOCOL_HASH,
    SERVICE_REQUEST_ID,
    SERVICE_RESPONSE_ID,
    SERVICE_RESPONSE_LENGTH,
    SLOW_STATUS_ID,
    SLOW_STATUS_LENGTH,
)
from shared.wire.receive import FRAME_E_STOP, FRAME_REQUEST, FRAME_TWIN, FRAME_UPDATE, Link, link_reset

from .can_update import CanUpdate, build_number
from .joint_bus import (
    FOUND_SHIFT,
    FRAMES_MOST,
    SESSION_OVER,
    TELL_FAULT,
    TELL_HEARTBEAT,
    TELL_STATUS,
    Told,
    what_to_tell,
)
from .joint_control import Control
from .joint_run import PART_BUS
from .joint_service import ANSWER, ANSWER_LATER, Service
from .joint_store import BROKEN, Parameters

_IDENTIFIER = const(0x7FF)
_MS_US = const(1000)
_AHEAD = const(0x20000000)  # a time is still to come if it is less than half the clock's range before now
_MASK = const(0x3FFFFFFF)
_TO_NEXT_US = const(0x3FFFFC18)  # 2^30 less a millisecond, taken off: a sum beyond 2^30 would take memory


class Joint:
    """One joint on its board; its parameters are kept in ``journal`` (settings.py).

    ``update``: the board's slots (update.py); without it the joint has no firmware of its own to be updated.
    """

    def __init__(self, board, journal, update=None):
        self.board = board
        self.build = build_number(update.header(update.running)) if update else 0
        self.control = Control(board)
        self.parameters = Parameters(self.control, journal)
        self.loaded = self.parameters.load()
        self.link = Link()
        self.service = Service(self, self.link, self.control, self.parameters, board.unique_id())
        self._frame = array("H", [0] * 4)
        self._out = array("H", [0] * 4)
        self._filters = array("H", [0] * (2 * FILTERS))
        self._status = SlowStatus()
        self._heartbeat = Heartbeat()
        self._fault = Fault()
        self._due_us = 0
        self._told = Told()
        self._told.drive_state = -1
        self._bus = board.listen(self.control, self.link, self._frame, self._out)
        self._discover_ms = -1
        self.updating = CanUpdate(self, update)
        self.set_node(self.parameters.node)

    def start(self):
        """Set the hardware up and start the interrupt; from here on ``poll`` has to be called."""
        self.control.start()
        now = self.board.ticks_us()  # what the set-up took is not made up for: no step was in it
        self._due_us = (now - now % _MS_US + _MS_US) & _MASK
        if self.loaded == BROKEN:
            self.control.raise_fault(FAULT_STORAGE, 0)

    def set_node(self, node):
        """Become node 0 .. 12: link, hardware filters, and when its status is due, so that joints take turns."""
        self.parameters.node = node
        link_reset(self.link, node)
        self.board.can_filters(self._filters, joint_filters(self._filters, node))
        self._told.status_ms = node * 16

    def poll(self):
        """Do what is due; return 1 if a motion tick was done."""
        updating = self.updating
        if updating.state:
            updating.poll()
            return 0
        try:
            self._take_frames()
        except Exception:
            self.control.stop(PART_BUS)
        if updating.state or (self.board.ticks_us() - self._due_us) & _MASK >= _AHEAD:
            return 0
        self._due_us = (self._due_us - _TO_NEXT_US) & _MASK
        self.control.motion()
        try:
            self._after_motion()
        except Exception:
            self.control.stop(PART_BUS)
        return 1

    def _take_frames(self):
        for _ in range(FRAMES_MOST):
            left = self._bus()
            if left < 0:
                return
            found = left >> FOUND_SHIFT
            if found == FRAME_E_STOP:
                self.control.emergency_stop()
            elif found == FRAME_REQUEST:
                self._serve(left & _IDENTIFIER)
            elif found == FRAME_UPDATE:
                self.updating.take(self._frame)
                if self.updating.state:
                    return
            elif found == FRAME_TWIN:
                self.control.raise_fault(FAULT_DUPLICATE_ID, self.parameters.node)

    def _serve(self, identifier):
        answer = self.service.take(self._frame, identifier == SERVICE_REQUEST_ID)
        if answer == ANSWER:
            self.send(SERVICE_RESPONSE_ID + self.parameters.node, self.service.frame, SERVICE_RESPONSE_LENGTH)
        elif answer == ANSWER_LATER:
            self._discover_ms = self.service.discover_ms

    def _after_motion(self):
        tell = what_to_tell(self._told, self.link, self.control.state, self.control.io)
        if tell:
            self._tell(tell)
        if self._discover_ms >= 0:
            self._send_discover()
        if self.service.reboot:
            self.board.pwm_off()
            self.board.reset(self.service.reboot == COMMAND_REBOOT_TO_LOADER)

    def _send_discover(self):
        if self._discover_ms == 0:
            self.send(SERVICE_RESPONSE_ID + self.parameters.node, self.service.frame, SERVICE_RESPONSE_LENGTH)
        self._discover_ms -= 1

    def _tell(self, tell):
        """Send what is due; a joint without an id has nothing to tell but its heartbeat."""
        if tell & SESSION_OVER:
            self.service.renew_challenge()
        if tell & TELL_HEARTBEAT:
            self.send_heartbeat()
        if self.parameters.node:
            if tell & TELL_STATUS:
                self._send_slow_status()
            if tell & TELL_FAULT:
                self._send_fault()

    def send_heartbeat(self):
        """Tell state and identity."""
        h = self._heartbeat
        state = self.control.state
        h.state = state.drive_state
        h.mode = state.mode
        h.fault = state.fault_code
        h.protocol_hash = PROTOCOL_HASH
        h.session = self.control.io.session
        h.build = self.build
        encode_heartbeat(self._out, h)
        self.send(HEARTBEAT_ID + self.parameters.node, self._out, HEARTBEAT_LENGTH)

    def _send_slow_status(self):
        s = self._status
        state = self.control.state
        s.winding_temperature = report_temperature(state.winding)
        s.mcu_temperature = report_temperature(state.mcu)
        s.bus_voltage = report_bus(self.control.settings, state)
        s.limits = state.limits
        s.lost_sync = self.link.lost_syncs & 0xFF
        s.overruns = self.control.run.late_steps & 0xFF
        encode_slow_status(self._out, s)
        self.send(SLOW_STATUS_ID + self.parameters.node, self._out, SLOW_STATUS_LENGTH)

    def _send_fault(self):
        state = self.control.state
        self._fault.code = state.fault_code
        self._fault.value = state.fault_value
        self._fault.tick = state.fault_tick
        encode_fault(self._out, self._fault)
        self.send(FAULT_ID + self.parameters.node, self._out, FAULT_LENGTH)

    def send(self, identifier, frame, length):
        """Send a frame and return 1; one that finds no room is counted: 0."""
        sent = self.board.can_send(identifier, frame, length)
        if sent == 0:
            self.control.run.unsent_frames = (self.control.run.unsent_frames + 1) & _MASK
        return sent
