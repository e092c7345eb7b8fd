"""Brushless joints as drives of the walking simulator: the joint's own spring or cascade at its rate, one per drive.

Reduced: the current loop is taken as exact (it settles within a millisecond), gear play and spring are left out, the
gear's loss opposes the motion. tests/host/sim/motor compares it with the full model: the same way within half a degree,
the same current below 15 Hz within 5 %. Energy is counted with and without that of braking motors.
"""

from collections.abc import Sequence
from math import tau
from typing import Any

from shared.joint.cascade import cascade_reset, cascade_step
from shared.wire.names import MODE_IMPEDANCE, MODE_POSITION
from sim2d.actuator import Given, Told
from sim2d.model import GRAVITY_M_S2, PLANAR_JOINTS
from sim2d.recording import Recording

from ...robot.actuators import Bldc
from ...robot.joint_gains import impedance_gains, joint_blocks
from ...robot.joint_heat import COPPER_PER_K
from ...robot.joint_units import JointSetup
from ...robot.mass import leg_inertia_kg_m2
from ...robot.model import Robot
from ..energy import drives_power_W

CYCLE_MS = 20  # between goals of a planner at 50 Hz; set-points go straight from one to the next
SETPOINT_MS = 5  # 200 Hz on the bus
LOSS_SPEED_RAD_S = 0.1  # below it the gear's loss fades out, so that it does not chatter at rest
WIDE_RAD = 3.1
SETTLE_S = 0.5  # not counted: the robot is put down


class JointMotor:
    """One drive: blocks of shared/joint with the motor's heat and energy beside them; ``spring``: in impedance mode."""

    def __init__(self, bldc: Bldc, inertia_kg_m2: float, spring: bool = False) -> None:
        self.blocks = joint_blocks(bldc, JointSetup(-WIDE_RAD, WIDE_RAD, inertia_kg_m2=inertia_kg_m2))
        self.bldc, u = bldc, self.blocks.units
        state, io = self.blocks.state, self.blocks.io
        state.mode = io.mode = MODE_IMPEDANCE if spring else MODE_POSITION
        if spring:
            io.stiffness, io.damping = impedance_gains(bldc)
        state.bus = round(bldc.drive.bus_voltage_V / u.volt_per_vu)
        self.winding_C = self.housing_C = 25.0
        self.motor_Nm = self.largest_Nm = self.hottest_C = 0.0
        self.drawn_J = self.returned_J = 0.0
        self._goal_rad: float | None = None
        self._from_rad = self._slope_rad_s = 0.0
        self._cycle_ms = CYCLE_MS
        self._per_rad, self._per_rad_s = 1 / u.rad_per_rc, 1 / u.rad_s_per_rate
        self._square = self._time_s = 0.0

    def torque(self, goal_rad: float, position_rad: float, speed_rad_s: float, dt_s: float) -> float:
        """Return the torque at the joint for the next ``dt_s``, a millisecond, after one tick of the cascade."""
        blocks = self.blocks
        state = blocks.state
        state.position = round(position_rad * self._per_rad)
        state.velocity = round(speed_rad_s * self._per_rad_s)
        state.current_limit = round(blocks.settings.current_max * self._share())
        if goal_rad != self._goal_rad:
            self._take_goal(goal_rad)
        if self._cycle_ms % SETPOINT_MS == 0 and self._cycle_ms <= CYCLE_MS:
            self._send_setpoint()
        self._cycle_ms += 1
        ampere = cascade_step(blocks.settings, state, blocks.io) * blocks.units.ampere_per_cu
        motor_Nm = ampere * self.bldc.motor.torque_constant_Nm_A * blocks.units.gear
        slow = max(-1.0, min(1.0, speed_rad_s / LOSS_SPEED_RAD_S))
        self.motor_Nm = motor_Nm
        self._account(ampere, motor_Nm, speed_rad_s, dt_s)
        return motor_Nm - (1 - self.bldc.gear.efficiency) * abs(motor_Nm) * slow

    def _take_goal(self, goal_rad: float) -> None:
        """Go straight to a goal in one planner cycle; the first starts the trajectory where the joint is."""
        if self._goal_rad is None:
            cascade_reset(self.blocks.settings, self.blocks.state)
            self._goal_rad = goal_rad
        self._from_rad = self._sent_rad() if self._cycle_ms < CYCLE_MS else self._goal_rad
        self._slope_rad_s = (goal_rad - self._from_rad) / CYCLE_MS * 1000
        self._goal_rad, self._cycle_ms = goal_rad, 0

    def _sent_rad(self) -> float:
        return self._from_rad + self._slope_rad_s * min(self._cycle_ms, CYCLE_MS) / 1000

    def _send_setpoint(self) -> None:
        """Hand over the angle on the way, as the bus does (bus/can/cycle.py)."""
        blocks = self.blocks
        blocks.io.position = round(self._sent_rad() / tau * 65536)
        blocks.state.sequence = (blocks.state.sequence + 1) & 0xFFFF

    def _share(self) -> float:
        """Return the share of the current that the winding's temperature leaves."""
        t = self.bldc.thermal
        return max(0.0, min(1.0, (t.winding_cutoff_C - self.winding_C) / (t.winding_cutoff_C - t.winding_derate_C)))

    def _account(self, ampere: float, motor_Nm: float, speed_rad_s: float, dt_s: float) -> None:
        """Count heat and energy; a tenth of a second of heat reaches the winding at once."""
        resistance = self.bldc.motor.resistance_ohm * (1 + COPPER_PER_K * (self.winding_C - 25))
        copper_W = 1.5 * resistance * ampere**2
        self._time_s += dt_s
        self._square += copper_W * dt_s
        if self._square and round(self._time_s / dt_s) % 100 == 0:
            self._warm(100 * dt_s)
        if self._time_s <= SETTLE_S:
            return
        power_W = copper_W + motor_Nm * speed_rad_s
        if power_W > 0:
            self.drawn_J += power_W * dt_s
        else:
            self.returned_J -= power_W * dt_s
        self.largest_Nm = max(self.largest_Nm, abs(motor_Nm))
        self.hottest_C = max(self.hottest_C, self.winding_C)

    def _warm(self, seconds: float) -> None:
        t = self.bldc.thermal
        flow = (self.winding_C - self.housing_C) / t.winding_to_housing_K_W * seconds
        self.winding_C += (self._square - flow) / t.winding_J_K
        self.housing_C += (flow - (self.housing_C - 25.0) / t.housing_to_air_K_W * seconds) / t.housing_J_K
        self._square = 0.0


