"""One simulated joint: the firmware's own application on the simulated board, with an ideal current loop under it.

A robot of twelve needs time for twelve, so there is one current step a millisecond instead of ten, and the motor
gives exactly the current that the cascade asks for (host/sim/motor has the real one, on the bench). The shunts are told
that current, so that the firmware's own checks of it go on. The application is in this process, or in a MicroPython
VM (vm_joint.py); this file is what surrounds it: gear, encoders, supply, SI.
"""

from collections.abc import Callable
from math import cos, sin, tau

from shared.wire.identity import board_id

from ...robot.actuators import Bldc
from ...robot.joint_gains import joint_blocks
from ...robot.joint_units import Board, JointSetup
from ...robot.thermistor import part_of
from .vm.inside import Inside
from .vm_joint import VmInside

ROOM_C = 25.0
CONTROLLER_C = 40.0
JUMP = 400  # rotor counts a current step: more is a glitch to the firmware, so a fast joint gets more steps
ADC_MOST = 4095

MakeInside = Callable[[bytes], Inside | VmInside]


class SimJoint:
    """A joint of the robot, by node 1 .. 12. ``tick`` is a millisecond; ``power`` False is a joint without supply."""

    def __init__(
        self,
        bldc: Bldc,
        setup: JointSetup,
        node: int,
        angle_rad: float = 0.0,
        board_number: int | None = None,
        make: MakeInside = Inside,
    ) -> None:
        self.bldc, self.setup, self.node = bldc, setup, node
        self.angle_rad = angle_rad
        self.unique_id = bytes((board_number or node, *range(11)))
        self.number = board_id(self.unique_id)
        self.send: Callable[[int, bytes], bool] = lambda identifier, data: True
        self.room: Callable[[], int] = lambda: 1
        self.power = True
        self.volts = bldc.drive.bus_voltage_V
        self.winding_C = ROOM_C
        self.torque_Nm = 0.0
        self._reference = Board()
        self.blocks = joint_blocks(bldc, setup)
        self._counts_per_rad = 16384 * bldc.gear.ratio * setup.sign / tau
        self._kt_Nm_A = bldc.motor.torque_constant_Nm_A * bldc.gear.ratio * bldc.gear.efficiency * setup.sign
        self._ampere = self.blocks.units.ampere_per_cu
        volt_per_count = self._reference.adc_volt / 4096
        self._counts_per_A = bldc.drive.shunt_ohm * bldc.drive.amplifier_gain / volt_per_count
        self.now_us = 0
        self._pairs: list[tuple[int, int]] = []
        self._heard: dict[int, bool] = {}
        self._read = self._sensors()
        self.inside = make(self.unique_id)
        self._boot()

    def _boot(self) -> None:
        rotor, joint = self._encoders()
        self.inside.boot(self.now_us, self._read, rotor, joint, self.node, self.blocks.stored())
        self._hand_over()

    def _hand_over(self) -> None:
        for identifier, data in self.inside.sent():
            self.send(identifier, data)

    @property
    def bridge(self) -> bool:
        """Return whether the joint makes torque."""
        return self.power and bool(self.inside.bridge)

    def _sensors(self) -> tuple[int, int, int]:
        """Return what the board reads of its supply, its thermistor and its microcontroller, ADC counts."""
        reference = self._reference
        full_V = reference.adc_volt * reference.bus_divider
        bus = min(ADC_MOST, round(self.volts / full_V * 4096))
        thermistor = part_of(self.bldc, reference).counts(self.winding_C)
        mcu = round(reference.mcu_cal1 + (CONTROLLER_C - 30) * (reference.mcu_cal2 - reference.mcu_cal1) / 80)
        return bus, thermistor, mcu

    def _encoders(self) -> tuple[int, int]:
        """Return the rotor's counts, turns included, and the joint encoder's reading."""
        self._counts = int(self.angle_rad * self._counts_per_rad)
        return self._counts, int(self.angle_rad / tau * 16384) & 16383

    def power_cycle(self) -> None:
        """Switch the supply off and on: memory is lost, saved parameters are not."""
        self.power = True
        self.torque_Nm = 0.0
        self._boot()

    def hears(self, identifier: int) -> bool:
        """Return whether a hardware filter lets a frame through."""
        if self.inside.pairs is not self._pairs:
            self._pairs, self._heard = self.inside.pairs, {}
        if identifier not in self._heard:
            self._heard[identifier] = any(identifier & mask == wanted & mask for wanted, mask in self._pairs)
        return self._heard[identifier]

    def deliver(self, identifier: int, data: bytes) -> None:
        """Let a frame arrive."""
        if not self.power or not self.hears(identifier):
            return
        self.inside.frame(identifier, data, self.room())
        self._hand_over()
        if not self.inside.bridge:
            self.torque_Nm = 0.0

    def tick(self, now_us: int, angle_rad: float) -> None:
        """Do a millisecond with the motor at an angle at the joint's side of the gear; sets ``torque_Nm``."""
        self.now_us, self.angle_rad = now_us, angle_rad
        if not self.power:
            return
        before = self._counts
        counts, joint = self._encoders()
        parts = range(before + JUMP, counts, JUMP) if counts > before else range(before - JUMP, counts, -JUMP)
        inside, current_A = self.inside, self._current_A()
        rotors = [part & 16383 for part in (*parts, counts)]
        inside.tick(now_us, self._read, rotors, joint, self._shunts(current_A, counts), self.room())
        self._hand_over()
        self.torque_Nm = self._current_A() * self._kt_Nm_A
        if inside.resets:
            self.power_cycle()

    def _current_A(self) -> float:
        return self.inside.q_ref * self._ampere if self.inside.bridge else 0.0

    def _shunts(self, current_A: float, counts: int) -> tuple[int, ...]:
        """Return the shunts' readings for a q current (inverse Park and Clarke)."""
        angle = tau * self.bldc.motor.pole_pairs * counts / 16384
        q = current_A * self._counts_per_A
        alpha, half = -q * sin(angle), 0.8660254037844386 * q * cos(angle)
        raw = (2048 + alpha, 2048 - alpha / 2 + half, 2048 - alpha / 2 - half)
        return tuple(min(max(round(count), 0), ADC_MOST) for count in raw)

    def set_volts(self, volts: float) -> None:
        """Change the supply voltage."""
        self.volts = volts
        self._read = self._sensors()

    def set_winding(self, winding_C: float) -> None:
        """Change the temperature that the thermistor feels."""
        self.winding_C = winding_C
        self._read = self._sensors()

    def close(self) -> None:
        """End the joint's process; its saved parameters are gone."""
        self.inside.close()
