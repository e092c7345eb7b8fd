"""A joint's ticks with drawn readings and set-points, digested; runs on CPython and MicroPython (integers only)."""

from array import array

from shared.joint.commission_state import Commission
from shared.joint.commutation import fill_sine, set_commutation
from shared.joint.current import current_repair, current_step, set_loop, set_offsets
from shared.joint.drive_state import drive_arm, drive_clear
from shared.joint.encoder import home_at
from shared.joint.feed import feed_bus
from shared.joint.layout import CurrentLoop, JointIo, JointSettings, JointState, LoopSettings
from shared.joint.thermal import slow_tick
from shared.joint.tick import begin_commission, joint_reset, motion_tick
from shared.record import pack, unpack

MASK = 0x3FFFFFF


class Trace:
    """Settings are given as lists of integers, so that the host's can be carried into a virtual machine."""

    def __init__(self, loop_settings, settings, curve):
        self.loop = CurrentLoop()
        self.settings = JointSettings()
        self.curve = array("i", curve)
        self.state = JointState()
        self.io = JointIo()
        self.commission = Commission()
        own = LoopSettings()
        unpack(own, loop_settings)
        unpack(self.settings, settings)
        fill_sine(self.loop)
        set_loop(self.loop, own)
        set_offsets(self.loop, 2048 << 4, 2048 << 4, 2048 << 4)
        set_commutation(self.loop, self.settings)
        feed_bus(self.loop, self.settings, 6144)
        self.seed, self.digest, self.rotor, self.codes = 12345, 0, 100, 0
        joint_reset(self.loop, self.settings, self.state, 100)
        self.healthy()

    def at_rest(self):
        """Return what the current step works on, with the rotor at 0."""
        self.loop.rotor = 0
        return self.loop

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
                self.loop.raw[k] = 1948 + self.draw(200)
            bad = 1 if self.draw(97) == 0 else 0
            code = current_step(self.rotor, bad, self.loop)
            if code:
                self.codes |= 1 << code
                current_repair(code, self.rotor, bad, self.loop)

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
            home_at(self.settings, self.state, self.state.position)
            begin_commission(self.state, self.commission, 1 + number // 400 % 2)
            b.position = 0
            drive_arm(self.settings, self.state, b, (0, 0, 7, 6)[number // 400 % 4])
        if number % 1300 == 1200:
            b.e_stop = 1
        self.steps(3)
        motion_tick(self.loop, self.settings, self.state, b, self.commission)
        if number % 100 == 0:
            b.thermistor_raw = 400 + self.draw(2000)
            slow_tick(self.settings, self.state, b, self.curve)
        for block in (self.loop, self.state, self.settings, self.commission):
            self.take(pack(block)[:200])  # without the sine table, which nothing changes

    def run(self, ticks):
        """Return the digest over ``ticks`` ticks."""
        for number in range(ticks):
            self.tick(number)
        return self.digest
