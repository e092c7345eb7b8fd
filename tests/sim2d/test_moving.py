"""The moving picture: well formed, everything in it, each body where the recording has it."""

import xml.etree.ElementTree as Xml
from dataclasses import replace

import numpy as np
import pytest

from sim2d import terrain
from sim2d.moving import ACROSS, FACES, PIXELS_PER_M, UP, moving_svg, projected
from sim2d.recording import Aside
from sim2d.run import simulate
from sim2d.view import FRAMES_PER_S

from .conftest import caramelo
from .helpers import Stand

SVG = "{http://www.w3.org/2000/svg}"
HALF_M = (0.15, 0.06, 0.035)


@pytest.fixture(scope="module")
def standing():
    robot = caramelo()
    return simulate(robot, Stand(robot.stand_pose_rad), terrain.gravel(seed=1, start_m=0.15), duration_s=2.0)


def numbers(text):
    return np.array([[float(number) for number in pair.split(",")] for pair in text.split()])


def first_and_last(shape):
    moving = shape.find(f"{SVG}animate")
    frames = moving.get("values").split(";") if moving is not None else [shape.get("points")]
    return numbers(frames[0]), numbers(frames[-1])


def test_legs_are_where_the_recording_has_them(standing):
    root = Xml.fromstring(moving_svg(standing, "it <stands>", HALF_M))
    assert root.find(f"{SVG}title").text == "it <stands>"
    legs = root.findall(f"{SVG}g/{SVG}polyline")
    assert len(legs) == 4
    for shape, leg in zip(legs, (1, 3, 0, 2), strict=True):  # the left ones behind
        for row, points in zip((0, -1), first_and_last(shape), strict=True):
            limb = np.array([standing.hip_xz_m[row, leg], standing.knee_xz_m[row, leg], standing.foot_xz_m[row, leg]])
            across = (points - points[0]) / PIXELS_PER_M * (1, -1)
            assert across == pytest.approx(limb - limb[0], abs=1.5 / PIXELS_PER_M)


def test_it_lasts_as_long_as_the_walk_and_loops(standing):
    root = Xml.fromstring(moving_svg(standing, "t", HALF_M))
    moving = [*root.iter(f"{SVG}animate"), *root.iter(f"{SVG}animateTransform")]
    assert {each.get("repeatCount") for each in moving} == {"indefinite"}
    seconds = float(standing.time_s[-1] - standing.time_s[0])
    for each in moving:
        assert float(each.get("dur").removesuffix("s")) == pytest.approx(seconds, abs=0.01)
        assert len(each.get("values").split(";")) == pytest.approx(seconds * FRAMES_PER_S, abs=2)


def test_a_run_of_one_row_is_a_picture():
    robot = caramelo(torso_half_height_m=0.25)  # its trunk lies on the ground at once
    fallen = simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=5.0)
    root = Xml.fromstring(moving_svg(fallen, "t", HALF_M))
    assert len(root.findall(f"{SVG}g/{SVG}polyline")) == 4
    assert list(root.iter(f"{SVG}animate")) == []


def parts(root, name):
    return root.find(f".//{SVG}g[@id='{name}']").findall(f"{SVG}polygon")


def test_ground_and_stones_are_there(standing):
    root = Xml.fromstring(moving_svg(standing, "t", HALF_M))
    assert len(parts(root, "torso")) == len(FACES)
    assert len(parts(root, "stones")) == 2 * len(standing.terrain.loose)
    assert len(parts(root, "ground")) >= 2


def test_a_riser_that_faces_away_is_not_drawn():
    robot = caramelo()
    up, down = (simulate(robot, Stand(robot.stand_pose_rad), ground, duration_s=0.2)
                for ground in (terrain.step(0.03, length_m=None), terrain.step(-0.03, length_m=None)))  # fmt: skip
    shapes = [len(parts(Xml.fromstring(moving_svg(one, "t", HALF_M)), "ground")) for one in (up, down)]
    assert shapes == [4, 3]  # two treads and the near side, and going up the riser


def test_a_robot_that_turns_in_space_is_drawn_turned(standing):
    """The torso's corners and the feet are where a point of space is drawn, wherever the robot is and looks."""
    count = len(standing.time_s)
    to_the_left = np.broadcast_to([0.0, 0.0, np.pi / 2], (count, 3))
    aside = Aside(np.full(count, 0.3), to_the_left, np.full((count, 4, 3), 0.4))
    root = Xml.fromstring(moving_svg(replace(standing, aside=aside), "t", HALF_M))
    origin = first_and_last(root.findall(f"{SVG}g/{SVG}polyline")[0])[0][2] / PIXELS_PER_M
    foot = projected(np.array([standing.foot_xz_m[0, 1, 0], 0.4, standing.foot_xz_m[0, 1, 1]]))
    top = first_and_last(parts(root, "torso")[-1])[0] / PIXELS_PER_M
    for drawn, (along, across) in zip(top, ((-1, -1), (1, -1), (1, 1), (-1, 1)), strict=True):
        ahead, left = -across * HALF_M[1], along * HALF_M[0]
        corner = np.array([standing.torso_x_m[0] + ahead, 0.3 + left, standing.torso_z_m[0] + HALF_M[2]])
        assert (drawn - origin) * (1, -1) == pytest.approx(projected(corner) - foot, abs=2.5 / PIXELS_PER_M)
    assert projected(np.array([1.0, 2.0, 3.0])) == pytest.approx([1 + 2 * ACROSS, 3 + 2 * UP])
