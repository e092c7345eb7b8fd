"""The time-critical part of a joint: current step in the interrupt, motion and slow tick in the main loop.

Knows no register: ``board`` is firmware/board_stm32f405.py or firmware/board_sim.py. Whatever goes wrong, the bridge
is switched off first and looked into afterwards. After ``start`` nothing here allocates.
"""

from shared.joint.commission_state import Commission
from shared.joint.commutation import fill_sine
from shared.joint.faults import FAULT_DRIVER_SETUP
from shared.joint.layout import TORQUE_OFF, CurrentLoop, JointIo, JointSettings, JointState, LoopSettings
from shared.joint.thermal import CURVE_SIZE, slow_tick
from shared.joint.tick import joint_reset
from shared.runtime import const, zeros

from .joint_bus import is_armed
from .joint_run import OFFSET_STEPS, PART_MOTION, PART_SLOW, BoardRun, note_fault, note_stop

_SLOW_TICKS = const(100)
_LATE_SHARE = const(3)  # a step is late when it comes after 3/2 of its period


class Control:
    """All blocks of one joint and what is done with them at its three rates."""

    def __init__(self, board):
        self.board = board
        self.loop = CurrentLoop()
        fill_sine(self.loop)
        self.loop_settings = LoopSettings()
        self.settings = JointSettings()
        self.curve = zeros(CURVE_SIZE)
        self.state = JointState()
        self.io = JointIo()
        self.commission = Commission()
        self.run = BoardRun()
        self.run.late_after_us = board.STEP_US * _LATE_SHARE // 2
        self.run.last_us = -1
        self._slow_ticks = 0

    def start(self):
        """Set the driver up and let the interrupt begin, which first measures the current offsets."""
        self.settings.mcu_cal1 = self.board.MCU_CAL1
        self.settings.mcu_cal2 = self.board.MCU_CAL2
        wrong = self.board.driver_setup()
        rotor = self.board.read_rotor()
        joint_reset(self.loop, self.settings, self.state, rotor if rotor >= 0 else 0)
        self.run.offset_steps = OFFSET_STEPS if wrong < 0 else -1
        if wrong >= 0:
            self.raise_fault(FAULT_DRIVER_SETUP, wrong)
        try:
            self._temperatures()
        except Exception:
            self.stop(PART_SLOW)
        self.board.start(self)

    def motion(self):
        """Do one millisecond of the main loop, and the slow tick when it is due."""
        try:
            self.board.millisecond()
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
        self.run.bridge = 0
        self.run.failed_part = part

    def raise_fault(self, code, value):
        """Report a fault of the hardware; the first stands until it has not been raised for 20 ms."""
        note_fault(self.run, self.io, code, value)

    def emergency_stop(self):
        """Take an emergency stop from the bus: the bridge goes off here and now."""
        self.board.pwm_off()
        note_stop(self.run, self.io)

    def armed(self):
        """Return 1 from the moment arming was accepted until the torque is gone."""
        return is_armed(self.state)

    def _temperatures(self):
        self.io.thermistor_raw = self.board.read_thermistor()
        self.io.mcu_raw = self.board.read_mcu()
        slow_tick(self.settings, self.state, self.io, self.curve)

    def _slow(self):
        self._temperatures()
        run = self.run
        run.late_steps_seen = run.late_steps
        if run.bridge == 0 and self.state.torque == TORQUE_OFF and run.offset_steps == 0:
            wrong = self.board.driver_check()
            if wrong >= 0:
                self.raise_fault(FAULT_DRIVER_SETUP, wrong)
