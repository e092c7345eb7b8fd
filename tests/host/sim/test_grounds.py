"""Grounds by name: each is in both simulators what it is called, and what can't be is refused in one line."""

from dataclasses import replace

import pytest

from host.robot.file import load_robot
from host.sim.grounds import NAMES, ONLY_SPACE, GroundSpec, make_ground, make_terrain
from host.sim.walk import Push, WalkSpec, run_walk
from host.util.errors import UserError


@pytest.mark.parametrize("name", sorted({*NAMES} - {"flat"}))
def test_every_ground_is_there_in_space_and_by_its_seed_alone(name):
    spec = GroundSpec(name)
    assert make_ground(spec).blocks
    assert make_ground(replace(spec, seed=1)) == make_ground(replace(spec, seed=1))
    assert (make_ground(spec) == make_ground(replace(spec, seed=1))) == (name not in ("stones", "gravel"))


def test_stairs_and_slopes_end_where_they_say():
    """Eight steps of 40 mm, 0.25 m apart; 0.8 m of slope."""
    for kind, sign in (("up", 1), ("down", -1)):
        stairs, slope = (make_terrain(GroundSpec(f"{name}-{kind}", angle_deg=10.0)) for name in ("stairs", "slope"))
        assert stairs.height_m(0.36 + 7 * 0.25) == pytest.approx(sign * 8 * 0.04)
        assert stairs.height_m(0.36 + 3 * 0.25) == pytest.approx(sign * 4 * 0.04)
        assert slope.height_m(3.0) == pytest.approx(sign * 0.8 * 0.17365, abs=1e-5)


def test_only_space_has_a_step_askew_and_one_under_the_left_legs():
    """In space one is turned by 20 deg and the other ends in the middle; the plane refuses both."""
    square, askew, left = (make_ground(GroundSpec(name)).blocks[0] for name in ("step", "angled", "left"))
    assert (square.yaw_rad, askew.yaw_rad) == (0.0, pytest.approx(0.349, abs=1e-3))
    assert left.centre_m[1] - left.half_m[1] == 0.0
    for name in ONLY_SPACE:
        with pytest.raises(UserError, match="no left and right"):
            run_walk(WalkSpec(load_robot("caramelo"), "trot", ground=GroundSpec(name)))


def test_the_plane_has_no_other_way_and_nobody_who_pushes():
    for more in ({"way": "left"}, {"push": Push(1.0, (5.0, 0.0))}):
        with pytest.raises(UserError, match="ahead"):
            run_walk(WalkSpec(load_robot("caramelo"), "trot", **more))


def test_grounds_are_refused_in_one_line():
    for make, told in (
        (lambda: GroundSpec("moon"), "--terrain moon: allowed flat, stones"),
        (lambda: GroundSpec("ramp", 0.02), "--height: ramp has no height"),
        (lambda: make_ground(GroundSpec("step", 0.9)), "height_m"),
        (lambda: make_terrain(GroundSpec("stairs-up", length_m=0.01)), "length_m"),
    ):
        with pytest.raises(UserError, match=told):
            make()
