"""Commissioning on the full motor model: motors drawn at random, planted defects, what the host reads and writes."""

import json
import math
import os
import random
import statistics
from dataclasses import replace

import pytest

from host.bus.can.commission import Found
from host.cli import main
from host.robot.file import load_robot
from host.sim.motor.bench import Bench
from host.sim.motor.model import Load
from host.util.errors import UserError
from shared.joint.commission_state import (
    COMMISSION_FULL,
    COMMISSION_VERIFY,
    PHASE_CREEP,
    PHASE_PROVE_CURRENT,
    PHASE_PROVE_VELOCITY,
)
from shared.joint.layout import WAVES
from shared.wire import names as w

from .drawn import LONGEST_S, PARALLEL, commissioned, draw, errors, replaced

MOST = {
    "pole_pairs": 0, "resistance": 0.05, "inductance_d": 0.05, "inductance_q": 0.05, "flux": 0.03,
    "offset_elec_deg": 3.0, "eccentric_deg": 0.1, "inertia": 0.1, "friction_share": 0.025, "velocity_hz": 0.15,
    "play_deg": 0.06, "cogging_left": 0.2, "cogging_rest": 0.01, "current": 1.0, "seconds": LONGEST_S,
}  # fmt: skip


def found(seed):
    """Return a motor drawn at random and its bench, commissioned."""
    drawn = draw(seed)
    bench = drawn.bench()
    assert commissioned(bench) == ""
    return drawn, bench


def check(drawn, bench):
    """Fail if what was found is farther off than allowed."""
    missed = {name: value for name, value in errors(drawn, bench).items() if abs(value) > MOST[name]}
    assert not missed


def test_a_motor_drawn_at_random_is_found():
    check(*found(1))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(200))
def test_two_hundred_motors_drawn_at_random_are_found(seed):
    check(*found(seed))


def test_another_is_found_and_the_current_loops_gains_are_those_of_the_wanted_bandwidth():
    drawn, bench = found(2)
    check(drawn, bench)
    loop, drive = bench.joint.control.loop, drawn.file.drive
    ohm = bench.units.volt_per_vu / bench.units.ampere_per_cu / 8192  # of a gain
    wanted, henry = 2 * math.pi * drive.current_bandwidth_hz, (bench.motor.l_H + bench.motor.lq_H) / 2
    assert loop.kp * ohm == pytest.approx(wanted * henry, rel=0.05)
    assert loop.ki * ohm * drive.current_loop_hz == pytest.approx(wanted * bench.motor.resistance_ohm(), rel=0.05)


def amplifier(counts):
    return lambda b: setattr(b.sensors, "offsets_counts", (counts, 0.0, 0.0))


def noisy(bench):
    bench.sensors._noise = [random.Random(k).gauss(0, 10) for k in range(4096)]


def wrong(**more):
    return lambda b: vars(b.wrong).update(more)


def load(**more):
    return lambda b: vars(b.load).update(more)


def later(phase, **more):
    """Return what changes the load from ``phase`` of commissioning on, or the winding's inductance by a factor."""

    def plant(bench):
        move = bench.motor.advance

        def advance(*step):
            if more and bench.joint.control.commission.phase >= phase:
                for name, value in more.items():
                    setattr(bench.motor if hasattr(bench.motor, name) else bench.load, name, value)
                bench.motor._decay_key = (0.0, 0.0)
                more.clear()
            move(*step)

        bench.motor.advance = advance

    return plant


