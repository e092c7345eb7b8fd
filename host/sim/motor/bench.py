"""A joint on a simulated bench: the firmware's own application on the simulated board, with the motor model under it.

Ten thousand current steps a second, the main loop every millisecond, and a host on the bus that sends set-points,
SYNC and requests as frames. A step's duties act for the whole of the next step, as the timer's preload makes them.
"""

from array import array
from dataclasses import dataclass, field
from math import tau

from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.settings import Memory
from shared.joint.layout import JointState
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

from ...robot.actuators import Bldc
from ...robot.joint_gains import JointBlocks, impedance_gains, joint_blocks
from ...robot.joint_units import JointSetup
from ...util.errors import UserError
from .model import Load, Motor
from .sensors import Sensors, Wrong

STEP_S = 1e-4
STEPS_PER_MS = 10
SUBSTEPS = 2  # of the motor model in a current step
SETPOINT_MS = 5  # 200 Hz
SESSION = 17


@dataclass
class Trace:
    """The values recorded once a millisecond."""

    time_s: list[float] = field(default_factory=list)
    joint_rad: list[float] = field(default_factory=list)
    goal_rad: list[float] = field(default_factory=list)
    speed_rad_s: list[float] = field(default_factory=list)
    current_A: list[float] = field(default_factory=list)  # i_q of the motor
    peak_A: list[float] = field(default_factory=list)  # largest phase current within the millisecond
    torque_Nm: list[float] = field(default_factory=list)  # at the joint
    winding_C: list[float] = field(default_factory=list)
    limit_A: list[float] = field(default_factory=list)
    state: list[int] = field(default_factory=list)


