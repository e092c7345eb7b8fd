"""What is led of the joints' friction: the band by the law of friction itself, the integers by the floats."""

import random
from dataclasses import replace

import pytest

from host.robot.drives import friction_bands, joint_drives
from host.robot.file import load_robot
from host.robot.scale import BRAD_PER_RAD, core_params
from host.sim.servos.law import figures_of, friction_law
from shared.body.params import LF_BITS
from shared.record import unpack
from shared.sense.legs import MeasuredFeet
from shared.sense.odometry import Odometry
from shared.trot.feedforward import compensate_friction, feed_forward
from shared.trot.react import EARLY_NOW, detect_held_up, may_be_late
from shared.trot.state import Trot
from shared.trot.trot import trot_start

from .reference import FloatTrot

ROBOTS = ("caramelo", "parallel", "unitree-a1", "mini-cheetah", "pupper")
FADED_RAD_S = 50.0  # at which nothing is left of Stribeck


def edge_Nm(most_Nm, load_Nm, way):
    """Return the motor's torque with which a joint turns evenly against a load (way 1) or with it (way -1)."""
    low, high = load_Nm, load_Nm + way * 5.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if abs(middle - load_Nm) < most_Nm(middle, -load_Nm, FADED_RAD_S) else (low, middle)
    return low


@pytest.mark.parametrize("load_Nm", [0.1, 0.2, 0.6, 1.2])
def test_half_of_the_band_is_what_the_law_of_friction_holds(load_Nm):
    """Exact from a load on that dry friction alone does not hold, but for viscous friction, which is lag."""
    robot = load_robot("caramelo")
    figures, servo = figures_of(robot.actuator), joint_drives(robot)[0]
    figures = replace(figures, friction=figures.friction.model_copy(update={"viscous_Nms_rad": 0.0}))
    most_Nm = friction_law(figures)
    band_Nm = (edge_Nm(most_Nm, load_Nm, 1) - edge_Nm(most_Nm, load_Nm, -1)) / 2
    dry_rad, of_sag = friction_bands(robot)
    told = dry_rad[0] + of_sag * load_Nm / servo.stiffness_Nm_rad
    assert told == pytest.approx(band_Nm / (figures.motor_stall_Nm * figures.duty_per_rad), rel=1e-6)


def test_joints_of_which_nothing_is_known_have_their_dry_friction_only():
    robot = load_robot("unitree-a1")
    dry_rad, of_sag = friction_bands(robot)
    assert of_sag == 0.0
    for drive, band_rad in zip(joint_drives(robot), dry_rad, strict=True):
        assert band_rad == pytest.approx(drive.coulomb_Nm / drive.stiffness_Nm_rad)


def stood(name, rate_hz=50):
    """Return what a robot's trot at rest is made of."""
    robot, walk, params = load_robot(name), Trot(MeasuredFeet(), Odometry()), core_params(load_robot(name), rate_hz)
    trot_start(params, walk)
    walk.joints_before[:] = walk.joints
    return FloatTrot(robot, rate_hz), params, walk


@pytest.mark.parametrize("rate_hz", [20, 50, 500])
@pytest.mark.parametrize("name", ROBOTS)
def test_what_is_led_is_as_the_floats_say(name, rate_hz):
    """Over all steps and sags; at most 3 brad and 3 % off: with a motor on the body that is a sum of two."""
    twin, params, walk = stood(name, rate_hz)
    rng, leg = random.Random(7), 2
    for n in range(2000):
        top = (3, 40, 400, 65535)[n % 4]
        steps, give = ([rng.randint(-most, most) for _ in range(3)] for most in (top, 2730))
        goal = [0] * 12
        for i in range(3):
            walk.joints_before[6 + i] = walk.joints[6 + i] - steps[i]
            goal[6 + i] = walk.joints[6 + i] + give[i]
        asked = list(goal)
        compensate_friction(params, walk, leg, goal)
        exact = twin.compensate_friction([step / BRAD_PER_RAD for step in steps], [sag / BRAD_PER_RAD for sag in give])
        for i in range(3):
            assert goal[6 + i] - asked[6 + i] == pytest.approx(exact[i] * BRAD_PER_RAD, abs=3, rel=0.03)
        assert goal[:6] == asked[:6]
        assert goal[9:] == asked[9:]


def test_only_legs_that_stand_and_move_are_led_and_none_once_something_was_met():
    twin, params, walk = stood("caramelo")
    dry = twin.friction[1] * BRAD_PER_RAD
    rest, goal = list(walk.joints), [0] * 12
    feed_forward(params, walk, goal)
    assert goal == rest
    for leg, (stands, met, share) in enumerate(((1, 0, 1.0), (0, 0, 0.5), (1, EARLY_NOW, 0.0), (1, 0, 1.0))):
        walk.stance[leg], walk.early_contact[leg] = stands, met
        walk.joints_before[3 * leg + 1] = rest[3 * leg + 1] - 400
        feed_forward(params, walk, goal)
        lag = share * 400 * params.trot.lag_q8 / 256
        friction = dry if stands and met == 0 else 0.0
        assert goal[3 * leg + 1] - rest[3 * leg + 1] == pytest.approx(lag + friction, abs=2)
    walk.state.high_left = 1
    feed_forward(params, walk, goal)
    assert goal[10] - rest[10] == pytest.approx(400 * params.trot.lag_q8 / 256, abs=2)


