"""A robot file that passes the check can be used: everything that is made from one is made from 1 500 mutated ones."""

import random
import re
from importlib.util import find_spec

import pytest

from host.robot.file import FOLDER, load_robot, robot_names
from host.util.errors import UserError
from shared.gait.gaits import GAIT_NAMES

NUMBER = re.compile(r"(?<![\w.+-])-?\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])")


def mutated(text, dice):
    """Return a robot file with one to three of its numbers changed, most of them by little."""
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        lines = text.splitlines()
        at = dice.choice([i for i, line in enumerate(lines) if " = " in line and NUMBER.search(line.split("#")[0])])
        value, _, comment = lines[at].partition("#")
        key, _, value = value.partition(" = ")
        found = dice.choice(list(NUMBER.finditer(value)))
        lines[at] = f"{key} = {value[:found.start()]}{other(found[0], dice)}{value[found.end():]}#{comment}"
        text = "\n".join(lines)
    return text


def other(number, dice):
    """Return another number than this: the same kind, mostly a little larger or smaller."""
    if "." not in number and "e" not in number and dice.random() < 0.9:
        whole = int(number)
        far = round(whole * 10 ** dice.uniform(-1, 1))
        return str(dice.choice((0, 1, -whole, whole + 1, whole * 2, whole // 2, far)))
    value = float(number) or 0.01
    factor = dice.choice((dice.uniform(0.5, 2), 10 ** dice.uniform(-1, 1), 10 ** dice.uniform(-4, 4)))
    return repr(dice.choice((0.0, -value, value * factor, value * factor, value * factor)))


def build_everything(robot):
    """Make what the commands make of a robot before they run it."""
    from host.commands.robots import ability_rows, derived, overview
    from host.control.planner import Driver
    from host.control.safety import torque_limit
    from host.robot.ability import ability, cannot
    from host.robot.plane import planar_robot
    from host.robot.scale import attitude_block
    from host.robot.urdf import urdf
    from host.sim.export.mjcf import mjcf

    overview(robot), derived(robot)
    known = ability(robot)
    ability_rows(robot, known), list(cannot(robot, known))
    for planar in (False, True):
        driver = Driver(robot, planar=planar)
        for gait in GAIT_NAMES:
            driver.set_command(mode="walk", gait=gait, vx_m_s=0.05)
            driver.sense(None)
            driver.step()
    attitude_block(robot)
    torque_limit(robot, "standing")
    mjcf(robot), urdf(robot), planar_robot(robot)
    if robot.actuator.kind == "bldc":
        from host.robot.joint_gains import joint_blocks
        from host.robot.joint_setups import joint_setups

        for setup in joint_setups(robot):
            joint_blocks(robot.actuator, setup)
    if find_spec("pymunk"):
        build_in_the_plane(robot)


def build_in_the_plane(robot):
    """Make the plane's world, and let it take a step with what drives it in a walk and in teleoperation."""
    from host.robot.plane import planar_robot
    from host.robot.poses import seated_pose_rad
    from host.sim.motor.walking import joint_motors
    from host.sim.plant import JointPlant, PlanePlant
    from sim2d.terrain import flat
    from sim2d.world import World

    plane = planar_robot(robot)
    actuator = joint_motors(robot) if robot.actuator.kind == "bldc" else None
    for own in (None, actuator):
        world = World(plane, flat(), actuator=own)
        world.place(plane.stand_pose_rad)
        world.advance([0.0] * 8, 2)
    JointPlant(robot, seated_pose_rad(robot)).advance_to(0.01)
    if robot.actuator.kind == "servo":
        PlanePlant(robot, seated_pose_rad(robot)).advance_to(0.01)


def build_in_space(robot):
    from host.sim.export.mjcf import ModelOptions
    from host.sim.space.world import World

    World(robot, ModelOptions(), robot.control.rate_hz).advance()


def survivors(folder, seed, count):
    """Yield the text and the robot of every mutant that passes the check; what fails is one line."""
    dice = random.Random(seed)
    texts = [(FOLDER / f"{name}.toml").read_text() for name in robot_names()]
    path = folder / "mutant.toml"
    for _ in range(count):
        path.write_text(mutated(dice.choice(texts), dice))
        try:
            yield path.read_text(), load_robot(str(path))
        except UserError as error:
            if not str(error).startswith(f"{path}: "):
                raise


@pytest.mark.parametrize(("seed", "count", "least", "in_space"), [
    (7, 200, 40, False), pytest.param(1, 1500, 300, find_spec("mujoco"), marks=pytest.mark.slow),
])  # fmt: skip
def test_of_mutated_files_all_that_pass_the_check_build(tmp_path, seed, count, least, in_space):
    passed = 0
    for text, robot in survivors(tmp_path, seed, count):
        passed += 1
        try:
            build_everything(robot)
            if in_space:
                build_in_space(robot)
        except Exception as error:
            pytest.fail(f"{error!r} of a file that passed:\n{text}")
    assert passed > least


def with_numbers(tmp_path, robot="caramelo", **numbers):
    """Write a robot's file with other numbers at the first place of each key, and return its path."""
    text = (FOLDER / f"{robot}.toml").read_text()
    for key, value in numbers.items():
        text, found = re.subn(rf"(?m)^{key} = \S+", f"{key} = {value}", text, count=1)
        assert found
    path = tmp_path / "my.toml"
    path.write_text(text)
    return path


LONG_LEGS = {"thigh_m": 0.16, "calf_m": 0.16, "rest_height_m": 0.22, "sit_height_m": 0.16, "mass_kg": 3.0}


def test_a_robot_too_heavy_for_its_servos_is_refused_in_physical_terms(tmp_path):
    """It passed the check, and the walk died of a joint that gave 5220 turns."""
    path = with_numbers(tmp_path, **LONG_LEGS)
    with pytest.raises(UserError) as caught:
        load_robot(str(path))
    line = str(caught.value)
    assert line.startswith(f"{path}: gait.sag_compensation: value 1: allowed: at most 0.")
    for words in ("3.92 kg", "deg at", "% of its stall torque", "actuator.duty_per_rad", "lighter"):
        assert words in line
    most = re.search("at most ([0-9.]+):", line)[1]
    build_everything(load_robot(str(with_numbers(tmp_path, **LONG_LEGS, sag_compensation=most))))


@pytest.mark.parametrize(
    ("robot", "numbers", "start"),
    [
        ("caramelo", {"armature_kg_m2": 0.0}, "actuator.armature_kg_m2: value 0.0: allowed: at least 0.00072"),
        ("caramelo", {"foot_radius_m": 0.0}, "geometry.foot_radius_m: value 0.0: allowed: a number within 0.001"),
        ("parallel", {"ratio": 1.1}, "calf_drive.ratio: value 1.1: allowed: 1 for"),
        ("parallel", {"pwm_hz": 10000}, "actuator.drive.pwm_hz 10000: allowed 12000"),
        ("parallel", {"pole_pairs": 50}, "actuator.motor.inductance_H: gives"),
        ("parallel", {"rotor_inertia_kg_m2": 1.2e-4}, "actuator.drive.velocity_bandwidth_hz 30: gives a stiffness"),
        ("parallel", {"inductance_H": 1e-5}, "actuator.motor.inductance_H 1e-05: the PWM ripple"),
    ],
)
def test_what_only_a_builder_can_know_is_refused_by_the_check(tmp_path, robot, numbers, start):
    path = with_numbers(tmp_path, robot, **numbers)
    with pytest.raises(UserError) as caught:
        load_robot(str(path))
    assert str(caught.value).startswith(f"{path}: {start}")