class Bench:
    """One joint; ``run`` goes on by milliseconds. Times in the firmware's own clock."""

    def __init__(
        self,
        bldc: Bldc,
        load: Load | None = None,
        setup: JointSetup | None = None,
        commissioned: bool = True,
        elec_offset_rad: float = 0.7,
        seed: int = 0,
        real: Bldc | None = None,
        node: int = 1,
    ) -> None:
        """``real``: the motor, where it is another than the robot file says."""
        if bldc.drive.current_limit_A <= 0:
            raise UserError("actuator.drive.current_limit_A: must be above 0")
        self.bldc, self.load = bldc, load or Load()
        self.setup = setup or JointSetup(-1.0, 1.9, inertia_kg_m2=self.load.inertia_kg_m2)
        self.blocks: JointBlocks = joint_blocks(bldc, self.setup)
        self.units = self.blocks.units
        self.motor = Motor(real or bldc, self.load, elec_offset_rad=elec_offset_rad)
        self.wrong = Wrong()
        self.sensors = Sensors(bldc, self.wrong, seed)
        self.board = SimBoard()
        self.joint = Joint(self.board, Memory())
        self._configure(commissioned, elec_offset_rad)
        self.trace = Trace()
        self.late_every = 0  # 0 never; else each such interrupt is skipped
        self.mode = 0  # kind of the set-point sent, MODE_*; 0 sends none
        self.goal = 0.0
        self.goal_speed = 0.0
        self.peak_A = 0.0
        self.rejected = 0  # rotor readings that the joint did not believe
        self.fast: list[float] | None = None  # q current at every step, if wanted
        self._values = array("i", [w.NO_CHANGE] * 4)
        self._frame = array("H", [0] * 4)
        self._sync = 0
        self._sequence = 0
        self._ms = 0
        self._steps = 0
        self.joint.set_node(node)
        self.joint.start()
        self.run(60)

    def _configure(self, commissioned: bool, elec_offset_rad: float) -> None:
        """Hand the host's integers to the joint, as writing its parameters does."""
        control = self.joint.control
        self.joint.parameters.take(self.blocks.stored())
        if commissioned:
            control.settings.commissioned = 1
            control.settings.elec_offset = round(elec_offset_rad / tau * 65536) & 0xFFFF

    @property
    def state(self) -> JointState:
        """The joint's saved parameters."""
        return self.joint.control.state

    @property
    def enabled(self) -> bool:
        """Whether the joint follows its commands."""
        return int(self.state.drive_state) == w.STATE_OPERATION_ENABLED

    @property
    def time_s(self) -> float:
        """Time since power-on."""
        return self._ms / 1000

    def run(self, milliseconds: int) -> None:
        """Go on; a set-point with SYNC every 5 ms if ``mode`` is set."""
        for _ in range(milliseconds):
            if self.mode and self._ms % SETPOINT_MS == 0:
                self.send_setpoint()
            self.peak_A = 0.0
            for _ in range(STEPS_PER_MS):
                self._step()
            if self.wrong.supply_V is not None:
                self.motor.supply_V = self.wrong.supply_V
            self.motor.warm(STEP_S * STEPS_PER_MS)
            self.sensors.read_slow(self.motor, self.board)
            self.rejected += self.joint.control.loop.glitches
            self.joint.poll()
            self._ms += 1
            self._record()

    def _step(self) -> None:
        board, motor = self.board, self.motor
        board.now_us += round(STEP_S * 1e6)
        self._steps += 1
        compare, period = board.compare, self.blocks.loop.period
        duties = (compare[0] / period, compare[1] / period, compare[2] / period)  # the update event takes them over
        if board.handler is not None and not (self.late_every and self._steps % self.late_every == 0):
            self.sensors.read_fast(motor, board)
            board.handler()
        for _ in range(SUBSTEPS):
            motor.advance(STEP_S / SUBSTEPS, bool(board.bridge), *duties)
        if self.fast is not None:
            self.fast.append(motor.i_q)
        for current in motor.phases_A:
            if current > self.peak_A:
                self.peak_A = current
            elif -current > self.peak_A:
                self.peak_A = -current

    def _record(self) -> None:
        t, m = self.trace, self.motor
        t.time_s.append(self.time_s)
        t.joint_rad.append(m.joint_rad)
        t.goal_rad.append(self.goal)
        t.speed_rad_s.append(m.joint_rad_s)
        t.current_A.append(m.i_q)
        t.peak_A.append(self.peak_A)
        t.torque_Nm.append(m.gear_Nm)
        t.winding_C.append(m.winding_C)
        t.limit_A.append(self.state.current_limit * self.units.ampere_per_cu)
        t.state.append(self.state.drive_state)

    def send_setpoint(self) -> None:
        """Send ``goal`` (rad, rad/s or A as ``mode`` says), the speed fed forward if there is one, and SYNC."""
        turn = 65536 / tau
        scale = {w.MODE_VELOCITY: 4096 / tau, w.MODE_CURRENT: 4096.0}.get(self.mode, turn)
        self._group(w.SETPOINT_POSITION_ID + self.mode - 1, round(self.goal * scale))
        if self.mode == w.MODE_POSITION and self.goal_speed:
            self._group(w.FEEDFORWARD_VELOCITY_ID, round(self.goal_speed * 4096 / tau))
        if self.mode == w.MODE_IMPEDANCE:
            stiffness, damping = impedance_gains(self.bldc)
            self._group(w.IMPEDANCE_STIFFNESS_ID, stiffness)
            self._group(w.IMPEDANCE_DAMPING_ID, damping)
        encode_sync(self._frame, unpack(Sync(), (self._sync, SESSION)))
        self.board.deliver(w.SYNC_ID, self._frame, w.SYNC_LENGTH)
        self._sync = (self._sync + 1) & 0xFF

    def _group(self, identifier: int, value: int) -> None:
        self._values[0] = value
        encode_group(self._frame, self._values)
        self.board.deliver(identifier, self._frame, 8)

    def request(self, command: int, index: int = 0, value: int = 0) -> int:
        """Send a service request, with the challenge where it needs one; return RESULT_*."""
        if command in (w.COMMAND_ARM, w.COMMAND_COMMISSION, w.COMMAND_HOME):
            value = self.joint.service.challenge << 16 | value & 0xFFFF
        return self.ask(command, index, value)

    def ask(self, command: int, index: int, value: int) -> int:
        """Send a service request as it is, let it be answered, and return RESULT_*."""
        self._sequence = (self._sequence + 1) & 0xFF
        fields = (command, self._sequence, SESSION, index, value)
        encode_service_request(self._frame, unpack(ServiceRequest(), fields))
        self.board.deliver(w.SERVICE_REQUEST_ID + 1, self._frame, 8)
        answer, frame = ServiceResponse(), array("H", [0] * 4)
        while self.board.sent.take(frame) >= 0:
            pass  # what was sent before
        self.run(1)
        while True:
            identifier = self.board.sent.take(frame)
            if identifier < 0:
                raise UserError(f"the simulated joint does not answer request {command}")
            if identifier == w.SERVICE_RESPONSE_ID + 1 and decode_service_response(frame, answer) == 0:
                return answer.result

    def arm(self, mode: int, goal: float) -> None:
        """Send set-points of ``mode`` for 20 ms, then arm; UserError with the reason if the joint refuses."""
        self.mode, self.goal = mode, goal
        self.run(20)
        result = self.request(w.COMMAND_ARM, value=w.PROTOCOL_HASH)
        self.run(5)
        if result != w.RESULT_OK or not self.enabled:
            raise UserError(f"the simulated joint refused arming: result {result}")
