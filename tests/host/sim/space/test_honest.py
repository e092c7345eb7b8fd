"""The honest world in space: friction holds, gears have play, the supply sags, parts hit, soft ground gives."""

from dataclasses import replace
from math import degrees, radians

import numpy as np
import pytest

from host.robot.actuators import Friction
from host.robot.file import load_robot
from host.robot.poses import rest_pose_rad
from host.sim.export.mjcf import ModelOptions
from host.sim.space.walk import FAST, figures, walk_in_space
from host.sim.space.world import World
from host.sim.walk import WalkSpec

ROBOT = load_robot("caramelo").simulated(True)
THIGH, CALF = 1, 2


def changed(actuator=None, simulation=None):
    """Return the robot in an honest world, with other numbers in its tables."""
    return ROBOT.model_copy(update={
        "actuator": ROBOT.actuator.model_copy(update=actuator or {}),
        "simulation": ROBOT.simulation.model_copy(update=simulation or {}),
    })  # fmt: skip


def world_of(robot, **more):
    dt_s, impratio = FAST
    return World(robot, ModelOptions(dt_s=dt_s, impratio=impratio, **more), 50)


def limp_in_space(robot):
    """Return a robot on a stand, its drives off, without weight."""
    world = world_of(robot, on_a_stand=True)
    world.model.opt.gravity[:] = 0.0
    world.drives.switch([False] * 12, [1.0] * 12)
    return world


def pushed(world, joint, torque_Nm, seconds):
    """Push what a joint's gear turns for so long; return how far it went, rad."""
    began = world.true_joints_rad()[joint]
    for at in (world.joints.v, world.joints.play_v):
        world.data.qfrc_applied[at[joint]] = torque_Nm
    for _ in range(round(50 * seconds)):
        world.advance()
    return world.true_joints_rad()[joint] - began


@pytest.mark.parametrize("joint", [THIGH, CALF])
@pytest.mark.parametrize("backlash_deg", [0.0, 0.33])
def test_a_joint_on_a_slope_holds_by_friction_and_slips_at_the_computed_torque(joint, backlash_deg):
    robot, f = changed({"backlash_deg": backlash_deg}), ROBOT.actuator.friction
    # Without torque friction holds up to coulomb + stribeck + shares x load = load, at the shaft.
    slips_Nm = (ROBOT.actuator.coulomb_Nm + f.stribeck_Nm) / (1 - f.load_external - f.load_external_stribeck)
    slips_Nm /= ROBOT.calf_drive.ratio if joint == CALF else 1.0

    def slid(torque_Nm):
        world = limp_in_space(robot)
        for share in range(1, 51):  # pushed more and more: what falls through its play hits too hard
            pushed(world, joint, torque_Nm * share / 50, 0.02)
        return abs(pushed(world, joint, torque_Nm, 0.5))

    assert slid(0.97 * slips_Nm) < radians(0.05)
    assert slid(1.03 * slips_Nm) > radians(1.0)


@pytest.mark.parametrize("joint", [THIGH, CALF])
def test_a_play_of_one_degree_shows_as_one_degree(joint):
    world = limp_in_space(changed({"backlash_deg": 1.0}))
    pushed(world, joint, -0.002, 1.0)
    gone = degrees(pushed(world, joint, 0.002, 1.0))
    assert gone == pytest.approx(1.0 * (ROBOT.calf_drive.ratio if joint == CALF else 1.0), rel=0.03)


def test_the_supply_sags_by_the_current_times_the_resistance():
    """All twelve at their stops with full duty; the current falls with the voltage."""
    world = world_of(changed({"supply_ohm": 0.15}), on_a_stand=True)
    world.drives.act([9.0] * 12)
    for _ in range(100):
        world.advance()
    blocked_A = 12 * ROBOT.actuator.stall_A
    wanted_V = 12.0 / (1 + 0.15 * blocked_A / 12.0)
    assert world.drives.battery.voltage_V == pytest.approx(wanted_V, rel=0.01)
    shares = np.abs(world.drive_torques_Nm()) * np.array([1, 1, ROBOT.calf_drive.ratio] * 4) / 2.5
    assert shares == pytest.approx(wanted_V / 12.0, rel=0.01)


def test_with_every_number_zero_it_stands_as_the_simple_world_does():
    plain = {"friction": Friction(), "backlash_deg": 0.0, "pwm_steps": 0, "supply_ohm": 0.0}
    heights = []
    for robot in (changed({**plain, "coulomb_Nm": 0.001, "backlash_deg": 0.001}), ROBOT.simulated(False)):
        calm = robot.model_copy(update={"actuator": robot.actuator.model_copy(update={"coulomb_Nm": 0.001})})
        world = world_of(calm)
        for _ in range(150):
            world.advance()
        heights.append(0.182 - world.position_m()[2])
    assert heights[0] == pytest.approx(heights[1], rel=0.03)
    assert heights[1] == pytest.approx(0.00431, rel=0.05)


@pytest.mark.parametrize("collide", [False, True])
def test_parts_of_the_robot_hit_each_other(collide):
    """Both front feet are told to go where the other is."""
    world = world_of(changed(simulation={"self_collision": collide}), on_a_stand=True)
    goal = np.array(rest_pose_rad(ROBOT))
    for leg in range(2):
        low, high = ROBOT.joint_limits_rad(leg)[0]
        goal[3 * leg] = low if ROBOT.side(leg) > 0 else high
    world.send(goal)
    apart_m = []
    for _ in range(100):
        world.advance()
        right, left = (world.data.geom(f"{leg}_foot").xpos for leg in ("FR", "FL"))
        apart_m.append(float(np.linalg.norm(right - left)))
    both_m = 2 * ROBOT.geometry.foot_radius_m
    if collide:
        assert apart_m[-1] == pytest.approx(both_m, rel=0.02)
        assert min(apart_m) > 0.8 * both_m, "at the blow"
    else:
        assert min(apart_m) < 0.6 * both_m


@pytest.mark.parametrize("ground_N_m", [1000.0, 4000.0])
def test_soft_ground_sinks_by_weight_over_stiffness(ground_N_m):
    world = world_of(changed(simulation={"ground_N_m": ground_N_m}))
    for _ in range(150):
        world.advance()
    radius_m = ROBOT.geometry.foot_radius_m
    sunk_m = [radius_m - float(world.data.geom(f"{leg}_foot").xpos[2]) for leg in ("FR", "FL", "RR", "RL")]
    assert sum(sunk_m) == pytest.approx(9.81 * ROBOT.mass_kg / ground_N_m, rel=0.03)
    assert sum(world.foot_loads_N()[0]) == pytest.approx(9.81 * ROBOT.mass_kg, rel=0.01)


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_it_walks_as_commanded_and_twice_alike_but_not_with_another_seed(name):
    robot = load_robot(name).simulated(True)
    walk = WalkSpec(robot, robot.gait.default, 0.1, distance_m=0.5)
    first = walk_in_space(walk)
    assert first.outcome.kind == "arrived"
    assert figures(first)["mean_speed_m_s"] == pytest.approx(0.1, rel=0.1)
    assert walk_in_space(walk).digest() == first.digest()
    assert walk_in_space(replace(walk, seed=1)).digest() != first.digest()
