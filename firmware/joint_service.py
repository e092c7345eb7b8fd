"""Service requests to a joint: discover, set id, arm, disarm, clear, parameters, commission, home, reboot.

A request repeated bit by bit is answered again and not done again. To all nodes only discover, set_id and
reboot_to_loader are obeyed; the last two carry the board's number, and a board with another one stays silent.
A request that arms, commissions or homes carries the joint's challenge, which the host reads before: old frames played
again do none of it.
"""

from array import array

from shared.joint.cascade import position_from_wire
from shared.joint.commission_state import COMMISSION_FULL, COMMISSION_VERIFY
from shared.joint.drive_state import drive_arm, drive_clear, drive_disarm, drive_quick_stop
from shared.joint.encoder import home_at, home_by_encoder
from shared.joint.tick import begin_commission
from shared.runtime import const
from shared.wire.access import is_stored, may_read, may_write
from shared.wire.codec import ServiceRequest, ServiceResponse, decode_service_request, encode_service_response
from shared.wire.framing import NODES
from shared.wire.identity import board_id, discover_delay_ms
from shared.wire.names import (
    COMMAND_ARM,
    COMMAND_CLEAR_FAULT,
    COMMAND_COMMISSION,
    COMMAND_DISARM,
    COMMAND_DISCOVER,
    COMMAND_HOME,
    COMMAND_QUICK_STOP,
    COMMAND_READ_PARAMETER,
    COMMAND_REBOOT,
    COMMAND_REBOOT_TO_LOADER,
    COMMAND_RESTORE_DEFAULTS,
    COMMAND_SAVE_PARAMETERS,
    COMMAND_SET_ID,
    COMMAND_WRITE_PARAMETER,
    MODE_COMMISSIONING,
    MODE_HOMING,
    MODE_OFF,
    NOT_AVAILABLE,
    PROTOCOL_HASH,
    RESULT_NEEDS_DISARMED,
    RESULT_NOT_COMMISSIONED,
    RESULT_NOT_HOMED,
    RESULT_OK,
    RESULT_OUT_OF_RANGE,
    RESULT_STORAGE_FAILED,
    RESULT_UNKNOWN_COMMAND,
    RESULT_WRONG_CHALLENGE,
    RESULT_WRONG_KEY,
    RESULT_WRONG_STATE,
)
from shared.wire.parameters import (
    PARAMETER_BACKLASH,
    PARAMETER_BAD_FRAMES,
    PARAMETER_BUILD_ID,
    PARAMETER_BUS_OFF,
    PARAMETER_CHALLENGE,
    PARAMETER_COULOMB,
    PARAMETER_FAULT_CODE,
    PARAMETER_FAULT_TICK,
    PARAMETER_FAULT_VALUE,
    PARAMETER_FRICTION_LAG,
    PARAMETER_INDUCTANCE_D,
    PARAMETER_INDUCTANCE_Q,
    PARAMETER_LOST_SYNC,
    PARAMETER_OVERRUNS,
    PARAMETER_RESET_CAUSE,
    PARAMETER_RESISTANCE,
    PARAMETER_SEND_FAILURES,
    PARAMETER_UNIQUE_ID_0,
    PARAMETER_UNIQUE_ID_3,
    PARAMETER_UPTIME,
    PARAMETER_VELOCITY_W_FOUND,
    PARAMETER_VISCOUS,
)
from shared.wire.receive import Link, start_session

from .joint_control import Control
from .joint_store import Parameters

# Value of arm, commission and home: the challenge above 16 bits of their own
_CHALLENGE_SHIFT = const(16)
_LOW_BITS = const(0xFFFF)
_CHALLENGE_BITS = const(0x3FFF)

# Index of a home request
HOME_ENCODER = const(0)  # by the joint encoder
HOME_POSE = const(1)  # the joint stands at value, brad
HOME_STOP = const(2)  # look for the stop; needs a session as arming does
# Index of a commission request: COMMISSION_FULL, COMMISSION_VERIFY; with this bit value is the joint's angle now, brad
COMMISSION_AT_POSE = const(16)

SILENT = const(-1)  # no answer
ANSWER = const(0)
ANSWER_LATER = const(1)  # after discover_ms