class JointMotors:
    """The eight drives of the plane, in motor angles; sim2d's Drives.

    Their torque is the motor's after an ideal gear, to which the current limit applies.
    """

    def __init__(self, bldc: Bldc, thigh_kg_m2: float, calf_kg_m2: float, spring: bool) -> None:
        inertias = (thigh_kg_m2, calf_kg_m2) * (PLANAR_JOINTS // 2)
        self.motors = [JointMotor(bldc, inertia, spring) for inertia in inertias]
        self.limit_Nm = [bldc.torque_limit_Nm] * PLANAR_JOINTS

    @property
    def given_Nm(self) -> Sequence[float]:
        """See sim2d.actuator.Drives."""
        return [motor.motor_Nm for motor in self.motors]

    def torques(self, goal_rad: Told, position_rad: Told, speed_rad_s: Told, dt_s: float, torque_Nm: Given) -> None:
        """See sim2d.actuator.Actuator."""
        for i, motor in enumerate(self.motors):
            torque_Nm[i] = motor.torque(goal_rad[i], position_rad[i], speed_rad_s[i], dt_s)


def joint_motors(robot: Robot) -> JointMotors:
    """Return the drives of a robot with brushless joints."""
    if not isinstance(robot.actuator, Bldc) or robot.calf_drive.ratio != 1.0:
        raise ValueError(f"{robot.name}: joint motors are for brushless joints with calf_drive.ratio 1")
    _, thigh_kg_m2, calf_kg_m2 = leg_inertia_kg_m2(robot)
    spring = robot.bus.kind == "can" and robot.bus.loops == "impedance"
    return JointMotors(robot.actuator, thigh_kg_m2, calf_kg_m2, spring)


def transport(robot: Robot, recording: Recording, payload_kg: float, motors: JointMotors | None) -> dict[str, Any]:
    """Return the energy of the legs' drives per metre and per weight and metre, without and with regeneration.

    The plane's eight drives and no electronics. The torque is the motor's behind an ideal gear, which the current
    limit bounds; a gear driven backwards resists with its own loss on top. Regeneration counts what braking motors
    give back at its full worth: the best any circuit could do; a supply that cannot take it back pays the figure
    without. Servos feed nothing back. Nothing is told of robots that are only simulated: their currents are not known.
    """
    way_m = float(recording.torso_x_m[-1] - recording.torso_x_m[0])
    if motors is None:
        power_W = drives_power_W(robot, recording.torque_Nm, recording.joint_speed_rad_s)
        drawn = power_W * float(recording.time_s[-1] - recording.time_s[0])
        returned = 0.0
    else:
        drawn = sum(motor.drawn_J for motor in motors.motors)
        returned = sum(motor.returned_J for motor in motors.motors)
    weight_N = (robot.mass_kg + payload_kg) * GRAVITY_M_S2
    forward = way_m > 0.01 and robot.bus.kind != "none"
    return {
        "energy_per_metre_J": round(drawn / way_m, 3) if forward else None,
        "energy_per_metre_regenerating_J": round((drawn - returned) / way_m, 3) if forward else None,
        "cost_of_transport": round(drawn / way_m / weight_N, 4) if forward else None,
        "cost_of_transport_regenerating": round((drawn - returned) / way_m / weight_N, 4) if forward else None,
        "largest_torque_Nm": None if motors is None else round(max(m.largest_Nm for m in motors.motors), 4),
        "hottest_winding_C": None if motors is None else round(max(m.hottest_C for m in motors.motors), 2),
    }
