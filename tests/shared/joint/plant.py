"""A joint, and a plain motor behind its blocks: dq equations, one inertia, encoders, ADC counts, no noise.

As on the board, the rotor's reading is one step old and duties act one step later.
"""

import math

from host.robot.file import load_robot
from host.robot.joint_gains import joint_blocks
from host.robot.joint_units import Board, JointSetup
from shared.joint import layout as j
from shared.joint.bend import corrected_rotor
from shared.joint.cogging import cogging_step
from shared.joint.commission_state import Commission
from shared.joint.current import current_repair, current_step
from shared.joint.probe import probe_step
from shared.joint.thermal import slow_tick
from shared.joint.tick import joint_reset, motion_tick

SUBSTEPS = 4
ROOT_3 = math.sqrt(3)
LOWER_RAD, UPPER_RAD = -1.0, 1.9
BLDC = load_robot("parallel").actuator


def changed(**tables):
    """Return the motor's data with some values changed: ``drive={"pwm_hz": 10000}``."""
    update = {name: getattr(BLDC, name).model_copy(update=values) for name, values in tables.items()}
    return BLDC.model_copy(update=update)


def made(bldc=BLDC, board=None, **setup):
    """Return the blocks of a joint."""
    return joint_blocks(bldc, JointSetup(LOWER_RAD, UPPER_RAD, **setup), board)


class Plant:
    """One joint at its real rates; ``blocked`` holds the rotor, ``swapped`` exchanges phases b and c at the motor."""

    def __init__(self, elec_offset_brad=0, direction=1, commissioned=True, inertia_kg_m2=0.01, **setup):
        self.bldc, self.board = BLDC, Board()
        self.blocks = blocks = made(inertia_kg_m2=inertia_kg_m2, **setup)
        self.commission = Commission()
        self.loop, self.settings, self.state, self.io = blocks.loop, blocks.settings, blocks.state, blocks.io
        self.units = blocks.units
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
        cos_e, sin_e = math.cos(e), math.sin(e)
        alpha = self.i_d * cos_e - self.i_q * sin_e
        half = ROOT_3 / 2 * (self.i_d * sin_e + self.i_q * cos_e)
        a, b, c = alpha, half - alpha / 2, -half - alpha / 2
        if self.swapped:
            b, c = c, b
        scale, offsets, raw = self.units.ampere_per_cu * 6, self.offsets, self.loop.raw
        raw[0] = max(0, min(4095, round(a / scale + offsets[0])))
        raw[1] = max(0, min(4095, round(b / scale + offsets[1])))
        raw[2] = max(0, min(4095, round(c / scale + offsets[2])))

    def voltages(self):
        a, b, c = self.acting[0] * self.bus, self.acting[1] * self.bus, self.acting[2] * self.bus
        if self.swapped:
            b, c = c, b
        return (2 * a - b - c) / 3, (b - c) / ROOT_3

    def current_step(self):
        duty, period = self.loop.duty, self.loop.period
        self.acting = [duty[0] / period, duty[1] / period, duty[2] / period]
        self.read_currents()
        rotor, self.answer = corrected_rotor(self.loop, self.answer), self.rotor()
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
        """Go on by ``seconds``: most of a test's time is spent here, so it works on its own names."""
        v_alpha, v_beta = self.voltages()
        h, turns, offset = seconds / SUBSTEPS, self.direction * self.pp, self.true_offset
        ohm, henry, psi, per_henry, per_ampere = self.r, self.l, self.psi, h / self.l, 1.5 * self.pp * self.psi
        i_d, i_q = (self.i_d, self.i_q) if self.bridge else (0.0, 0.0)
        speed, angle, friction = self.speed, self.angle, self.friction
        for _ in range(SUBSTEPS):
            if self.bridge:
                e, w = turns * angle + offset, turns * speed
                cos_e, sin_e = math.cos(e), math.sin(e)
                d = i_d + per_henry * (v_alpha * cos_e + v_beta * sin_e - ohm * i_d + w * henry * i_q)
                i_q += per_henry * (v_beta * cos_e - v_alpha * sin_e - ohm * i_q - w * henry * i_d - w * psi)
                i_d = d
            torque = per_ampere * i_q * self.direction - self.load_Nm
            if -0.05 < speed < 0.05 and -friction < torque < friction:
                speed = 0.0
            else:
                speed += h * (torque - (friction if (speed or torque) > 0 else -friction)) / self.inertia
            if self.blocked:
                speed = 0.0
            angle += h * speed
        self.i_d, self.i_q, self.speed, self.angle = i_d, i_q, speed, angle

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

    def run(self, count, setpoint=True):
        """So many milliseconds."""
        for _ in range(count):
            self.tick(setpoint)

    def current_A(self):
        return self.state.current_reference * self.units.ampere_per_cu

    def wire_position(self, rad):
        return round(rad / math.tau * 65536)

    def wire_velocity(self, rad_s):
        return round(rad_s / math.tau * 4096)
