"""The time-critical part of a joint: current step in the interrupt, motion and slow tick in the main loop.

Knows no register: ``board`` is firmware/board_stm32f405.py or firmware/board_sim.py. Whatever goes wrong, the bridge
is switched off first and looked into afterwards. After ``start`` nothing here allocates.
"""


from shared.joint.calibration import CAL_SIZE
from shared.joint.current import current_repair, current_step, set_offsets
from shared.joint.encoder import home_by_encoder
from shared.joint.faults import (
    FAULT_CURRENT_SENSE,
    FAULT_DRIVER,
    FAULT_DRIVER_SETUP,
    FAULT_EXCEPTION,
    FAULT_INTERRUPT_STOPPED,
    FAULT_NONE,
    FAULT_OVERRUN,
)
from shared.joint.layout import (
    CFG_SIZE,
    F_RAW_A,
    F_RAW_B,
    F_RAW_C,
    F_ROTOR,
    FOC_SIZE,
    IO_BUS_RAW,
    IO_E_STOP,
    IO_HARDWARE_FAULT,
    IO_HARDWARE_READY,
    IO_HARDWARE_VALUE,
    IO_JOINT_RAW,
    IO_JOINT_VALID,
    IO_MCU_RAW,
    IO_SIZE,
    IO_THERMISTOR_RAW,
    K_HAS_JOINT_ENCODER,
    K_MCU_CAL1,
    K_MCU_CAL2,
    K_OFFSET_SPREAD,
    REQUEST_ARM,
    S_DRIVE,
    S_REQUEST,
    S_TORQUE,
    STATE_SIZE,
    TORQUE_OFF,
)
from shared.joint.sine import fill_sine
from shared.joint.thermal import CURVE_SIZE
from shared.joint.tick import joint_reset, motion_tick, slow_tick
from shared.runtime import const, zeros
from shared.wire.names import STATE_FAULT_REACTION, STATE_READY

PART_STEP = const(1)  # values of FAULT_EXCEPTION
PART_MOTION = const(2)
PART_SLOW = const(3)
PART_BUS = const(4)

OFFSET_STEPS = const(256)  # averaged with the bridge off before the joint is ready
_MASK = const(0x3FFFFFFF)
_SLOW_TICKS = const(100)
_LATE_SHARE = const(3)  # a step is late when it comes after 3/2 of its period
_LATE_MOST = const(5)  # late steps in a slow period that are a fault
_MOTION_LATE_STEPS = const(50)  # current steps without a motion tick until the interrupt switches the bridge off
_STOPPED_MS = const(3)  # motion ticks without a current step
_INVALID_MS = const(10)  # the joint encoder may be silent that long
_HOLD_MS = const(20)  # a hardware fault stays reported that long after its cause
_E_STOP_MS = const(20)  # an emergency stop lasts that long after its last frame


