"""A plain motor behind the joint's blocks, for tests: dq equations, one inertia, encoders, ADC counts, no noise.

As on the board, the rotor's reading is one step old and duties act one step later.
"""

import math

from host.robot.file import load_robot
from host.robot.joint_gains import JointBlocks, joint_blocks
from host.robot.joint_units import Board, JointSetup
from shared.joint import layout as j
from shared.joint.bend import straightened
from shared.joint.cogging import cogging_step
from shared.joint.commission_state import Commission
from shared.joint.current import current_repair, current_step
from shared.joint.probe import probe_step
from shared.joint.thermal import slow_tick
from shared.joint.tick import joint_reset, motion_tick

SUBSTEPS = 4


class Plant:
    """One joint at its real rates; ``blocked`` holds the rotor, ``swapped`` exchanges phases b and c at the motor."""

    def __init__(self, elec_offset_brad=0, direction=1, commissioned=True, inertia_kg_m2=0.01, **setup):
        self.bldc = load_robot("parallel").actuator
        self.setup = JointSetup(lower_rad=-1.0, upper_rad=1.9, inertia_kg_m2=inertia_kg_m2, **setup)
        self.board = Board()
        self.blocks: JointBlocks = joint_blocks(self.bldc, self.setup, self.board)
        self.commission = Commission()
        self.loop, self.settings, self.state, self.io = (
            self.blocks.loop,
            self.blocks.settings,
            self.blocks.state,
            self.blocks.io,
        )
        self.units = self.blocks.units
        motor = self.bldc.motor
        self.pp, self.r, self.l = motor.pole_pairs, motor.resistance_ohm, motor.inductance_H
        self.psi = motor.torque_constant_Nm_A / 1.5 / self.pp
        self.inertia = motor.rotor_inertia_kg_m2 + inertia_kg_m2 / self.bldc.gear.ratio**2
        self.friction = motor.coulomb_Nm
        self.load_Nm = 0.0  # at the rotor
        self.true_offset = elec_offset_brad / 65536 * math.tau
        self.direction = direction
        self.angle = 0.3  # rad of the rotor, grows with the encoder
        self.speed = 0.0
        self.i_d = self.i_q = 0.0
        self.bus = 24.0
        self.blocked = self.swapped = False
        self.offsets = [2048.0, 2048.0, 2048.0]
        self.bridge = False
        self.trips = 0
        self.ticks = 0
        if commissioned:
            self.settings.commissioned = 1
            self.settings.direction = direction
            self.settings.elec_offset = elec_offset_brad
        self.answer = self.rotor()  # of the encoder to the next read
        self.acting = [0.5, 0.5, 0.5]  # duties
        self.read_slow()
        joint_reset(self.loop, self.settings, self.state, self.rotor())
        self.io.hardware_ready = self.io.hash_ok = self.io.session = 1
        slow_tick(self.settings, self.state, self.io, self.blocks.curve)

    def rotor(self):
        return int(self.angle / math.tau * 16384) & 16383

    def joint_rad(self):
        return self.angle / self.units.gear

    def electrical(self):
        return self.direction * self.pp * self.angle + self.true_offset

    def read_slow(self):
        self.io.bus_raw = round(self.bus / (self.board.adc_volt * self.board.bus_divider) * 4096)
        self.io.thermistor_raw = 2048
        self.io.mcu_raw = 980
        self.io.joint_raw = int(self.joint_rad() / math.tau * 16384) & 16383
        self.io.joint_valid = 1

    def read_currents(self):
        e = self.electrical()
        alpha = self.i_d * math.cos(e) - self.i_q * math.sin(e)
        beta = self.i_d * math.sin(e) + self.i_q * math.cos(e)
        half = math.sqrt(3) / 2 * beta
        phases = [alpha, half - alpha / 2, -half - alpha / 2]
        if self.swapped:
            phases[1], phases[2] = phases[2], phases[1]
        scale = self.units.ampere_per_cu * 6
        for k in range(3):
            self.loop.raw[k] = max(0, min(4095, round(phases[k] / scale + self.offsets[k])))

    def voltages(self):
        duties = [duty * self.bus for duty in self.acting]
        if self.swapped:
            duties[1], duties[2] = duties[2], duties[1]
        a, b, c = duties
        return (2 * a - b - c) / 3, (b - c) / math.sqrt(3)

    def current_step(self):
        self.acting = [self.loop.duty[k] / self.loop.period for k in range(3)]
        self.read_currents()
        rotor, self.answer = straightened(self.loop, self.answer), self.rotor()
        if self.loop.waves:
            cogging_step(self.loop, rotor)
        code = current_step(rotor, 0, self.loop)
        if code:
            code = current_repair(code, rotor, 0, self.loop)
        if code:
            self.bridge = False
            self.trips += 1
        if self.loop.probing:
            probe_step(self.loop)
        self.move(1e-4)

    def move(self, seconds):
        v_alpha, v_beta = self.voltages()
        h = seconds / SUBSTEPS
        for _ in range(SUBSTEPS):
            e = self.electrical()
            w = self.direction * self.pp * self.speed
            if self.bridge:
                v_d = v_alpha * math.cos(e) + v_beta * math.sin(e)
                v_q = -v_alpha * math.sin(e) + v_beta * math.cos(e)
                i_d = self.i_d + h / self.l * (v_d - self.r * self.i_d + w * self.l * self.i_q)
                self.i_q += h / self.l * (v_q - self.r * self.i_q - w * self.l * self.i_d - w * self.psi)
                self.i_d = i_d
            else:
                self.i_d = self.i_q = 0.0
            torque = 1.5 * self.pp * self.psi * self.i_q * self.direction - self.load_Nm
            if abs(self.speed) < 0.05 and abs(torque) < self.friction:
                self.speed = 0.0
            else:
                sign = math.copysign(1, self.speed) if self.speed else math.copysign(1, torque)
                self.speed += h * (torque - sign * self.friction) / self.inertia
            if self.blocked:
                self.speed = 0.0
            self.angle += h * self.speed

    def tick(self, setpoint=True):
        """One millisecond: ten current steps, the motion tick, and a set-point every fifth."""
        for _ in range(10):
            self.current_step()
        self.read_slow()
        if setpoint and self.ticks % 5 == 0:
            self.io.sequence = (self.io.sequence + 1) & 0xFFFF
        self.bridge = motion_tick(self.loop, self.settings, self.state, self.io, self.commission) != j.TORQUE_OFF
        if self.ticks % 100 == 99:
            slow_tick(self.settings, self.state, self.io, self.blocks.curve)
        self.ticks += 1

    def current_A(self):
        return self.state.current_reference * self.units.ampere_per_cu

    def wire_position(self, rad):
        return round(rad / math.tau * 65536)

    def wire_velocity(self, rad_s):
        return round(rad_s / math.tau * 4096)