DEFECTS = {
    "phase a open": (load(open_phase=0), "phase 1 of 3"),
    "phase b open": (load(open_phase=1), "phase 2 of 3"),
    "phase c open": (load(open_phase=2), "phase 3 of 3"),
    "motor not connected": (lambda b: vars(b.motor).update(r25_ohm=1e4), "no current"),
    "winding half shorted": (lambda b: vars(b.motor).update(l_H=2e-5, lq_H=2e-5), "winding"),
    "magnet off centre": (wrong(eccentric_rad=0.075), "magnet"),
    "end stop too near": (lambda b: vars(b.load).update(stop_rad=b.motor.joint_rad + 0.15), "end stop"),
    "too much friction": (lambda b: setattr(b.motor, "coulomb_Nm", 0.036), "friction"),
    "rotor blocked": (load(locked=True), "not free"),
    "rotor magnets lost": (lambda b: setattr(b.motor, "psi_Vs", 1e-5), "not free"),
    "amplifier off zero": (amplifier(300.0), "offset"),
    "amplifier's gain": (wrong(shunt_gain=0.6), "sum"),
    "amplifier noisy": (noisy, "noise"),
    "supply too low": (lambda b: vars(b.wrong).update(supply_V=18.5), "supply"),
    "rotor encoder noisy": (wrong(rotor_noise=4.0), "encoder"),
    "rotor encoder lost": (wrong(rotor_lost=True), "encoder lost"),
    "joint encoder's magnet off": (wrong(joint_stuck=True), "joint encoder"),
    "play in the gear": (lambda b: (setattr(b.motor, "slack_rad", 0.02), load(friction_Nm=0.2)(b)), "play"),
    "load too heavy": (load(inertia_kg_m2=0.06), "load"),
    "cogging too strong": (later(PHASE_CREEP, cogging_Nm=0.04, cogging_waves=14), "cogging"),
    "winding saturates": (later(PHASE_PROVE_CURRENT, l_H=1.7e-4, lq_H=1.7e-4), "current loop"),
    "load comes off": (later(PHASE_PROVE_VELOCITY, inertia_kg_m2=0.001), "velocity loop"),
    "joint turning": (lambda b: vars(b.motor).update(rotor_rad_s=8.0, joint_rad_s=8.0 / 22, coulomb_Nm=0.0), "moving"),
}


@pytest.mark.parametrize("name", DEFECTS)
def test_planted_defects_are_named(name):
    plant, word = DEFECTS[name]
    bench = Bench(PARALLEL, commissioned=False)
    plant(bench)
    if name == "supply too low":
        bench.joint.control.settings.commission_bus_least = round(20.0 / bench.units.volt_per_vu)
    said = commissioned(bench)
    assert word in said.split(";")[0]
    assert not bench.joint.control.settings.commissioned
    assert not bench.board.bridge


@pytest.mark.parametrize("name", ["phases swapped", "magnet slipped"])
def test_what_has_changed_is_named_when_verified(name):
    bench = Bench(PARALLEL, replace(Bench(PARALLEL).load, swapped_phases=name == "phases swapped"))
    if name == "magnet slipped":
        bench.motor.elec_offset_rad += 0.5
    assert ("phase order" if name == "phases swapped" else "offset changed") in commissioned(bench, COMMISSION_VERIFY)


def test_another_motor_than_the_files_is_found_to_be_one():
    """With gains twelve times too high for it, as a robot file of another motor would give."""
    real = replaced(PARALLEL, {"inductance_H": 5e-5, "resistance_ohm": 0.15, "pole_pairs": 14}, {}, {})
    bench = Bench(PARALLEL, commissioned=False, real=real)
    assert commissioned(bench, COMMISSION_FULL) == ""
    assert bench.joint.control.settings.pole_pairs == 14


