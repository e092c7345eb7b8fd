"""A joint's board that is not there: the interface of firmware/board_stm32f405.py, its readings set from outside.

The host's motor model writes ``raw``, ``rotor``, ``joint``, ... and reads ``compare`` and ``bridge``. Time is what
``now_us`` says. It runs on MicroPython too, so that allocation can be looked at there.
"""

from array import array

from shared.joint.layout import CurrentLoop, JointIo
from shared.wire.codec import Reply
from shared.wire.names import REPLY_LENGTH
from shared.wire.receive import Link

from .joint_bus import FRAMES_MOST, WANTS_REPLY, take_frame, write_reply
from .joint_control import Control
from .joint_run import BRIDGE_OFF, BRIDGE_ON, take_motion, take_step

_QUEUE = 64  # frames
_MASK = 0x3FFFFFFF


class SimBoard:
    """All a joint's application needs of its board."""

    STEP_US = 100
    MCU_CAL1 = 943  # typical factory readings at 30 and 110 degrees C
    MCU_CAL2 = 1194
    RESET_CAUSE = 0

    def __init__(self, unique_id=bytes(range(12))):
        self._unique_id = unique_id
        self._drawn = 1 + unique_id[0]
        self.raw = array("i", [2048, 2048, 2048])
        self.rotor = 0  # rc, -1: the reading failed its check
        self.joint = 0
        self.bus = 2291
        self.thermistor = 2048
        self.mcu = 980
        self.driver = 0
        self.driver_wrong = -1  # register that reads back differently
        self.compare = array("i", [0, 0, 0])
        self.bridge = 0
        self.now_us = 0
        self.handler = None
        self.fed = 0
        self.resets = 0
        self.to_loader = False
        self.filters = 0
        self._reply = Reply()
        self._in = Frames()
        self.sent = Frames()

    def start(self, control: Control):
        """From now on ``handler()`` does a current step on the control's blocks, ``millisecond()`` a motion tick."""
        self._control = control
        self.handler = self._step

    def _step(self):
        """Do what the chip's interrupt does: samples, rotor, control, compares."""
        c: Control = self._control
        loop = c.loop
        loop.raw[0] = self.raw[0]
        loop.raw[1] = self.raw[1]
        loop.raw[2] = self.raw[2]
        wanted = take_step(loop, c.run, self.now_us & 0x3FFFFFFF, self.rotor)
        if wanted == BRIDGE_OFF:
            self.bridge = 0
        elif wanted == BRIDGE_ON:
            self._write_compares(loop)

    def _write_compares(self, loop: CurrentLoop):
        self.compare[0] = loop.duty[0]
        self.compare[1] = loop.duty[1]
        self.compare[2] = loop.duty[2]

    def pwm_off(self):
        """Open all six switches."""
        self.bridge = 0

    def millisecond(self):
        """Do what the chip does: sensors, a motion tick, the bridge, the watchdog; return the gate driver's fault."""
        c: Control = self._control
        self._sense(c.io)
        wanted = take_motion(c.loop, c.settings, c.state, c.io, c.commission, c.run, self.driver)
        if wanted == BRIDGE_ON:
            self._write_compares(c.loop)
            self.bridge = 1
        elif wanted == BRIDGE_OFF:
            self.bridge = 0
        if c.run.steps != c.run.steps_fed:
            c.run.steps_fed = c.run.steps
            self.fed = (self.fed + 1) & 0x3FFFFFFF
        return self.driver

    def _sense(self, io: JointIo):
        io.bus_raw = self.bus
        io.joint_valid = 0
        if self.joint >= 0:
            io.joint_raw = self.joint
            io.joint_valid = 1

    def read_rotor(self):
        """Return the rotor encoder's angle, 0 .. 16383, or -1 if the reading failed its check."""
        return self.rotor

    def read_joint(self):
        """Return the joint encoder's angle, 0 .. 16383, or -1."""
        return self.joint

    def read_bus(self):
        """Return the bus voltage in ADC counts."""
        return self.bus

    def read_thermistor(self):
        """Return the thermistor in ADC counts."""
        return self.thermistor

    def read_mcu(self):
        """Return the microcontroller's temperature sensor in ADC counts."""
        return self.mcu

    def driver_setup(self):
        """Write and read back the gate driver's registers; return the first that differs, -1 if none."""
        return self.driver_wrong

    def driver_check(self):
        """Read the registers again; return the first that differs, -1 if none."""
        return self.driver_wrong

    def ticks_us(self):
        """Return microseconds modulo 2^30."""
        return self.now_us & 0x3FFFFFFF

    def random(self):
        """Return 30 bits that follow from the board's number, its time and the draws before (xorshift)."""
        x = self._drawn ^ (self.now_us & _MASK)
        x ^= (x & 0x1FFFF) << 13
        x ^= x >> 17
        x ^= (x & 0x1FFFFFF) << 5
        self._drawn = x
        return x

    def unique_id(self):
        """Return the chip's twelve bytes."""
        return self._unique_id

    def bus_off(self):
        """Return how often the CAN controller was bus-off."""
        return 0

    def can_filters(self, pairs, count):
        """Set the hardware filters; a simulated bus hands over every frame."""
        self.filters = count

    def listen(self, control: Control, link: Link, frame, out):
        """Return what serves the bus: called without arguments, it does what chip_joint.serve_bus does."""
        return lambda: self._serve(control, link, frame, out)

    def _serve(self, c: Control, link: Link, frame, out):
        for _ in range(FRAMES_MOST):
            came = self.can_receive(frame)
            if came < 0:
                return -1
            left = take_frame(link, c.io, came, frame)
            if left >= 0:
                return left
            if left == WANTS_REPLY:
                identifier = write_reply(link, c.loop, c.settings, c.state, self._reply, out)
                if identifier and self.can_send(identifier, out, REPLY_LENGTH) == 0:
                    c.run.unsent_frames = (c.run.unsent_frames + 1) & 0x3FFFFFFF
        return -1

    def quiet(self):
        """Stop for good what runs beside the main loop: the bridge is off, until the next reset."""
        self.bridge = 0
        self.handler = None

    def feed_watchdog(self):
        """Put the watchdog off."""
        self.fed = (self.fed + 1) & 0x3FFFFFFF

    def can_receive(self, frame):
        """Copy the oldest frame into ``frame``; return its identifier + its length << 11, or -1."""
        identifier = self._in.take(frame)
        return identifier if identifier < 0 else identifier | self._in.length << 11

    def can_send(self, identifier, frame, length):
        """Send a frame; return 0 if there is no room for it."""
        return self.sent.put(identifier, frame, length)

    def deliver(self, identifier, frame, length):
        """Let a frame arrive from the bus; return 0 if the receive queue is full."""
        return self._in.put(identifier, frame, length)

    def reset(self, to_loader):
        """Start the board anew."""
        self.resets += 1
        self.to_loader = to_loader


class Frames:
    """A queue of frames in preallocated memory."""

    def __init__(self):
        self._words = array("H", [0] * (4 * _QUEUE))
        self._heads = array("i", [0] * (2 * _QUEUE))
        self._first = 0
        self.count = 0
        self.length = 0

    def put(self, identifier, frame, length):
        """Append a frame; return 0 if there is no room."""
        if self.count >= _QUEUE:
            return 0
        at = (self._first + self.count) % _QUEUE
        for word in range(4):
            self._words[4 * at + word] = frame[word]
        self._heads[2 * at] = identifier
        self._heads[2 * at + 1] = length
        self.count += 1
        return 1

    def take(self, frame):
        """Copy the oldest frame out and forget it; return its identifier, or -1. ``length`` is its length."""
        if self.count == 0:
            return -1
        at = self._first
        for word in range(4):
            frame[word] = self._words[4 * at + word]
        self.length = self._heads[2 * at + 1]
        self._first = (at + 1) % _QUEUE
        self.count -= 1
        return self._heads[2 * at]