class Control:
    """All blocks of one joint and what is done with them at its three rates."""

    def __init__(self, board):
        self.board = board
        self.foc = zeros(FOC_SIZE)
        fill_sine(self.foc)
        self.cfg = zeros(CFG_SIZE)
        self.curve = zeros(CURVE_SIZE)
        self.state = zeros(STATE_SIZE)
        self.io = zeros(IO_SIZE)
        self.cal = zeros(CAL_SIZE)
        self.bridge = 0  # 1: the bridge is on
        self.steps = 0  # current steps, modulo 2^30
        self.late = 0  # late steps since power-on
        self.failed = 0  # PART_* that raised an exception since the last motion tick
        self.ready = 0  # 1 once offsets are measured and the driver is set up
        self.offset_steps = 0
        self._late_us = board.STEP_US * _LATE_SHARE // 2
        self._last_us = -1
        self._since_motion = 0
        self._late_seen = 0
        self._seen_steps = 0
        self._still_ms = 0
        self._invalid_ms = 0
        self._hold_ms = 0
        self._e_stop_ms = 0
        self._slow_ticks = 0
        self._sums = zeros(3)

    def start(self):
        """Set the driver up and begin to measure the current offsets; the configuration must be in place."""
        self.cfg[K_MCU_CAL1] = self.board.MCU_CAL1
        self.cfg[K_MCU_CAL2] = self.board.MCU_CAL2
        wrong = self.board.driver_setup()
        rotor = self.board.read_rotor()
        joint_reset(self.foc, self.cfg, self.state, rotor if rotor >= 0 else 0)
        self.offset_steps = OFFSET_STEPS if wrong < 0 else -1
        if wrong >= 0:
            self.raise_fault(FAULT_DRIVER_SETUP, wrong)
        self.io[IO_MCU_RAW] = self.board.read_mcu()
        self.io[IO_THERMISTOR_RAW] = self.board.read_thermistor()
        slow_tick(self.cfg, self.state, self.io, self.curve)

    def step(self):
        """Do one current step: the interrupt's handler. No exception leaves it, and any switches the bridge off."""
        try:
            self._step()
        except BaseException:  # whatever it is: without current control there must be no bridge
            self.board.pwm_off()
            self.bridge = 0
            self.failed = PART_STEP

    def motion(self):
        """Do one millisecond of the main loop, and the slow tick when it is due."""
        try:
            self._motion()
        except Exception:
            self.stop(PART_MOTION)
        self._slow_ticks += 1
        if self._slow_ticks >= _SLOW_TICKS:
            self._slow_ticks = 0
            try:
                self._slow()
            except Exception:
                self.stop(PART_SLOW)

    def stop(self, part):
        """Switch the bridge off after an exception in ``part``; the next motion tick latches it."""
        self.board.pwm_off()
        self.bridge = 0
        self.failed = part

    def raise_fault(self, code, value):
        """Report a fault of the hardware; the first stands until it has not been raised for 20 ms."""
        if self.io[IO_HARDWARE_FAULT] == FAULT_NONE:
            self.io[IO_HARDWARE_FAULT] = code
            self.io[IO_HARDWARE_VALUE] = value
        if self.io[IO_HARDWARE_FAULT] == code:
            self._hold_ms = _HOLD_MS

    def emergency_stop(self):
        """Take an emergency stop from the bus: the bridge goes off here and now."""
        self.board.pwm_off()
        self.bridge = 0
        self._e_stop_ms = _E_STOP_MS
        self.io[IO_E_STOP] = 1

    def armed(self):
        """Return 1 from the moment arming was accepted until the torque is gone."""
        if self.state[S_REQUEST] == REQUEST_ARM:
            return 1
        if self.state[S_DRIVE] >= STATE_READY and self.state[S_DRIVE] <= STATE_FAULT_REACTION:
            return 1
        return 0

    def _step(self):
        board = self.board
        foc = self.foc
        self._note_time(board.ticks_us())
        board.read_currents(foc)
        rotor = board.read_rotor()
        invalid = 0
        if rotor < 0:
            rotor = foc[F_ROTOR]
            invalid = 1
        code = current_step(rotor, invalid, foc)
        if code:
            code = current_repair(code, rotor, invalid, foc)
        if code or self._since_motion > _MOTION_LATE_STEPS:
            board.pwm_off()
            self.bridge = 0
        elif self.bridge:
            board.pwm_write(foc)
        if self.offset_steps > 0:
            self._gather_offsets()

    def _note_time(self, now):
        if self._last_us >= 0 and ((now - self._last_us) & _MASK) > self._late_us:
            self.late = (self.late + 1) & _MASK
        self._last_us = now
        self.steps = (self.steps + 1) & _MASK
        self._since_motion += 1

    def _gather_offsets(self):
        self._sums[0] += self.foc[F_RAW_A]
        self._sums[1] += self.foc[F_RAW_B]
        self._sums[2] += self.foc[F_RAW_C]
        self.offset_steps -= 1

    def _take_offsets(self):
        """Use the offsets measured with the bridge off, or refuse to become ready."""
        for phase in range(3):
            mean = self._sums[phase] // OFFSET_STEPS
            if mean < 2048 - self.cfg[K_OFFSET_SPREAD] or mean > 2048 + self.cfg[K_OFFSET_SPREAD]:
                self.offset_steps = -1
                self.raise_fault(FAULT_CURRENT_SENSE, mean - 2048)
                return
        shift = OFFSET_STEPS // 16
        set_offsets(self.foc, self._sums[0] // shift, self._sums[1] // shift, self._sums[2] // shift)
        self.ready = 1

    def _motion(self):
        self._sense()
        self._watch()
        torque = motion_tick(self.foc, self.cfg, self.state, self.io, self.cal)
        self._since_motion = 0
        if torque == TORQUE_OFF:
            if self.bridge:
                self.board.pwm_off()
                self.bridge = 0
        elif self.bridge == 0:
            self.board.pwm_write(self.foc)
            self.board.pwm_on()
            self.bridge = 1

    def _sense(self):
        io = self.io
        io[IO_BUS_RAW] = self.board.read_bus()
        joint = self.board.read_joint()
        io[IO_JOINT_VALID] = 0
        self._invalid_ms += 1
        if joint >= 0:
            io[IO_JOINT_RAW] = joint
            io[IO_JOINT_VALID] = 1
            self._invalid_ms = 0
        if self.ready == 0 and self.offset_steps == 0 and self.steps >= OFFSET_STEPS:
            self._take_offsets()
            home_by_encoder(self.cfg, self.state, io)
        io[IO_HARDWARE_READY] = self.ready
        if self.cfg[K_HAS_JOINT_ENCODER] and self._invalid_ms > _INVALID_MS:
            io[IO_HARDWARE_READY] = 0

    def _watch(self):
        """Look for faults of the hardware that only the application can see."""
        io = self.io
        if self.failed:
            self.raise_fault(FAULT_EXCEPTION, self.failed)
            self.failed = 0
        driver = self.board.driver_fault()
        if driver:
            self.raise_fault(FAULT_DRIVER, driver)
        self._still_ms += 1
        if self.steps != self._seen_steps:
            self._seen_steps = self.steps
            self._still_ms = 0
        if self._still_ms >= _STOPPED_MS:
            self.board.pwm_off()
            self.bridge = 0
            self.raise_fault(FAULT_INTERRUPT_STOPPED, self._still_ms)
        if self.late - self._late_seen >= _LATE_MOST:
            self.raise_fault(FAULT_OVERRUN, self.late - self._late_seen)
        if self._hold_ms > 0:
            self._hold_ms -= 1
        elif io[IO_HARDWARE_FAULT]:
            io[IO_HARDWARE_FAULT] = FAULT_NONE
        if self._e_stop_ms > 0:
            self._e_stop_ms -= 1
        else:
            io[IO_E_STOP] = 0

    def _slow(self):
        self.io[IO_THERMISTOR_RAW] = self.board.read_thermistor()
        self.io[IO_MCU_RAW] = self.board.read_mcu()
        slow_tick(self.cfg, self.state, self.io, self.curve)
        self._late_seen = self.late
        if self.bridge == 0 and self.state[S_TORQUE] == TORQUE_OFF and self.offset_steps == 0:
            wrong = self.board.driver_check()
            if wrong >= 0:
                self.raise_fault(FAULT_DRIVER_SETUP, wrong)
