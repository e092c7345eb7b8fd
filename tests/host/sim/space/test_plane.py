"""The plane and space are two engines with one mechanics: the same legs swing the same body alike."""

import mujoco
import numpy as np
import pytest

from host.robot.file import load_robot
from host.robot.plane import planar_robot
from host.robot.poses import rest_pose_rad
from host.sim.export.mjcf import ModelOptions
from host.sim.space.world import World as Space
from sim2d import terrain
from sim2d.body import planar
from sim2d.world import World

DT_S = 0.001
SWING_STEPS = 100
SWINGING = (1, 10)  # thighs of FR and RL
SWING_RAD = 0.3


def in_space(robot):
    """Return a function that advances a robot that floats by one step and returns its pitch."""
    world = Space(robot, ModelOptions(dt_s=DT_S), round(1 / DT_S), bus_delay_s=0.0)
    world.model.opt.gravity[:] = 0
    world.data.qpos[2] += 1.0
    mujoco.mj_forward(world.model, world.data)

    def advance(goals):
        world.send(goals)
        world.advance()
        return world.attitude_rad()[1]

    return advance


def in_plane(robot):
    """The same in the plane."""
    world = World(planar_robot(robot), terrain.flat(), dt_s=DT_S)
    world.place(rest_pose_rad(robot), lift_m=1.0)
    world.space.gravity = (0, 0)

    def advance(goals):
        world.advance(planar(goals), 1)
        return -world.parts.bodies[0].angle

    return advance


@pytest.mark.parametrize("name", ["caramelo", "parallel", "unitree-a1"])
def test_a_diagonal_that_swings_pitches_a_floating_body_alike(name):
    """There and back three times. Pitch at the end of each swing, where legs and body are at rest.

    An armature that was the link's alone would keep the rotors' momentum through their gears: 3.5 degrees on Parallel,
    where it is 0.9.
    """
    robot = load_robot(name).simulated(False)
    rest = list(rest_pose_rad(robot))
    swung = [angle - SWING_RAD if joint in SWINGING else angle for joint, angle in enumerate(rest)]
    plane, space = in_plane(robot), in_space(robot)
    for swing in range(6):
        goals = rest if swing % 2 else swung
        pitches = [(plane(goals), space(goals)) for _ in range(SWING_STEPS)][-1]
        assert pitches[0] == pytest.approx(pitches[1], abs=np.radians(0.08))
        assert swing % 2 or pitches[1] > np.radians(0.8)
