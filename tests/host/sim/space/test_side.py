"""A walk in space as the plane records it: its points are MuJoCo's own, its figures and files those of any walk."""

import mujoco
import numpy as np
import pytest

from host.commands.walk import FILES
from host.robot.file import load_robot
from host.robot.model import LEG_NAMES
from host.sim.export.mjcf import ModelOptions
from host.sim.grounds import GroundSpec
from host.sim.space.side import recorded
from host.sim.space.walk import walk_in_space
from host.sim.space.world import World
from host.sim.walk import WalkSpec
from sim2d.recording import rotations
from sim2d.referee import Outcome


def frozen(spec, world, rng):
    """Return the recording of one instant: the robot anywhere, turned and bent at random."""
    data, robot, count = world.data, spec.robot, 12
    joints = np.array([rng.uniform(*robot.joint_limits_rad(leg)[joint]) for leg in range(4) for joint in range(3)])
    data.qpos[:3] = rng.uniform(-1, 1, 3)
    turn = rng.normal(size=4)
    data.qpos[3:7] = turn / np.linalg.norm(turn)
    data.qpos[7 : 7 + count] = joints
    mujoco.mj_forward(world.model, data)
    row, legs = np.zeros((1, count)), np.zeros((1, 4))
    attitude = np.array([world.attitude_rad()])
    columns = np.zeros(1), world.position_m()[None], attitude, joints[None], row, row, legs, np.zeros(1)
    return recorded(spec, columns, Outcome("completed", ""))


@pytest.mark.parametrize("name", ["caramelo", "parallel"])
def test_the_feet_are_where_mujoco_has_them(name):
    robot, rng = load_robot(name), np.random.default_rng(5)
    spec = WalkSpec(robot, "trot")
    world = World(robot.simulated(honest=False), ModelOptions(), 50)  # an honest joint is two hinges
    for _ in range(20):
        seen = frozen(spec, world, rng)
        feet = [world.data.geom(f"{leg}_foot").xpos[[0, 2]] for leg in LEG_NAMES]
        assert np.allclose(seen.foot_xz_m[0], feet, atol=1e-9)
        knees = [world.data.body(f"{leg}_calf").xpos[[0, 2]] for leg in LEG_NAMES]
        assert np.allclose(seen.knee_xz_m[0], knees, atol=1e-9)
        left = [[world.data.body(f"{leg}_calf").xpos[1], world.data.geom(f"{leg}_foot").xpos[1]] for leg in LEG_NAMES]
        assert np.allclose(seen.aside.leg_y_m[0, :, 1:], left, atol=1e-9)
        turn = world.data.body("trunk").xmat.reshape(3, 3)
        assert np.allclose(rotations(seen.aside.attitude_rad)[0], turn, atol=1e-9)


def test_a_walk_in_space_has_the_figures_and_files_of_any_walk(run_json, tmp_path):
    code, result, _ = run_json("walk", "--in", "space", "--distance", "0.2", "--out", str(tmp_path))
    assert code == 0, result["reason"]
    assert result["in"] == "space"
    assert result["distance_m"] >= 0.2
    assert result["torque_rms_fraction"]["FR_hip"] > 0, "in space the hips work too"
    assert {"roll_range_deg", "yaw_drift_deg", "side_drift_m", "min_clearance_m", "energy_per_metre_J"} <= set(result)
    assert {path.name for path in tmp_path.iterdir()} == set(FILES)


def test_another_world_is_refused(run):
    assert run("walk", "--in", "hyperspace") == (2, "", "caramelo: --in hyperspace: allowed plane or space\n")


def test_a_walk_that_falls_over_in_space_says_so():
    spec = WalkSpec(load_robot("caramelo"), "paper-trot", ground=GroundSpec("step-up", 0.06, start_m=0.3), limit_s=20.0)
    recording = walk_in_space(spec)
    assert not recording.outcome.ok
