"""The exported models: masses, geometry and the servo law are the robot file's, in every knee configuration."""

import math
import random
from xml.etree import ElementTree as Xml

import mujoco
import numpy as np
import pytest

from host.robot.file import load_robot
from host.robot.kinematics_si import leg_forward
from host.robot.model import KNEE_CONFIGURATIONS, LEG_NAMES
from host.robot.plane import planar_robot
from host.robot.poses import rest_pose_rad
from host.robot.urdf import urdf
from host.sim.export.ground import extrude
from host.sim.export.mjcf import STOP_MARGIN_RAD, ModelOptions, joint_names, mjcf
from host.sim.grounds import GroundSpec, make_ground
from sim2d import terrain
from tests.shared.robots import variant

ROBOTS = ("caramelo", "parallel")


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("knees", KNEE_CONFIGURATIONS)
def test_feet_are_where_the_kinematics_put_them(name, knees):
    robot = variant(name, knee_configuration=knees)
    model = mujoco.MjModel.from_xml_string(mjcf(robot, ModelOptions(on_a_stand=True)))
    data = mujoco.MjData(model)
    assert float(model.body_mass.sum()) == pytest.approx(robot.mass_kg)
    draw = random.Random(1)
    for _ in range(20):
        limits = [robot.joint_limits_rad(leg) for leg in range(4)]
        data.qpos[:] = [draw.uniform(*limits[leg][joint]) for leg in range(4) for joint in range(3)]
        mujoco.mj_kinematics(model, data)
        for leg in range(4):
            hip = data.xpos[model.body("trunk").id] + np.array((*robot.hip_m(leg), 0))
            foot = data.geom_xpos[model.geom(f"{LEG_NAMES[leg]}_foot").id] - hip
            angles = tuple(data.qpos[3 * leg : 3 * leg + 3])
            assert foot == pytest.approx(leg_forward(robot.geometry.links_m, robot.side(leg), angles), abs=1e-9)


@pytest.mark.parametrize("name", ROBOTS)
def test_the_drive_law(name):
    """Torque = clip(stiffness x error, +-stall); a calf driven from the body answers to thigh + calf."""
    robot = load_robot(name)
    plane = planar_robot(robot)
    model = mujoco.MjModel.from_xml_string(mjcf(robot, ModelOptions(on_a_stand=True)))
    data = mujoco.MjData(model)
    pose = np.array(rest_pose_rad(robot))
    data.qpos[:] = pose
    data.ctrl[:] = pose
    if plane.calf_on_torso:
        data.ctrl[2::3] += pose[1::3]
    data.ctrl[1] += 0.01
    data.ctrl[2] -= 1.0
    mujoco.mj_forward(model, data)
    assert data.actuator_force[1] == pytest.approx(0.01 * plane.thigh_servo.stiffness_Nm_rad, rel=1e-6)
    assert data.actuator_force[2] == pytest.approx(-plane.calf_servo.stall_torque_Nm)
    felt_by_thigh = data.actuator_force[1] + (data.actuator_force[2] if plane.calf_on_torso else 0)
    assert data.qfrc_actuator[1] == pytest.approx(felt_by_thigh, rel=1e-6)


def test_voltage_payload_and_friction_reach_the_model():
    robot = load_robot("caramelo")
    model = mujoco.MjModel.from_xml_string(mjcf(robot, ModelOptions(payload_kg=2.0, friction=0.6, voltage_V=11.1)))
    assert float(model.body_mass.sum()) == pytest.approx(robot.mass_kg + 2.0)
    assert model.geom("FR_foot").friction[0] == pytest.approx(0.6)
    assert model.actuator("FR_thigh").forcerange[1] == pytest.approx(2.3)
    low, high = robot.joint_limits_rad(0)[1]
    assert model.joint("FR_thigh_joint").range == pytest.approx((low - STOP_MARGIN_RAD, high + STOP_MARGIN_RAD))


@pytest.mark.parametrize("shape", [terrain.ramp(10.0), terrain.step(0.04), terrain.step(-0.03, 0.35, None),
                                   terrain.box(0.04), terrain.stones(3)])
