"""The honest drives in the plane: against what can be computed by hand, and against the simple ones."""

from dataclasses import replace
from math import degrees, radians

import pytest

from host.robot.actuators import Friction
from host.robot.file import load_robot
from host.robot.plane import planar_robot
from host.robot.poses import rest_pose_rad, seated_pose_rad
from host.sim.plant import PlanePlant
from host.sim.servos.plane import honest_servos
from host.sim.walk import WalkSpec, run_walk
from sim2d import metrics, terrain
from sim2d.body import planar
from sim2d.world import World

ROBOT = load_robot("caramelo").simulated(True)
THIGH, CALF = 0, 1
RATIO = (1.0, ROBOT.calf_drive.ratio)
PLAIN = {"friction": Friction(), "backlash_deg": 0.0, "pwm_steps": 0, "supply_ohm": 0.0}


def changed(**actuator):
    return ROBOT.model_copy(update={"actuator": ROBOT.actuator.model_copy(update=actuator)})


class Pushed:
    """Drives, and a torque on one joint beside them."""

    def __init__(self, drives, joint):
        self.drives, self.joint, self.torque_Nm = drives, joint, 0.0

    def torques(self, goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm):
        self.drives.torques(goal_rad, position_rad, speed_rad_s, dt_s, torque_Nm)
        torque_Nm[self.joint] += self.torque_Nm


def hung(robot, joint=THIGH, on=False):
    """Return world, drives and push of a robot on a stand without weight; its drives are off."""
    plane, servos = honest_servos(robot, planar_robot(robot), None)
    pushed = Pushed(servos, joint)
    world = World(plane, terrain.flat(), actuator=pushed)
    world.space.gravity = (0.0, 0.0)
    world.place(plane.stand_pose_rad, lift_m=0.3)
    world.pin_torso()
    servos.most[:] = [1.0 if on else None] * 8
    return world, servos, pushed


def gone_rad(world, pushed, torque_Nm, seconds):
    pushed.torque_Nm = torque_Nm
    began = world.position_rad[pushed.joint]
    world.advance([0.0] * 8, round(1000 * seconds))
    return world.position_rad[pushed.joint] - began


@pytest.mark.parametrize("joint", [THIGH, CALF])
@pytest.mark.parametrize("backlash_deg", [0.0, 0.33])
def test_a_joint_on_a_slope_holds_by_friction_and_slips_at_the_computed_torque(joint, backlash_deg):
    f = ROBOT.actuator.friction
    slips_Nm = (ROBOT.actuator.coulomb_Nm + f.stribeck_Nm) / (1 - f.load_external - f.load_external_stribeck)
    slips_Nm /= RATIO[joint]

    def slid(torque_Nm):
        world, _, pushed = hung(changed(backlash_deg=backlash_deg), joint)
        for share in range(1, 101):  # more and more: what falls through its play hits too hard
            gone_rad(world, pushed, torque_Nm * share / 100, 0.01)
        return abs(gone_rad(world, pushed, torque_Nm, 0.5))

    assert slid(0.97 * slips_Nm) < radians(0.05)
    assert slid(1.03 * slips_Nm) > radians(1.0)


@pytest.mark.parametrize("joint", [THIGH, CALF])
def test_a_play_of_one_degree_shows_as_one_degree(joint):
    world, _, pushed = hung(changed(backlash_deg=1.0), joint)
    gone_rad(world, pushed, -0.001, 1.5)
    assert degrees(gone_rad(world, pushed, 0.001, 1.5)) == pytest.approx(RATIO[joint], rel=0.03)


def test_the_supply_sags_by_the_current_times_the_resistance():
    """All eight at their stops with full duty; the current falls with the voltage."""
    world, servos, _ = hung(changed(supply_ohm=0.15), on=True)
    world.advance([9.0] * 8, 2000)
    wanted_V = 12.0 / (1 + 0.15 * 8 * ROBOT.actuator.stall_A / 12.0)
    assert servos.battery.voltage_V == pytest.approx(wanted_V, rel=0.01)
    assert servos.given_Nm[THIGH] == pytest.approx(2.5 * wanted_V / 12.0, rel=0.01)


def test_with_every_number_zero_it_walks_as_the_simple_world_does():
    speeds = [metrics.mean_speed_m_s(run_walk(WalkSpec(robot, "trot", 0.1, distance_m=0.5)))
              for robot in (changed(**PLAIN), ROBOT.simulated(False))]
    assert speeds[0] == pytest.approx(speeds[1], rel=0.01)


def test_it_walks_as_commanded_and_twice_alike():
    walk = WalkSpec(ROBOT, "trot", 0.1, distance_m=0.5)
    first = run_walk(walk)
    assert metrics.mean_speed_m_s(first) == pytest.approx(0.1, rel=0.15)
    assert run_walk(walk).digest() == first.digest()
    assert run_walk(replace(walk, robot=ROBOT.simulated(False))).digest() != first.digest()


@pytest.mark.parametrize(("braking_Nms_rad", "rests"), [(None, True), (0.0, False)])
def test_limp_on_its_end_stops_it_comes_to_rest_but_not_where_they_only_spring(braking_Nms_rad, rests):
    """The rear thighs are at their stops; play parts the links from the friction of their drives."""
    plane, servos = honest_servos(ROBOT, planar_robot(ROBOT), None)
    if braking_Nms_rad is not None:
        plane = replace(plane, end_stop_Nms_rad=braking_Nms_rad)
    world = World(plane, terrain.flat(), actuator=servos)
    servos.most[:] = [None] * 8
    world.place((0.0, 0.0, -2.03, 0.0, 0.0, -1.29, 0.0, -0.02, -1.29, 0.0, -0.02, -1.29))
    world.advance([0.0] * 8, 4000)
    fastest_rad_s = 0.0
    for _ in range(200):
        world.advance([0.0] * 8, 1)
        fastest_rad_s = max(fastest_rad_s, abs(world.parts.bodies[0].angular_velocity))
    assert (fastest_rad_s < 1e-4) == rests


def test_standing_it_does_not_creep_and_off_it_sinks():
    plant = PlanePlant(ROBOT, seated_pose_rad(ROBOT))

    def after(seconds, pose_rad):
        plant.drives.goal_rad[:] = pose_rad
        for _ in range(round(seconds / 0.02)):
            plant.advance_to(plant.time_s + 0.02)
        return float(plant.world.parts.bodies[0].position.y)

    plant.drives.on[:] = [True] * 12
    stands_m = after(7.0, rest_pose_rad(ROBOT))  # it rocks a little on its play at first
    assert abs(after(1.0, rest_pose_rad(ROBOT)) - stands_m) < 1e-5
    plant.drives.limit[:] = [0.05] * 12
    after(0.1, rest_pose_rad(ROBOT))
    assert max(map(abs, plant.drives.load)) <= 0.05
    plant.drives.on[:] = [False] * 12
    assert after(1.0, rest_pose_rad(ROBOT)) < stands_m - 0.02
    assert planar(plant.drives.load) == [0.0] * 8
    plant.put_back()
    assert plant.position_rad == pytest.approx(seated_pose_rad(ROBOT))
