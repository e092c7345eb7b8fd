"""A joint's ticks with drawn readings and set-points, digested; runs on CPython and MicroPython (integers only)."""

from array import array

from shared.joint.calibration import Calibration, set_commutation
from shared.joint.current import current_repair, current_step, set_loop, set_offsets
from shared.joint.drive_state import drive_arm, drive_clear
from shared.joint.encoder import home_at
from shared.joint.feed import feed_bus
from shared.joint.layout import Foc, JointConfig, JointIo, JointState, LoopSettings
from shared.joint.sine import fill_sine
from shared.joint.tick import begin_calibration, joint_reset, motion_tick, slow_tick
from shared.record import pack, unpack

MASK = 0x3FFFFFF


class Trace:
    """Settings are given as lists of integers, so that the host's can be carried into a virtual machine."""

    def __init__(self, loop, cfg, curve):
        self.foc = Foc()
        self.cfg = JointConfig()
        self.curve = array("i", curve)
        self.state = JointState()
        self.io = JointIo()
        self.cal = Calibration()
        settings = LoopSettings()
        unpack(settings, loop)
        unpack(self.cfg, cfg)
        fill_sine(self.foc)
        set_loop(self.foc, settings)
        set_offsets(self.foc, 2048 << 4, 2048 << 4, 2048 << 4)
        set_commutation(self.foc, self.cfg)
        feed_bus(self.foc, self.cfg, 6144)
        self.seed, self.digest, self.rotor, self.codes = 12345, 0, 100, 0
        joint_reset(self.foc, self.cfg, self.state, 100)
        self.healthy()

    def at_rest(self):
        """Return what the current step works on, with the rotor at 0."""
        self.foc.rotor = 0
        return self.foc

    def draw(self, count):
        self.seed = (self.seed * 25 + 13849) & 0xFFFF
        return (self.seed >> 3) % count

    def healthy(self):
        b = self.io
        b.hash_ok = b.session = b.hardware_ready = 1
        b.e_stop = b.hardware_fault = 0
        b.bus_raw, b.thermistor_raw, b.mcu_raw = 2291, 2048, 980

    def take(self, block):
        digest = self.digest
        for value in block:
            digest = (digest * 31 + (value & MASK)) & MASK
        self.digest = digest

    def steps(self, count):
        for _ in range(count):
            self.rotor = (self.rotor + self.draw(160) - 80) & 16383
            for k in range(3):
                self.foc.raw[k] = 1948 + self.draw(200)
            bad = 1 if self.draw(97) == 0 else 0
            code = current_step(self.rotor, bad, self.foc)
            if code:
                self.codes |= 1 << code
                current_repair(code, self.rotor, bad, self.foc)

    def tick(self, number):
        b = self.io
        if number % 5 == 0:
            b.sequence += 1
            b.mode = 1 + (number // 250) % 4
            b.position, b.velocity, b.current = self.draw(8000) - 4000, self.draw(8000) - 4000, self.draw(8000) - 4000
            b.stiffness, b.damping = self.draw(8000), self.draw(8000)
        if number % 400 == 100:
            self.healthy()
            drive_clear(self.state)
        if number % 400 == 150:
            home_at(self.cfg, self.state, self.state.position)
            begin_calibration(self.state, self.cal, 1 + number // 400 % 3)
            b.position = 0
            drive_arm(self.cfg, self.state, b, (0, 0, 7, 6)[number // 400 % 4])
        if number % 1300 == 1200:
            b.e_stop = 1
        self.steps(3)
        motion_tick(self.foc, self.cfg, self.state, b, self.cal)
        if number % 100 == 0:
            b.thermistor_raw = 400 + self.draw(2000)
            slow_tick(self.cfg, self.state, b, self.curve)
        for block in (self.foc, self.state, self.cfg, self.cal):
            self.take(pack(block)[:200])  # without the sine table, which nothing changes

    def run(self, ticks):
        """Return the digest over ``ticks`` ticks."""
        for number in range(ticks):
            self.tick(number)
        return self.digest
