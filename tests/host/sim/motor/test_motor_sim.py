"""The simulated joint: the motor model against its equations, every scenario's figures, the command's JSON."""

import json
import math
from dataclasses import replace

import pytest

from host.cli import main
from host.lab.motor_accuracy import accuracy, closed_form
from host.robot.file import load_robot
from host.robot.joint_units import JointSetup
from host.sim.motor import currents, faults, scenarios
from host.sim.motor.bench import Bench
from host.sim.motor.model import Load, Motor
from host.sim.motor.plots import draw
from host.util.errors import UserError
from shared.joint import faults as f
from shared.wire import names as w

BLDC = load_robot("parallel").actuator


def wound(steps, **load):
    """Return a motor whose rotor stands still, after steps of 50 us with 5 % of the supply along its flux."""
    motor = Motor(BLDC, Load(dead_time_s=0.0, source_ohm=0.0, **load), rotor_rad=0.0)
    motor.rotor_kg_m2 = 1e9
    for _ in range(steps):
        motor.advance(5e-5, True, *closed_form(0.05, 0.0))
    return motor


def test_a_locked_winding_reaches_voltage_over_resistance():
    motor = wound(400, blocked=True, ideal_gear=True)
    assert motor.i_d == pytest.approx(0.05 * 24 / motor.resistance_ohm(), rel=1e-3)
    assert motor.i_q == pytest.approx(0.0, abs=1e-6)


def test_a_winding_rises_with_its_time_constant():
    motor = wound(10)
    share = 1 - math.exp(-5e-4 * BLDC.motor.resistance_ohm / BLDC.motor.inductance_H)
    assert motor.i_d == pytest.approx(share * 0.05 * 24 / BLDC.motor.resistance_ohm, rel=1e-3)


def test_torque_is_the_torque_constant_times_current_and_gear():
    motor = Motor(BLDC, Load(blocked=True, ideal_gear=True), rotor_rad=0.0)
    motor.i_q = 2.0
    assert 1.5 * motor.pole_pairs * motor.psi_Vs * 2.0 * motor.gear == pytest.approx(BLDC.torque_limit_Nm)


def test_a_free_gear_keeps_energy_and_a_lossy_one_never_gives_any():
    for ideal in (True, False):
        motor = Motor(BLDC, Load(ideal_gear=ideal), rotor_rad=0.0)
        motor.rotor_rad_s = 50.0
        first = energy(motor)
        for _ in range(20000):
            motor.advance(5e-5, False, 0.5, 0.5, 0.5)
        assert energy(motor) <= first * 1.001
        assert (energy(motor) < 0.2 * first) is not ideal


def energy(motor):
    twist = motor.rotor_rad / motor.gear - motor.joint_rad
    stretched = max(0.0, abs(twist) - motor.slack_rad)
    moving = motor.rotor_kg_m2 * motor.rotor_rad_s**2 + motor.load.inertia_kg_m2 * motor.joint_rad_s**2
    return 0.5 * (moving + motor.spring_Nm_rad * stretched**2)


def test_heat_reaches_the_sum_of_both_resistances():
    motor = Motor(BLDC, Load(air_C=20.0, winding_J_K=1.0, housing_J_K=2.0))
    for _ in range(200_000):
        motor.heat_J = 5.0 * 0.001
        motor.warm(0.001)
    t = BLDC.thermal
    assert motor.winding_C == pytest.approx(20 + 5 * (t.winding_to_housing_K_W + t.housing_to_air_K_W), rel=0.01)


def test_the_integer_step_is_as_exact_as_said():
    figures = accuracy(BLDC)
    assert figures["ok"], figures
    assert figures["vectors"] >= 10_000


@pytest.mark.parametrize("name", [name for name in scenarios.SCENARIOS if name != "stall"])
def test_each_scenario_reaches_its_figures(name):
    result = scenarios.run_scenario(BLDC, name)
    assert result.ok, result.figures


def test_a_stalled_joint_gives_its_torque_and_is_derated_before_its_winding_is_too_hot(tmp_path):
    result = scenarios.run_scenario(BLDC, "stall")
    assert result.ok, result.figures
    draw(result, tmp_path / "stall.png")
    assert (tmp_path / "stall.png").stat().st_size > 10_000


def test_a_scenario_can_fail(monkeypatch):
    """A joint that may not be fast enough misses its step; a fault expected under another code is not found."""
    slow = BLDC.model_copy(update={"drive": BLDC.drive.model_copy(update={"speed_limit_rad_s": 0.2})})
    assert not scenarios.run_scenario(slow, "step").ok
    monkeypatch.setitem(faults.FAULTS, "bus-sag", replace(faults.FAULTS["bus-sag"], code=99))
    assert not scenarios.run_scenario(BLDC, "fault-bus-sag").ok


