"""The firmware's own joint on the simulated board, driven by integers; runs on CPython and, as it is, on MicroPython.

There is one current step a millisecond instead of ten. Nothing here knows a unit: angles are encoder counts, currents
ADC counts, so that both runtimes compute the same to the bit.
"""

from array import array

from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.joint_store import MISSING
from firmware.settings import Memory


class JointBoard(SimBoard):
    """The simulated board at one current step a millisecond; ``room`` frames find place on the bus."""

    STEP_US = 1000

    def __init__(self, unique_id: bytes) -> None:
        super().__init__(unique_id)
        self.room = 0
        self.pairs: list[tuple[int, int]] = []

    def can_filters(self, pairs, count):  # type: ignore[no-untyped-def]
        """See SimBoard."""
        self.pairs = [(pairs[2 * i], pairs[2 * i + 1]) for i in range(count)]

    def can_send(self, identifier, frame, length):  # type: ignore[no-untyped-def]
        """See SimBoard."""
        if self.sent.count >= self.room:
            return 0
        return self.sent.put(identifier, frame, length)


class Inside:
    """What a joint is inside, its settings included, which it keeps when it starts anew.

    ``bridge``, ``q_ref`` (cu), ``resets`` and the filters ``pairs`` are what the last call left.
    """

    def __init__(self, unique_id: bytes) -> None:
        self._unique_id = unique_id
        self._settings = Memory()
        self._words = array("H", [0] * 4)
        self.bridge = self.q_ref = self.resets = 0
        self.pairs: list[tuple[int, int]] = []

    def boot(self, now_us, sensors, rotor, joint, node, stored):  # type: ignore[no-untyped-def]
        """Restart; a board without saved parameters gets this node and these parameters."""
        self.board = JointBoard(self._unique_id)
        self.board.now_us = now_us
        self._set_sensors(sensors)
        self.board.rotor, self.board.joint = rotor & 16383, joint
        self.joint = Joint(self.board, self._settings)
        if self.joint.loaded == MISSING:
            self._configure(stored)
            self.joint.set_node(node)
        self.joint.start()
        self._note()

    def _configure(self, stored):  # type: ignore[no-untyped-def]
        control = self.joint.control
        self.joint.parameters.take(stored)
        control.settings.commissioned = 1
        control.settings.elec_offset = 0

    def _set_sensors(self, sensors):  # type: ignore[no-untyped-def]
        """Take the readings of bus voltage, thermistor and microcontroller."""
        self.board.bus, self.board.thermistor, self.board.mcu = sensors[0], sensors[1], sensors[2]

    def _note(self) -> None:
        control = self.joint.control
        self.bridge, self.q_ref = self.board.bridge, control.loop.reference_q
        self.resets, self.pairs = self.board.resets, self.board.pairs

    def frame(self, identifier, data, room):  # type: ignore[no-untyped-def]
        """Let a frame arrive; the main loop takes it at once, as it does between two milliseconds."""
        words = self._words
        for i in range(4):
            words[i] = 0
        for i, byte in enumerate(data):
            words[i >> 1] |= byte << (8 * (i & 1))
        self.board.room = room
        self.board.deliver(identifier, words, len(data))
        self.joint.poll()
        self._note()

    def tick(self, now_us, sensors, rotors, joint, raw, room):  # type: ignore[no-untyped-def]
        """Do a millisecond: a current step for each of the readings ``rotors``, then the main loop."""
        board = self.board
        board.now_us, board.joint, board.room = now_us, joint, room
        self._set_sensors(sensors)
        for phase in range(3):
            board.raw[phase] = raw[phase]
        for rotor in rotors:
            board.rotor = rotor & 16383
            board.handler()
        self.joint.poll()
        self._note()

    def sent(self):  # type: ignore[no-untyped-def]
        """Return the frames sent since the last call, (identifier, data)."""
        frames = []
        queue, words = self.board.sent, self._words
        identifier = queue.take(words)
        while identifier >= 0:
            data = bytes((words[i >> 1] >> (8 * (i & 1))) & 255 for i in range(queue.length))
            frames.append((identifier, data))
            identifier = queue.take(words)
        return frames

    def close(self) -> None:
        """Nothing is held; a joint in a VM ends it."""
        return