def test_ground_in_space_is_as_high_as_in_the_plane(shape):
    """Seen from above by MuJoCo's own ray, everywhere but within 3 mm of an edge."""
    robot = load_robot("caramelo")
    model = mujoco.MjModel.from_xml_string(mjcf(robot, ModelOptions(extrude(shape))))
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    hit, groups = np.zeros(1, dtype=np.int32), np.array([0, 0, 1, 0, 0, 0], dtype=np.uint8)
    for step in range(200):
        x = 0.01 * step + 0.0037
        if any(abs(x - corner) < 0.003 for corner, _ in shape.points_m):
            continue
        far = mujoco.mj_ray(model, data, np.array([x, 0.4, 2.0]), np.array([0, 0, -1.0]), groups, 1, -1, hit)
        assert 2.0 - far == pytest.approx(shape.height_m(x), abs=1e-6), x


@pytest.mark.parametrize("name", ROBOTS)
def test_urdf_is_a_tree_of_whole_links(name):
    robot = load_robot(name)
    root = Xml.fromstring(urdf(robot, payload_kg=1.0))
    links = {link.get("name") for link in root.findall("link")}
    joints = root.findall("joint")
    children = [joint.find("child").get("link") for joint in joints]
    assert len(children) == len(set(children)) == len(links) - 1
    assert links - set(children) == {"base_link"}
    assert all(joint.find("parent").get("link") in links for joint in joints)
    moving = [joint.get("name") for joint in joints if joint.get("type") == "revolute"]
    assert moving == joint_names()
    for joint in joints:
        if joint.get("type") == "revolute":
            limit = {key: float(value) for key, value in joint.find("limit").attrib.items()}
            assert limit["lower"] < limit["upper"]
            assert limit["effort"] > 0
            assert limit["velocity"] > 0
    mass = sum(float(mass.get("value")) for mass in root.iter("mass"))
    assert mass == pytest.approx(robot.mass_kg + 1.0)


def test_mujoco_reads_the_urdf_alike():
    """An independent reader of URDF finds the same mass and the feet at the same place."""
    robot = load_robot("caramelo")
    model = mujoco.MjModel.from_xml_string(urdf(robot).replace(
        "<robot name=\"caramelo\">", "<robot name=\"caramelo\"><mujoco><compiler fusestatic=\"false\"/></mujoco>"))
    data = mujoco.MjData(model)
    data.qpos[:] = rest_pose_rad(robot)
    mujoco.mj_kinematics(model, data)
    foot = data.xpos[model.body("RL_foot").id]
    wanted = (*robot.hip_m(3), 0.0)
    assert foot == pytest.approx([a + b for a, b in zip(wanted, robot.foot_m(3, 0.17), strict=True)], abs=1e-6)
    assert float(model.body_mass.sum()) == pytest.approx(robot.mass_kg)


def test_a_turned_slab_keeps_its_length():
    ground = extrude(terrain.step(0.02), yaw_rad=0.3)
    (block,) = ground.blocks
    assert 2 * block.half_m[0] == pytest.approx(0.6)
    assert math.sqrt(sum(part * part for part in block.quaternion)) == pytest.approx(1.0)


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("knees", KNEE_CONFIGURATIONS)
@pytest.mark.parametrize("ground", ["flat", "gravel"])
def test_it_loads_at_rest_within_its_limits_and_stands(name, knees, ground):
    """It loaded with straight legs, outside of their limits."""
    robot = variant(name, knee_configuration=knees)
    options = ModelOptions(make_ground(GroundSpec(ground)))
    model = mujoco.MjModel.from_xml_string(mjcf(robot, options))
    data = mujoco.MjData(model)
    for joint in joint_names():
        low, high = model.joint(joint).range
        assert low < float(data.joint(joint).qpos[0]) < high
    mujoco.mj_kinematics(model, data)
    feet = [float(data.geom(f"{leg}_foot").xpos[2]) for leg in LEG_NAMES]
    assert feet == pytest.approx([robot.geometry.foot_radius_m] * 4, abs=1e-6)
    assert np.array(model.key("rest").qpos) == pytest.approx(np.array(model.qpos0), abs=1e-6)
    height_m = float(data.body("trunk").xpos[2])
    mujoco.mj_resetDataKeyframe(model, data, model.key("rest").id)
    mujoco.mj_step(model, data, 500)
    assert float(data.body("trunk").xpos[2]) > 0.9 * height_m


def test_hips_are_drawn_and_touch_nothing():
    model = mujoco.MjModel.from_xml_string(mjcf(load_robot("caramelo")))
    for leg in LEG_NAMES:
        geom = model.geom(f"{leg}_hip")
        assert geom.contype == geom.conaffinity == 0
        assert model.geom_rgba[geom.id][3] == 1