@pytest.mark.parametrize(("way", "gone", "mate", "swing_q15", "late"), [
    (1, 0.9, 3.0, 20000, 0),  # slower than the body
    (1, 1.1, 3.0, 20000, 1),  # its goals are ahead of it, but it comes
    (1, -1.0, -1.0, 20000, 1),  # neither has begun its swing, as far as is measured
    (1, -1.0, -1.0, 6000, 0),
    (-1, 0.9, 3.0, 20000, 0),
    (-1, 1.1, 3.0, 20000, 1),
])
def test_a_foot_that_comes_may_be_late_and_one_that_stays_is_held(way, gone, mate, swing_q15, late):
    """gone, mate: of the speed that the body is to have."""
    _, _, walk = stood("caramelo")
    tick = 400
    walk.state.foot_speed.x, walk.state.swing_q15 = way * tick << LF_BITS, swing_q15
    unpack(walk.before, [1000] * 12)
    for leg in range(4):
        walk.measured.legs[leg].x = 1000 + round(way * tick * gone)
        walk.measured.legs[3 - leg].x = 1000 + round(way * tick * mate)
        assert may_be_late(walk, leg) == late


@pytest.mark.parametrize(("name", "pushes", "held"), [
    ("pupper", 0.25, 0), ("pupper", 0.32, 1), ("parallel", 0.25, 0), ("parallel", 0.32, 1),
    ("solo12", 0.15, 0), ("solo12", 0.20, 1),  # soft legs are behind by 0.06 of their length before that
])
def test_a_foot_is_held_up_when_it_pushes_with_0_285_of_the_weight(name, pushes, held):
    """pushes: with which share of the weight, by the thigh's spring and the height of the hips."""
    robot = load_robot(name)
    _, params, walk = stood(name)
    gives_m = pushes * robot.mass_kg * 9.81 * robot.stance.rest_height_m**2 / joint_drives(robot)[1].stiffness_Nm_rad
    walk.state.foot_speed.x, walk.state.swing_q15 = 400 << LF_BITS, 10000
    for leg in range(4):
        walk.residual_x[:] = [0] * 4
        unpack(walk.before, [0] * 12)
        unpack(walk.measured, [100] * 12)
        walk.residual_x[leg] = -round(gives_m * (1 << params.length_shift))
        detect_held_up(params, walk, leg)
        assert walk.held_up[leg] == held


@pytest.mark.parametrize(("mate_lag", "apart", "held"), [(0, 27, 1), (40, 27, 0), (40, 37, 1), (-40, 27, 1)])
@pytest.mark.parametrize("way", [1, -1])
def test_feet_whose_drives_are_at_their_limits_may_be_further_apart(way, mate_lag, apart, held):
    """Lags in Q10 of the leg, late in a swing; 26 of it is the limit for a mate that is where it should be."""
    _, params, walk = stood("caramelo")
    walk.state.foot_speed.x, walk.state.swing_q15 = way * 400 << LF_BITS, 20000
    part = params.leg_length / 1024
    for leg in range(4):
        unpack(walk.before, [0] * 12)
        unpack(walk.measured, [0] * 12)
        walk.measured.legs[3 - leg].x = way
        walk.residual_x[leg] = -way * round((mate_lag + apart) * part)
        walk.residual_x[3 - leg] = -way * round(mate_lag * part)
        detect_held_up(params, walk, leg)
        assert walk.held_up[leg] == held


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_late_is_the_same_in_floats(name):
    twin, _, walk = stood(name)
    rng = random.Random(3)
    metre = 1 << load_robot(name).length_shift
    for _ in range(3000):
        speed, swing = rng.randint(-600, 600), rng.randint(0, 32767)
        moved = [rng.randint(-1500, 1500) for _ in range(4)]
        walk.state.foot_speed.x, walk.state.swing_q15 = speed << LF_BITS, swing
        twin.foot_speed[0], twin.u = speed / metre / twin.dt, swing / 32768
        for leg in range(4):
            walk.before.legs[leg].x, walk.measured.legs[leg].x = 0, moved[leg]
        twin.before, twin.measured = [[0.0]] * 4, [[step / metre] for step in moved]
        for leg in range(4):
            if abs(moved[leg]) != abs(speed) and abs(swing - 13107) > 1:
                assert may_be_late(walk, leg) == int(twin.may_be_late(leg))
