"""The readings of a joint's board: shunt currents, encoders, bus, thermistor, each with its faults.

Amplifier counts have an offset, noise, 12 bits and an end. The rotor encoder answers each read with the angle at the
read before, as AS5047P's frames do (firmware/encoders.py); its jitter and glitches are seeded.
"""

import random
from dataclasses import dataclass
from math import sin, tau

from firmware.board_sim import SimBoard

from ...robot.actuators import Bldc
from ...robot.joint_units import Board
from ...robot.thermistor import part_of
from .model import Motor

NOISE_COUNTS = 1.5  # rms, of an amplifier with its ADC (assumed)
CONTROLLER_C = 40.0


@dataclass
class Wrong:
    """Faults that a scenario switches on while running."""

    shunt_offset_counts: float = 0.0  # of phase a, on top of its own
    rotor_lost: bool = False
    joint_turned_rad: float = 0.0  # the joint encoder's magnet has slipped by that
    thermistor: str = ""  # "open" or "short"
    supply_V: float | None = None
    glitch_share: float = 0.0  # of rotor readings
    eccentric_rad: float = 0.0  # amplitude by which an off-centre magnet bends the rotor's readings
    eccentric_at_rad: float = 0.0  # where it bends them not at all
    shunt_gain: float = 1.0  # of phase a
    rotor_noise: float = 0.3  # rc rms for each count of an amplifier
    joint_stuck: bool = False  # the joint encoder's magnet has come off


class Sensors:
    """Writes the board's readings."""

    def __init__(self, bldc: Bldc, wrong: Wrong, seed: int = 0) -> None:
        self.bldc, self.wrong, self.board = bldc, wrong, Board()
        self.offsets_counts = (9.0, -14.0, 5.0)
        self._random = random.Random(seed)
        volt = self.board.adc_volt / 4096
        self._per_A = bldc.drive.shunt_ohm * bldc.drive.amplifier_gain / volt
        self._noise = [self._random.gauss(0, NOISE_COUNTS) for _ in range(4096)]
        self._at = 0
        self._answer = 0  # of the rotor encoder to the next read
        self.glitches = 0  # readings that were none

    def read_fast(self, motor: Motor, out: SimBoard) -> None:
        """Write the readings for a current step; this also takes the encoder's answer for the next one."""
        at = self._at
        noise, offsets, scale, raw = self._noise, self.offsets_counts, self._per_A, out.raw
        a, b, c = motor.phases_A
        raw[0] = _counts(a * scale * self.wrong.shunt_gain + offsets[0] + noise[at] + self.wrong.shunt_offset_counts)
        raw[1] = _counts(b * scale + offsets[1] + noise[at + 1])
        raw[2] = _counts(c * scale + offsets[2] + noise[at + 2])
        self._at = (at + 3) % 4090
        if self.wrong.rotor_lost:
            out.rotor = -1
        elif self.wrong.glitch_share and self._random.random() < self.wrong.glitch_share:
            out.rotor = self._random.randrange(16384)
            self.glitches += 1
        else:
            out.rotor = self._answer
        rotor_rad = motor.rotor_rad
        if self.wrong.eccentric_rad:
            rotor_rad += self.wrong.eccentric_rad * sin(rotor_rad - self.wrong.eccentric_at_rad)
        self._answer = int(rotor_rad / tau * 16384 + self.wrong.rotor_noise * noise[at]) & 16383

    def read_slow(self, motor: Motor, out: SimBoard) -> None:
        """Write the readings for the motion tick and the slow tick."""
        full_V = self.board.adc_volt * self.board.bus_divider
        out.bus = min(4095, round(motor.bus_V / full_V * 4096 + self._noise[self._at]))
        joint_rad = 0.0 if self.wrong.joint_stuck else motor.joint_rad
        out.joint = int((joint_rad + self.wrong.joint_turned_rad) / tau * 16384 // 1) & 16383
        out.thermistor = self._thermistor(motor.winding_C)
        cal1, cal2 = self.board.mcu_cal1, self.board.mcu_cal2
        out.mcu = round(cal1 + (CONTROLLER_C - 30) * (cal2 - cal1) / 80)

    def _thermistor(self, winding_C: float) -> int:
        if self.wrong.thermistor == "open":
            return 4095
        if self.wrong.thermistor == "short":
            return 0
        return part_of(self.bldc, self.board).counts(winding_C)


def _counts(value: float) -> int:
    counts = int(value + 2048.5)
    return 0 if counts < 0 else 4095 if counts > 4095 else counts
