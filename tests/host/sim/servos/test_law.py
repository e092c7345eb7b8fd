"""The servo's honest law against what can be computed by hand: slopes, play, delay, steps, supply, stall."""

from dataclasses import replace
from math import asin, degrees, exp, radians, sin

import pytest

from host.robot.actuators import Friction
from host.robot.file import load_robot
from host.sim.plant import Drives, Hinge, joint_models, servo_torque_Nm
from host.sim.servos.law import Battery, Figures, ServoLaw, Stood, figures_of, friction_law

DT_S = 0.001
LINK_KG_M2 = 7e-4
FILE = figures_of(load_robot("caramelo").actuator)
PLAIN = Figures(2.5, 5.76, 4.891, 0.06, 0.0032)
WEIGHT_NM = 0.4  # of a mass on an arm, when the arm lies flat


def stood(figures, at_rad=0.0, battery=None):
    return Stood(ServoLaw(figures, at_rad, LINK_KG_M2, battery), LINK_KG_M2, at_rad)


def run(joint, seconds, goal_rad, most=1.0, load=lambda rad: 0.0):
    """Step for so long and return the positions."""
    places = []
    for _ in range(round(seconds / DT_S)):
        joint.step(goal_rad, most, load(joint.position_rad), DT_S)
        places.append(joint.position_rad)
    return places


def test_with_nothing_switched_on_it_is_the_law_that_the_bench_has():
    robot = load_robot("caramelo")
    model = joint_models(robot)[1]
    servo = robot.actuator.model_copy(
        update={"friction": Friction(), "backlash_deg": 0.0, "pwm_steps": 0, "counts_per_turn": 10**12}
    )
    honest = stood(figures_of(servo))
    plain = Hinge(model, LINK_KG_M2 + model.armature_kgm2, (-9.0, 9.0))
    drives = Drives([0.4] * 12, [True] * 12)
    for _ in range(400):
        torque = servo_torque_Nm(model, drives, 1, 0.4, plain.position_rad, plain.speed_rad_s)
        plain.step(torque, DT_S)
        honest.step(0.4, 1.0, 0.0, DT_S)
        # The bench's friction is subtracted from the speed after the step, the law's from the torque: not to the bit.
        assert abs(honest.position_rad - plain.position_rad) < 1e-9
    assert abs(plain.position_rad - 0.4) < 0.01


@pytest.mark.parametrize("play_deg", [0.0, 0.33])
@pytest.mark.parametrize("load_external", [0.0, 0.2])
def test_a_joint_on_a_slope_holds_by_friction_and_slips_at_the_computed_torque(play_deg, load_external):
    friction = Friction(stribeck_Nm=0.05, load_external=load_external)
    figures = replace(PLAIN, friction=friction, backlash_rad=radians(play_deg))
    # Without torque friction holds up to coulomb + stribeck + share x load = load.
    slips_Nm = (0.06 + 0.05) / (1 - load_external)
    slope_rad = asin(slips_Nm / WEIGHT_NM)

    def slid(slope):
        joint = stood(figures)
        for k in range(1000):  # tilted slowly: a link that falls through its play would hit hard enough to slip
            run(joint, DT_S, 0.0, None, lambda rad, part=k / 1000: WEIGHT_NM * sin(part * slope))
        began = joint.position_rad
        return abs(run(joint, 0.5, 0.0, None, lambda rad: WEIGHT_NM * sin(slope))[-1] - began)

    assert slid(0.98 * slope_rad) < 1e-4
    assert slid(1.02 * slope_rad) > 0.02


def test_friction_is_m6_as_published():
    f = FILE.friction
    fades = exp(-((0.3 / f.stribeck_rad_s) ** f.stribeck_exponent))
    wanted = (
        FILE.coulomb_Nm + f.viscous_Nms_rad * 0.3 + abs(f.load_external * -0.5 - f.load_motor * 0.8)
        + fades * (f.stribeck_Nm + abs(f.load_external_stribeck * -0.5 - f.load_motor_stribeck * 0.8)
                   + f.load_external_square_1_Nm * 0.25)
    )  # fmt: skip
    most_Nm = friction_law(FILE)
    assert most_Nm(0.8, -0.5, 0.3) == pytest.approx(wanted)
    assert most_Nm(0.8, -0.5, -0.3) == pytest.approx(wanted)
    assert most_Nm(0.5, 0.5, 0.3) < wanted  # torques that pull one way: no square