def test_the_command_tells_what_was_found_and_writes_the_robot_file(capsys, tmp_path):
    out = tmp_path / "measured.toml"
    assert main(["joints", "commission", "5", "--sim", "--json", "--out", str(out)]) == 0
    told = json.loads(capsys.readouterr().out)
    (found,) = told["joints"]
    motor = load_robot("parallel").actuator.motor
    assert found["resistance_ohm"] == pytest.approx(motor.resistance_ohm, rel=0.03)
    assert found["inductance_d_H"] == pytest.approx(motor.inductance_H, rel=0.02)
    assert found["torque_constant_Nm_A"] == pytest.approx(motor.torque_constant_Nm_A, rel=0.03)
    assert found["eccentricity_deg"] == pytest.approx(0.86, abs=0.1)
    assert found["coulomb_Nm"] == pytest.approx(motor.coulomb_Nm, abs=0.002)
    assert found["velocity_bandwidth_hz"] == pytest.approx(30.0, abs=0.01)
    assert found["cogging_Nm"] < 0.001  # this motor has none
    assert found["backlash_deg"] is None  # a thigh has no joint encoder
    assert told["failed"] == {}
    assert load_robot(str(out)).actuator.motor.resistance_ohm == pytest.approx(found["resistance_ohm"], rel=1e-3)
    assert out.read_text().count(": measured)") == 6


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["13"], "give 1 .. 12, or all"),
        (["5", "--out", "there/is/no.toml"], "give a new file"),
        (["5", "--verify", "--out", "x.toml"], "--out: not with --verify"),
    ],
)
def test_wrong_use_is_told_before_anything_moves(capsys, arguments, sentence):
    assert main(["joints", "commission", *arguments, "--sim"]) == 2
    assert sentence in capsys.readouterr().err


def test_a_folder_that_takes_no_file_is_told_before_anything_moves(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(os, "access", lambda path, mode: path != tmp_path)
    assert main(["joints", "commission", "5", "--sim", "--out", str(tmp_path / "measured.toml")]) == 2
    assert f"you may not write to {tmp_path}" in capsys.readouterr().err


def fails_at(node, monkeypatch):
    """Let the joint at ``node`` fail, and every other find the same; nothing is simulated."""

    def one(_bus, number, *_):
        if number == node:
            raise UserError(f"joint {number}: it does not turn")
        return [Found(number, 7, 1, 0.1, 4e-4, 6e-4, 0.05, 0.0, 1.0, 2e-5, 0.01, 1e-5, None, 0.0, 30.0, 1, 1, 1)]

    monkeypatch.setattr("host.commands.joints.commission._one", one)


def test_the_joints_that_passed_are_written_when_one_of_twelve_fails(capsys, tmp_path, monkeypatch):
    fails_at(5, monkeypatch)
    out = tmp_path / "measured.toml"
    assert main(["joints", "commission", "all", "--sim", "--out", str(out)]) == 1
    told = capsys.readouterr()
    assert "joint 5: it does not turn" in told.err
    assert told.out.endswith(f"\n11 of 12 joints commissioned; {out} written from them\n")
    assert load_robot(str(out)).actuator.motor.resistance_ohm == 0.1


def test_no_robot_file_comes_of_a_joint_that_failed(capsys, tmp_path, monkeypatch):
    fails_at(5, monkeypatch)
    out = tmp_path / "measured.toml"
    assert main(["joints", "commission", "5", "--sim", "--out", str(out)]) == 1
    assert capsys.readouterr().out == f"0 of 1 joints commissioned; {out} not written\n"
    assert not out.exists()


def ripple(bench):
    """Return the rms of the rotor's speed about its mean in 0.8 s of constant speed, rad/s."""
    speeds = []
    bench.run(400)
    for _ in range(800):
        bench.run(1)
        speeds.append(bench.motor.rotor_rad_s)
    return statistics.pstdev(speeds)


def test_the_coggings_ripple_at_a_constant_speed_is_cut_by_five():
    """A cogging of 8 % of the torque at the current limit, passed 15 times a second."""
    motor, drive = PARALLEL.motor, PARALLEL.drive
    cogging = Load(cogging_Nm=0.08 * motor.torque_constant_Nm_A * drive.current_limit_A, cogging_waves=42)
    bench = Bench(PARALLEL, cogging, commissioned=False)
    assert commissioned(bench) == ""
    bench.state.homed = 1
    bench.arm(w.MODE_VELOCITY, 15.0 / 42 * math.tau / PARALLEL.gear.ratio)
    held = ripple(bench)
    for wave in range(WAVES):
        bench.joint.control.loop.wave_current[wave] = 0
    assert ripple(bench) > 5 * held
