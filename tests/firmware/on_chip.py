"""A joint's whole firmware on the model of its chip, with a host on its CAN bus: for the tests of board and driver."""

from array import array

from firmware.board_stm32f405 import Stm32F405Board
from firmware.joint import Joint
from firmware.settings import Memory
from host.robot.file import load_robot
from host.robot.joint_gains import joint_blocks
from host.robot.joint_units import JointSetup
from host.sim.chip.can_wire import Frame
from host.sim.chip.joint_board import JointBoard
from shared.record import unpack
from shared.wire import names as w
from shared.wire.codec import (
    ServiceRequest,
    ServiceResponse,
    Sync,
    decode_service_response,
    encode_group,
    encode_service_request,
    encode_sync,
)

PARALLEL = load_robot("parallel").actuator
BLOCKS = joint_blocks(PARALLEL, JointSetup(-1.0, 1.9))
SESSION = 17
CALL_CYCLES = 200  # of bytecode round a call, so that polling the clock for milliseconds is not 10^5 reads
STEP_CYCLES = 16_800  # 100 us
READY_MS = 30
NODE = 1


def data(frame, length=8):
    """Return an array('H') frame's bytes as they go over the bus."""
    return frame.tobytes()[:length]


class OnChip:
    """One joint. ``begin`` starts it; ``run`` goes on by milliseconds, a set-point each 5 ms if ``goal`` is set."""

    def __init__(self, board=None, update=None, **more):
        self.board = board or JointBoard(**more)
        self.model = self.board.model
        self.driver = Stm32F405Board(self.board)
        self.clock = self.driver.ticks_us
        self.driver.ticks_us = self._ticks_us
        self.joint = Joint(self.driver, Memory(), update)
        self.control = self.joint.control
        self.joint.parameters.take(BLOCKS.stored())  # as writing the parameters does
        self.control.settings.commissioned = 1
        self.control.settings.elec_offset = 7000
        self.joint.set_node(NODE)
        self.goal = None  # A of the q axis
        self.values = array("i", [w.NO_CHANGE] * 4)
        self.sync = self.sequence = self.ms = 0
        self.heard = []
        self.board.can.on_frame(lambda sender, frame: self.heard.append((sender, frame)))

    def _ticks_us(self):
        self.board.work(CALL_CYCLES)
        return self.clock()

    def begin(self, ms=READY_MS):
        """Start the application, and go on until the offsets are measured."""
        self.joint.start()
        self.run(ms)
        return self

    def run(self, milliseconds=1):
        for _ in range(milliseconds):
            if self.goal is not None and self.ms % 5 == 0:
                self.send_goal()
            self.board.run(1, self.joint.poll)
            self.ms += 1
        return self

    def steps(self, count, body=None):
        """Go on by current steps; without a body the main loop hangs."""
        self.board.run(count / 10, body)
        return self

    # -- the host on the bus --

    def send(self, identifier, payload=b"", **more):
        self.board.can.send(Frame(identifier, bytes(payload), **more))

    def send_goal(self):
        """Send a current as set-point and, when that has passed, SYNC, which would win the bus."""
        frame = array("H", [0] * 4)
        self.values[0] = round(self.goal * 4096)
        encode_group(frame, self.values)
        self.send(w.SETPOINT_POSITION_ID + w.MODE_CURRENT - 1, data(frame))
        self.model.at(self.model.now + 2 * STEP_CYCLES, self.send_sync)

    def send_sync(self):
        frame = array("H", [0] * 4)
        encode_sync(frame, unpack(Sync(), (self.sync, SESSION)))
        self.send(w.SYNC_ID, data(frame, w.SYNC_LENGTH))
        self.sync = (self.sync + 1) & 0xFF

    def request(self, command, index=0, value=0, ms=3):
        """Send a request; return its result, None without an answer."""
        self.sequence = (self.sequence + 1) & 0xFF
        frame = array("H", [0] * 4)
        encode_service_request(frame, unpack(ServiceRequest(), (command, self.sequence, SESSION, index, value)))
        self.heard.clear()
        self.send(w.SERVICE_REQUEST_ID + NODE, data(frame))
        self.run(ms)
        answer = ServiceResponse()
        for frame in self.from_joint(w.SERVICE_RESPONSE_ID + NODE):
            if decode_service_response(array("H", frame.data), answer) == 0:
                return answer.result
        return None

    def from_joint(self, identifier):
        """Return the joint's own frames with an identifier that went over the bus since the last request."""
        return [frame for sender, frame in self.heard if sender == "CAN1" and frame.identifier == identifier]

    def arm(self, amps=0.3):
        """Arm with a current as set-point; return the result."""
        self.goal = amps
        self.run(11)
        result = self.request(w.COMMAND_ARM, value=self.joint.service.challenge << 16 | w.PROTOCOL_HASH)
        self.run(3)
        return result

    # -- what is --

    @property
    def state(self):
        return self.control.state.drive_state

    @property
    def fault(self):
        return self.control.state.fault_code, self.control.state.fault_value

    @property
    def complaints(self):
        return [str(complaint) for complaint in self.model.complaints]