def test_at_stall_the_shaft_gives_what_the_data_sheet_says():
    figures = replace(FILE, coulomb_Nm=0.0, friction=FILE.friction.model_copy(update={"stribeck_Nm": 0.0}))
    motor_Nm = figures.motor_stall_Nm
    assert motor_Nm - friction_law(figures)(motor_Nm, 0.0, 0.0) == pytest.approx(2.5)


def test_a_play_of_one_degree_shows_as_one_degree():
    figures = replace(PLAIN, backlash_rad=radians(1.0), counts_per_rad=0.0)
    joint = stood(figures)
    pushed_Nm = 0.001  # too little to knock the rotor on when it has fallen through
    up = run(joint, 2.0, 0.0, None, lambda rad: pushed_Nm)[-1]
    down = run(joint, 2.0, 0.0, None, lambda rad: -pushed_Nm)[-1]
    assert degrees(up - down) == pytest.approx(1.0, abs=0.02)
    assert abs(joint.law.rotor_rad) < 1e-4
    none = stood(PLAIN)
    assert run(none, 0.5, 0.0, None, lambda rad: pushed_Nm)[-1] == 0.0


def test_play_and_its_rotor_keep_the_speed_that_duty_and_friction_allow():
    for play_deg in (0.0, 0.5):
        joint = stood(replace(PLAIN, backlash_rad=radians(play_deg)))
        places = run(joint, 0.4, 9.0, 0.3)
        speed = (places[-1] - places[-101]) / 0.1
        assert speed == pytest.approx(5.76 * (0.3 - 0.06 / 2.5), rel=0.005)


def test_a_goal_acts_after_the_delay():
    joint = stood(replace(PLAIN, delay_s=0.012))
    run(joint, 0.05, 0.0)
    places = run(joint, 0.05, 0.2)
    first = next(k for k, place in enumerate(places) if place != 0.0)
    assert first * DT_S == pytest.approx(0.012, abs=0.0011)


def test_goals_that_come_every_sub_step_each_wait_the_delay():
    now, late = stood(PLAIN), stood(replace(PLAIN, delay_s=0.010))
    ahead = [now.step(0.001 * k, 1.0, 0.0, DT_S) or now.position_rad for k in range(300)]
    after = [late.step(0.001 * k, 1.0, 0.0, DT_S) or late.position_rad for k in range(300)]
    assert after[10:] == pytest.approx(ahead[:-10], abs=2e-3)


def test_duty_comes_in_steps():
    joint = stood(replace(PLAIN, pwm_steps=885, counts_per_rad=4096 / 6.283185307))
    seen = set()
    for k in range(200):
        joint.law.step(0.0005 * k, 1.0, 0.0, 0.0, 0.0, DT_S)
        seen.add(joint.law.duty)
    assert all(abs(duty * 885 - round(duty * 885)) < 1e-9 for duty in seen)


def test_the_supply_sags_by_the_current_times_the_resistance():
    battery = Battery(12.0, 0.5)
    law = ServoLaw(replace(PLAIN, stall_A=1.4), 0.0, LINK_KG_M2, battery)
    for _ in range(50):
        law.step(9.0, 1.0, 0.0, 0.0, 0.0, DT_S)  # blocked at full duty
        battery.settle()
    drop_V = 1.4 * 0.5 / (1 + 1.4 * 0.5 / 12.0)  # the current falls with the voltage
    assert 12.0 - battery.voltage_V == pytest.approx(drop_V, rel=1e-3)
    assert law.torque_Nm == pytest.approx(2.5 * battery.voltage_V / 12.0, rel=1e-3)
