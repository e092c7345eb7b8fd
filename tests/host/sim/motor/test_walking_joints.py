"""The reduced joint of the walking simulator against the full one, and what walking costs."""

import math

import numpy as np
import pytest

from host.robot.file import load_robot
from host.sim.motor.bench import Bench
from host.sim.motor.model import Load
from host.sim.motor.walking import JointMotor, joint_motors, transport
from host.sim.walk import WalkSpec, run_walk
from shared.wire import names as w

ROBOT = load_robot("parallel")
BLDC = ROBOT.actuator
INERTIA = 0.01
MS = 1500


def goal(ms, start):
    """A swing of 0.25 rad at 1.5 Hz as a planner at 50 Hz sends it: a new angle every 20 ms."""
    at = ms // 20 * 20 / 1000
    return start + 0.25 * (1 - math.cos(math.tau * 1.5 * at))


def full(load_Nm, mode):
    """The firmware on the simulated bench, sent the same straight ways from goal to goal at 200 Hz."""
    bench = Bench(BLDC, Load(inertia_kg_m2=INERTIA))
    start = bench.motor.joint_rad
    bench.arm(mode, start)
    bench.load.torque_Nm = load_Nm
    bench.run(-bench._ms % 5)  # a set-point is due with the first goal
    way, current = [], []
    for ms in range(MS):
        last, new = goal(max(0, ms - 20), start), goal(ms, start)
        bench.goal = last + (new - last) * (ms % 20) / 20
        bench.run(1)
        way.append(bench.motor.joint_rad - start)
        current.append(bench.motor.i_q)
    return way, current


def reduced(load_Nm, mode):
    motor = JointMotor(BLDC, INERTIA, mode == w.MODE_IMPEDANCE)
    inertia = INERTIA + BLDC.motor.rotor_inertia_kg_m2 * BLDC.gear.ratio**2
    position = speed = 0.0
    way, current = [], []
    for ms in range(MS):
        friction = BLDC.motor.coulomb_Nm * BLDC.gear.ratio * max(-1.0, min(1.0, speed / 0.05))
        given = motor.torque(goal(ms, 0.0), position, speed, 1e-3)
        speed += 1e-3 * (given + load_Nm - friction) / inertia
        position += 1e-3 * speed
        way.append(position)
        current.append(motor.blocks.state.current_reference * motor.blocks.units.ampere_per_cu)
    return way, current


def rms_A(current):
    return float(np.sqrt(np.mean(np.square(current))))


def slow(current):
    """The part below 15 Hz: what moves and carries, without what shakes."""
    parts = np.fft.rfft(current)
    parts[np.fft.rfftfreq(len(current), 1e-3) > 15] = 0
    return np.fft.irfft(parts, len(current))


@pytest.mark.parametrize("mode", [w.MODE_POSITION, w.MODE_IMPEDANCE])
@pytest.mark.parametrize("load_Nm", [0.0, -1.0])
def test_the_reduced_joint_moves_as_the_full_one_does(load_Nm, mode):
    (way, ampere), (other, other_ampere) = full(load_Nm, mode), reduced(load_Nm, mode)
    rms = math.sqrt(sum((a - b) ** 2 for a, b in zip(way, other, strict=True)) / MS)
    assert math.degrees(rms) < 0.5
    assert rms_A(slow(other_ampere)) == pytest.approx(rms_A(slow(ampere)), rel=0.05)
    assert rms_A(other_ampere) == pytest.approx(rms_A(ampere), rel=0.15)  # no spring that rings at the ways' corners


def test_a_walk_stays_within_torque_and_temperature_and_costs_less_with_regeneration():
    motors = joint_motors(ROBOT)
    spec = WalkSpec(robot=ROBOT, gait="trot", distance_m=0.3)
    recording = run_walk(spec, actuator=motors)
    assert recording.outcome.ok, recording.outcome.sentence
    figures = transport(ROBOT, recording, 0.0, motors)
    assert 0 < figures["largest_torque_Nm"] <= BLDC.torque_limit_Nm
    assert 25 < figures["hottest_winding_C"] < BLDC.thermal.winding_derate_C
    assert 0 < figures["energy_per_metre_regenerating_J"] < figures["energy_per_metre_J"]


def test_a_robot_with_servos_gets_its_cost_too_and_nothing_back():
    robot = load_robot("caramelo")
    recording = run_walk(WalkSpec(robot=robot, gait=robot.gait.default, distance_m=0.3))
    figures = transport(robot, recording, 0.0, None)
    assert figures["energy_per_metre_J"] == figures["energy_per_metre_regenerating_J"] > 0
    with pytest.raises(ValueError, match="brushless"):
        joint_motors(robot)


def test_a_hot_winding_gets_less_current():
    motor = JointMotor(BLDC, INERTIA)
    motor.torque(0.0, 0.0, 0.0, 1e-3)
    cold = max(abs(motor.torque(1.0, 0.0, 0.0, 1e-3)) for _ in range(300))
    motor.winding_C = (BLDC.thermal.winding_derate_C + BLDC.thermal.winding_cutoff_C) / 2
    assert abs(motor.torque(1.0, 0.0, 0.0, 1e-3)) < 0.6 * cold
