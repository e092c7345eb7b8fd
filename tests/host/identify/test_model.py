"""The fit's model is the float twin of the simulator's law: the same numbers give the same motion."""

import numpy as np
import pytest

from host.identify.carried import in_the_air
from host.identify.model import SAG, Load, Told, simulate
from host.sim.servos.honest import drawn
from host.sim.servos.law import Battery, ServoLaw, Stood

from .robots import ROBOT, SERVO

STEPS = 400


def test_model_and_law_do_the_same():
    load, made = in_the_air(ROBOT, 1), drawn(ROBOT, 5)
    f = made.figures[1]
    servo = SERVO.model_copy(update={"friction": f.friction})
    start, end, most = 0.6, 1.0, 0.2
    battery = Battery(f.voltage_V, made.supply_ohm)
    law = ServoLaw(f, start, load.inertia_kg_m2, battery)
    law.figures = f.__class__(**{**f.__dict__, "delay_s": 0.0, "pwm_steps": 0, "counts_per_rad": 0.0})
    side = -np.sign(load.at_scalar(start))
    law.rotor_rad = start + side * f.backlash_rad / 2
    stood, places = Stood(law, load.inertia_kg_m2, start), []
    goals = np.where(np.arange(STEPS) % 200 < 100, end, start)
    for goal in goals:
        stood.step(goal, most, load.at_scalar(stood.position_rad), 0.001)
        battery.settle()
        places.append(stood.position_rad)
    p = {name: np.array([[value]]) for name, value in {
        "stall_Nm": f.stall_Nm, "no_load_rad_s": f.no_load_rad_s, "duty_per_rad": f.duty_per_rad,
        "coulomb_Nm": f.coulomb_Nm, "armature_kg_m2": f.armature_kg_m2, "backlash_rad": f.backlash_rad,
        "stribeck_Nm": f.friction.stribeck_Nm, "stribeck_rad_s": f.friction.stribeck_rad_s,
        "viscous_Nms_rad": f.friction.viscous_Nms_rad, "load_motor": f.friction.load_motor,
        "load_external": f.friction.load_external, SAG: made.supply_ohm * f.stall_A / f.voltage_V,
    }.items()}  # fmt: skip
    told = Told(goals[:, None], np.full((STEPS, 1), most), np.ones(1), np.array([start]), np.array([side]))
    twin, _, _ = simulate(p, servo.friction, load, told)
    assert max(places) - min(places) > 0.02
    assert np.max(np.abs(twin[:, 0, 0] - places)) < 2e-4  # an eighth of a step of the position


def test_a_mirrored_load_is_the_other_way_round():
    load = Load(1e-3, 0.06, -0.02, 1.1)
    about = 0.3
    mirrored = load.mirrored(about * load.ratio)
    for q in (-0.4, 0.1, 0.9):
        assert mirrored.at_scalar(q) == pytest.approx(-load.at_scalar(2 * about - q))
        assert float(load.at(np.array(q))) == pytest.approx(load.at_scalar(q))
