"""One simulated joint: the firmware's own application on the simulated board, with an ideal current loop under it.

A robot of twelve needs time for twelve, so there is one current step a millisecond instead of ten, and the motor
gives exactly the current that the cascade asks for (host/motor has the real one, on the bench). The shunts are told
that current, so that the firmware's own checks of it go on.
"""

import tempfile
from collections.abc import Callable
from math import cos, sin, tau
from pathlib import Path

from firmware.board_sim import SimBoard
from firmware.joint import Joint
from shared.joint import layout as j
from shared.wire.identity import board_id

from ..joint_gains import Board, JointSetup, joint_blocks
from ..robot_actuators import Bldc

STEP_PLACES = (
    j.F_KP, j.F_KI, j.F_PERIOD, j.F_HALF, j.F_SPAN, j.F_PULSE, j.F_WINDOW, j.F_TRIP_SQUARE,
)  # fmt: skip
ROOM_C = 25.0
CONTROLLER_C = 40.0
JUMP = 400  # rotor counts a current step: more is a glitch to the firmware, so a fast joint gets more steps


class JointBoard(SimBoard):
    """The simulated board at one current step a millisecond, with hardware filters that filter."""

    STEP_US = 1000

    def __init__(self, unique_id: bytes, send: Callable[[int, bytes], bool]) -> None:
        super().__init__(unique_id)
        self._send = send
        self._pairs: list[tuple[int, int]] = []

    def can_filters(self, pairs, count):  # type: ignore[no-untyped-def]
        """See SimBoard."""
        self._pairs = [(pairs[2 * i], pairs[2 * i + 1]) for i in range(count)]

    def hears(self, identifier: int) -> bool:
        """Return whether a filter lets a frame through."""
        return any(identifier & mask == wanted & mask for wanted, mask in self._pairs)

    def can_send(self, identifier, frame, length):  # type: ignore[no-untyped-def]
        """See SimBoard."""
        return int(self._send(identifier, memoryview(frame).cast("B")[:length].tobytes()))


class SimJoint:
    """A joint of the robot, by node 1 .. 12. ``tick`` is a millisecond; ``power`` False is a joint without supply."""

    def __init__(
        self, bldc: Bldc, setup: JointSetup, node: int, angle_rad: float = 0.0, board_number: int | None = None
    ) -> None:
        self.bldc, self.setup, self.node = bldc, setup, node
        self.angle_rad = angle_rad
        self.unique_id = bytes((board_number or node, *range(11)))
        self.number = board_id(self.unique_id)
        self.send: Callable[[int, bytes], bool] = lambda identifier, data: True
        self.power = True
        self.volts = bldc.drive.bus_voltage_V
        self.resets = 0
        self.torque_Nm = 0.0
        self._reference = Board()
        self.blocks = joint_blocks(bldc, setup)
        units = self.blocks.units
        self._counts_per_rad = 16384 * bldc.gear.ratio * setup.sign / tau
        self._kt_Nm_A = bldc.motor.torque_constant_Nm_A * bldc.gear.ratio * bldc.gear.efficiency * setup.sign
        self._ampere = units.ampere_per_cu
        volt_per_count = self._reference.adc_volt / 4096
        self._counts_per_A = bldc.drive.shunt_ohm * bldc.drive.amplifier_gain / volt_per_count
        self._folder = tempfile.TemporaryDirectory(prefix="caramelo-joint-")
        self._words = memoryview(bytearray(8))
        self.now_us = 0
        self._boot()

    def _boot(self) -> None:
        self.board = JointBoard(self.unique_id, self._send)
        self.board.now_us = self.now_us
        self._set_sensors()
        self._set_encoders()
        self.joint = Joint(self.board, str(Path(self._folder.name) / "joint.bin"))
        control = self.joint.control
        for place in STEP_PLACES:
            control.foc[place] = self.blocks.foc[place]
        control.cfg[:] = self.blocks.cfg
        control.curve[:] = self.blocks.curve
        control.cfg[j.K_CALIBRATED] = 1
        control.cfg[j.K_ELEC_OFFSET] = 0
        self.joint.set_node(self.node)
        self.joint.start()

    def _send(self, identifier: int, data: bytes) -> bool:
        return self.send(identifier, data)

    def _set_sensors(self) -> None:
        board = self.board
        full_V = self._reference.adc_volt * self._reference.bus_divider
        board.bus = min(4095, round(self.volts / full_V * 4096))
        thermistor = self.bldc.thermal.thermistor_25C_ohm
        board.thermistor = round(4096 * thermistor / (thermistor + self._reference.thermistor_pull_up_ohm))
        cal1, cal2 = self._reference.mcu_cal1, self._reference.mcu_cal2
        board.mcu = round(cal1 + (CONTROLLER_C - 30) * (cal2 - cal1) / 80)

    def _set_encoders(self) -> int:
        counts = int(self.angle_rad * self._counts_per_rad)
        self.board.rotor = counts & 16383
        self.board.joint = int(self.angle_rad / tau * 16384) & 16383
        self._counts = counts
        return counts

    def power_cycle(self) -> None:
        """Take the supply away and give it back: memory is lost, what was saved is not."""
        self.resets += 1
        self.power = True
        self.torque_Nm = 0.0
        self._boot()

    def set_volts(self, volts: float) -> None:
        """Change the supply voltage."""
        self.volts = volts
        self._set_sensors()

    def deliver(self, identifier: int, data: bytes) -> None:
        """Let a frame arrive; the main loop takes it at once, as it does between two milliseconds."""
        if not self.power or not self.board.hears(identifier):
            return
        self._words[: len(data)] = data
        self.board.deliver(identifier, self._words.cast("H"), len(data))
        self.joint.poll()
        if not self.board.bridge:
            self.torque_Nm = 0.0

    def tick(self, now_us: int, angle_rad: float) -> None:
        """Do a millisecond with the motor at an angle at the joint's side of the gear; sets ``torque_Nm``."""
        self.now_us, self.angle_rad = now_us, angle_rad
        if not self.power:
            return
        board, control = self.board, self.joint.control
        board.now_us = now_us
        before = self._counts
        counts = self._set_encoders()
        current_A = control.foc[j.F_Q_REF] * self._ampere if board.bridge else 0.0
        self._show_current(current_A, counts)
        for part in range(before + JUMP, counts, JUMP) if counts > before else range(before - JUMP, counts, -JUMP):
            board.rotor = part & 16383
            board.handler()
        board.rotor = counts & 16383
        board.handler()
        self.joint.poll()
        self.torque_Nm = control.foc[j.F_Q_REF] * self._ampere * self._kt_Nm_A if board.bridge else 0.0
        if board.resets:
            self.power_cycle()

    def _show_current(self, current_A: float, counts: int) -> None:
        """Write what the shunts read when the motor carries a q current (Park and Clarke turned back)."""
        angle = tau * self.bldc.motor.pole_pairs * counts / 16384
        q = current_A * self._counts_per_A
        alpha, half = -q * sin(angle), 0.8660254037844386 * q * cos(angle)
        raw = self.board.raw
        raw[0] = round(2048 + alpha)
        raw[1] = round(2048 - alpha / 2 + half)
        raw[2] = round(2048 - alpha / 2 - half)

    def close(self) -> None:
        """Remove what the joint has saved."""
        self._folder.cleanup()