class Service:
    """Answers requests; ``frame`` holds the answer. ``joint`` is firmware/joint.py."""

    def __init__(self, joint, link: Link, control: Control, parameters: Parameters, unique_id):
        self._joint = joint
        self._link = link
        self._control = control
        self._parameters = parameters
        self.board = board_id(unique_id)
        self._unique = array("i", [_three_bytes(unique_id, 3 * i) for i in range(4)])
        self._request = ServiceRequest()
        self._response = ServiceResponse()
        self.frame = array("H", [0] * 4)
        self._last = array("H", [0] * 4)
        self._answered = False
        self.discover_ms = 0
        self.challenge = 0
        self.renew_challenge()
        self.reboot = 0  # COMMAND_REBOOT or COMMAND_REBOOT_TO_LOADER once one was accepted

    def renew_challenge(self):
        """Have the next request carry another number than the last: after power-on, arming and the end of torque."""
        drawn = self._control.board.random() & _CHALLENGE_BITS
        if drawn == self.challenge:
            drawn = (drawn + 1) & _CHALLENGE_BITS
        self.challenge = drawn

    def take(self, frame, to_all):
        """Do what a request frame says; return SILENT, ANSWER or ANSWER_LATER."""
        r = self._request
        if decode_service_request(frame, r):
            return SILENT
        command = r.command
        if to_all and not self._is_for_all(command):
            return SILENT
        if not (self._answered and self._is_repeated(frame)):
            for word in range(4):
                self._last[word] = frame[word]
            self._answered = True
            self._answer(command, self._do(command))
        if command == COMMAND_DISCOVER:
            self.discover_ms = discover_delay_ms(self.board, r.sequence)
            return ANSWER_LATER
        return ANSWER

    def _is_for_all(self, command):
        if command == COMMAND_DISCOVER:
            return True
        if command == COMMAND_SET_ID or command == COMMAND_REBOOT_TO_LOADER:
            return self._request.value == self.board
        return False

    def _is_repeated(self, frame):
        differences = 0
        for word in range(4):
            differences |= frame[word] ^ self._last[word]
        return differences == 0

    def _answer(self, command, result):
        response = self._response
        response.command = command
        response.sequence = self._request.sequence
        response.result = result
        encode_service_response(self.frame, response)

    def _do(self, command):
        """Do one request; return RESULT_*. The answer's index and value are the request's unless set here."""
        r = self._request
        index = r.index
        value = r.value
        self._response.index = index
        self._response.value = value
        if command == COMMAND_DISCOVER:
            self._response.index = self._parameters.node
            self._response.value = self.board
            return RESULT_OK
        if command == COMMAND_READ_PARAMETER:
            return self._read(index)
        if command == COMMAND_WRITE_PARAMETER:
            return self._write(index, value)
        if command == COMMAND_DISARM:
            return drive_disarm(self._control.state)
        if command == COMMAND_CLEAR_FAULT:
            return drive_clear(self._control.state)
        if command == COMMAND_QUICK_STOP:
            return drive_quick_stop(self._control.state)
        if command == COMMAND_ARM or command == COMMAND_COMMISSION or command == COMMAND_HOME:
            return self._do_challenged(command, index, value)
        return self._do_disarmed(command, index, value)

    def _do_challenged(self, command, index, value):
        """Do what carries the challenge, and pass on what stands below it."""
        if command != COMMAND_ARM and self._control.armed():
            return RESULT_NEEDS_DISARMED
        if value >> _CHALLENGE_SHIFT != self.challenge:
            return RESULT_WRONG_CHALLENGE
        low = value & _LOW_BITS
        if command == COMMAND_ARM:
            return self._arm(MODE_OFF, low)
        if command == COMMAND_COMMISSION:
            return self._commission(index, low)
        return self._home(index, low)

    def _do_disarmed(self, command, index, value):
        if self._control.armed():
            return RESULT_NEEDS_DISARMED
        if command == COMMAND_SET_ID:
            return self._set_id(index, value)
        if command == COMMAND_SAVE_PARAMETERS:
            return RESULT_OK if self._parameters.save() else RESULT_STORAGE_FAILED
        if command == COMMAND_RESTORE_DEFAULTS:
            self._parameters.defaults()
            return RESULT_OK
        if command == COMMAND_REBOOT:
            self.reboot = command
            return RESULT_OK
        if command == COMMAND_REBOOT_TO_LOADER:
            if value != self.board:
                return RESULT_WRONG_KEY
            self.reboot = command
            return RESULT_OK
        return RESULT_UNKNOWN_COMMAND

    def _arm(self, purpose, found_hash):
        """Ask the states for torque in the session of the request; nothing of it stays when refused."""
        io = self._control.io
        session = self._request.session
        if self._control.armed():
            return RESULT_WRONG_STATE
        io.hash_ok = 1 if found_hash == PROTOCOL_HASH else 0
        io.session = session
        result = drive_arm(self._control.settings, self._control.state, io, purpose)
        if result == RESULT_OK:
            start_session(self._link, session)
            self.renew_challenge()
        else:
            io.hash_ok = 0
            io.session = 0
            self._response.value = self._control.state.fault_code
        return result

    def _commission(self, index, low):
        """Start a commission; the request needs a session, ``low`` is a pose and not the hash."""
        kind = index & ~COMMISSION_AT_POSE
        if kind != COMMISSION_FULL and kind != COMMISSION_VERIFY:
            return RESULT_OUT_OF_RANGE
        commission = self._control.commission
        if begin_commission(self._control.state, commission, kind) == 0:
            return RESULT_WRONG_STATE
        commission.pose_given = 0
        if index & COMMISSION_AT_POSE:
            pose = _signed(low)
            if pose == NOT_AVAILABLE:
                return RESULT_OUT_OF_RANGE
            commission.pose_given = 1
            commission.pose = position_from_wire(pose, self._control.settings.gear_q8)
        return self._arm(MODE_COMMISSIONING, PROTOCOL_HASH)

    def _home(self, index, low):
        c = self._control
        if c.settings.commissioned == 0:
            return RESULT_NOT_COMMISSIONED
        if index == HOME_STOP:
            return self._arm(MODE_HOMING, low)
        if index == HOME_ENCODER:
            return RESULT_OK if home_by_encoder(c.settings, c.state, c.io) else RESULT_NOT_HOMED
        pose = _signed(low)
        if index != HOME_POSE or pose == NOT_AVAILABLE:
            return RESULT_OUT_OF_RANGE
        at = position_from_wire(pose, c.settings.gear_q8)
        return RESULT_OK if home_at(c.settings, c.state, at) else RESULT_NOT_HOMED

    def _set_id(self, index, value):
        if value != self.board:
            return RESULT_WRONG_KEY
        if index > NODES:
            return RESULT_OUT_OF_RANGE
        self._joint.set_node(index)
        return RESULT_OK

    def _write(self, parameter, value):
        result = may_write(parameter, value, self._control.armed())
        if result == RESULT_OK:
            self._parameters.put(parameter, value)
        return result

    def _read(self, parameter):
        result = may_read(parameter)
        if result == RESULT_OK:
            self._response.value = self._value(parameter)
        return result

    def _value(self, parameter):
        state = self._control.state
        if is_stored(parameter):
            return self._parameters.get(parameter)
        if parameter >= PARAMETER_UNIQUE_ID_0 and parameter <= PARAMETER_UNIQUE_ID_3:
            return self._unique[parameter - PARAMETER_UNIQUE_ID_0]
        if parameter == PARAMETER_BUILD_ID:
            return self._joint.build
        if parameter == PARAMETER_FAULT_CODE:
            return state.fault_code
        if parameter == PARAMETER_FAULT_VALUE:
            return state.fault_value
        if parameter == PARAMETER_FAULT_TICK:
            return state.fault_tick
        if parameter == PARAMETER_UPTIME:
            return state.time_ms
        return self._count(parameter)

    def _count(self, parameter):
        if parameter == PARAMETER_RESET_CAUSE:
            return self._control.board.RESET_CAUSE
        if parameter == PARAMETER_LOST_SYNC:
            return self._link.lost_syncs
        if parameter == PARAMETER_BAD_FRAMES:
            return self._link.bad_frames
        if parameter == PARAMETER_SEND_FAILURES:
            return self._control.run.unsent_frames
        if parameter == PARAMETER_CHALLENGE:
            return self.challenge
        if parameter == PARAMETER_BUS_OFF:
            return self._control.board.bus_off()
        if parameter == PARAMETER_OVERRUNS:
            return self._control.run.late_steps
        return self._found(parameter)

    def _found(self, parameter):
        """Return what the last commissioning found and no stored parameter holds."""
        commission = self._control.commission
        if parameter == PARAMETER_RESISTANCE:
            return commission.resistance
        if parameter == PARAMETER_INDUCTANCE_D:
            return commission.inductance_d
        if parameter == PARAMETER_INDUCTANCE_Q:
            return commission.inductance_q
        if parameter == PARAMETER_FRICTION_LAG:
            return commission.lag
        if parameter == PARAMETER_COULOMB:
            return commission.coulomb
        if parameter == PARAMETER_VISCOUS:
            return commission.viscous
        if parameter == PARAMETER_BACKLASH:
            return commission.backlash
        if parameter == PARAMETER_VELOCITY_W_FOUND:
            return commission.velocity_w
        return 0


def _signed(low):
    return (low ^ 0x8000) - 0x8000


def _three_bytes(data, at):
    return data[at] | data[at + 1] << 8 | data[at + 2] << 16