def test_a_magnet_that_creeps_is_found_before_the_rotor_turn_could_be_mistaken():
    """At 6 degrees for five ticks; half a rotor turn, where the turn would be ambiguous, is 8.18."""
    bench = Bench(BLDC)
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    for _ in range(100):
        bench.wrong.joint_turned_rad += math.radians(0.1)
        bench.run(1)
        if bench.state.fault_code:
            break
    assert bench.state.fault_code == f.FAULT_ENCODER_DISAGREE
    assert 6.0 <= abs(bench.state.fault_value) / 16384 * 360 / BLDC.gear.ratio < 7.0
    assert math.degrees(bench.wrong.joint_turned_rad) < 8.18


def test_readings_that_cannot_be_are_left_out_and_many_of_them_are_a_fault():
    result = scenarios.run_scenario(BLDC, "glitches")
    assert result.figures["glitches"] > 200
    assert result.figures["rejected"] >= 0.9 * result.figures["glitches"]
    bench = Bench(BLDC)
    bench.arm(w.MODE_POSITION, bench.motor.joint_rad)
    bench.wrong.glitch_share = 0.95
    bench.run(20)
    assert bench.state.fault_code == f.FAULT_ENCODER_LOST


def d_error_percent(age):
    """The mean d current at nearly full speed under load, in percent of the rated current."""
    bench = Bench(BLDC, Load(torque_Nm=1.0), JointSetup(-3.1, 3.1))
    if age is not None:
        bench.joint.control.settings.age = age
    bench.arm(w.MODE_VELOCITY, 0.0)
    bench.goal = 0.9 * BLDC.drive.speed_limit_rad_s
    bench.run(150)
    return 100 * abs(currents._axis_errors(bench, 60)[0]) / BLDC.drive.current_limit_A


def test_the_encoder_answers_one_step_late_and_the_angle_is_led_by_that():
    assert d_error_percent(None) < 0.5
    assert d_error_percent(0) > 2


def test_duties_act_for_the_whole_of_the_next_step():
    """The board's handler runs at the samples; what it writes is in the next step's voltage, no part of it in this."""
    bench = Bench(BLDC, Load(locked=True))
    bench.board.bridge, bench.fast = 1, []
    compare, half = bench.board.compare, bench.blocks.loop.period // 2

    def write(a):
        compare[0], compare[1], compare[2] = a, half, half

    for a in (half, half + 400, half, half, half):
        bench.board.handler = lambda a=a: write(a)
        bench._step()
    before, written, acted, later = bench.fast[0], bench.fast[1], bench.fast[2], bench.fast[3]
    assert abs(before) < 1e-9
    assert abs(written) < 1e-9
    assert abs(acted) > 0.05
    assert abs(later) < abs(acted)  # it decays again


def test_a_locked_rotor_stays_and_a_held_joint_lets_it_wind_up_the_gear():
    locked, held = (scenarios.run_scenario(BLDC, f"current-{name}").figures for name in ("locked", "held"))
    assert locked["rotor_turned_elec_deg"] == 0
    assert 10 < held["rotor_turned_elec_deg"] < 30


def test_a_joint_that_hums_in_its_gears_play_fails_the_sine():
    stiff = BLDC.model_copy(update={"drive": BLDC.drive.model_copy(update={"velocity_bandwidth_hz": 40.0})})
    figures = scenarios.run_scenario(stiff, "sine").figures
    assert not figures["ok"]
    assert figures["current_rms_A"] > 2 * figures["needed_rms_A"]


@pytest.mark.parametrize("name", ["fault-love", ""])
def test_an_unknown_scenario_is_told_with_the_list(name):
    with pytest.raises(UserError, match="fault-swapped-phases"):
        scenarios.chosen(name)


def test_the_same_scenario_gives_the_same_figures():
    first, second = (scenarios.run_scenario(BLDC, "sine").figures for _ in range(2))
    assert first == second


def test_json_has_the_keys_that_are_promised(capsys):
    assert main(["motor", "sim", "--scenario", "step", "--json"]) == 0
    step = json.loads(capsys.readouterr().out)
    assert {"ok", "settling_error_deg", "overshoot_percent", "max_phase_current_A", "settling_time_s"} <= set(step)
    assert main(["motor", "sim", "--scenario", "fault-bus-sag", "--json"]) == 0
    fault = json.loads(capsys.readouterr().out)
    assert {"ok", "fault", "message", "detected_after_ms", "torque_after_Nm"} <= set(fault)
    assert "under-voltage" in fault["message"]


def test_a_narrow_terminal_cuts_no_name_and_no_figure(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "40")
    assert main(["motor", "sim", "--scenario", "fault-bus-sag"]) == 0
    told = capsys.readouterr().out
    assert "detected_after_ms" in told
    assert "…" not in told


def test_without_a_command_the_help_is_printed(capsys):
    main(["motor"])
    assert "selftest" in capsys.readouterr().out


def test_a_robot_with_servos_is_refused(capsys):
    assert main(["motor", "sim", "--robot", "caramelo"]) == 2
    assert "its joints are not brushless" in capsys.readouterr().err
