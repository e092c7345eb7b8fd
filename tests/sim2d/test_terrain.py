"""The ground: heights, edges, seeds, refused numbers."""

import math

import pytest

from sim2d import terrain


def test_flat_is_level_everywhere():
    ground = terrain.flat()
    assert {ground.height_m(x) for x in (-50.0, -1.0, 0.0, 3.3, 500.0)} == {0.0}
    assert ground.finish_x_m is None


def test_ramp_goes_up_along_and_down():
    ground = terrain.ramp(5.34, start_m=0.4, length_m=1.0)
    rise, run = math.sin(math.radians(5.34)), math.cos(math.radians(5.34))
    assert ground.height_m(0.4 + run / 2) == pytest.approx(rise / 2)
    assert ground.height_m(0.4 + run + 0.25) == pytest.approx(rise)
    assert ground.height_m(0.4 + 2 * run + 0.5 + 0.01) == 0.0
    assert ground.finish_x_m > 0.4 + 2 * run + 0.5


def test_step_has_vertical_edges_whose_upper_end_counts():
    ground = terrain.step(0.03, start_m=0.35, length_m=0.6)
    below = math.nextafter(0.35, 0)
    assert [ground.height_m(x) for x in (below, 0.35, 0.5, 0.95, 0.951)] == [0.0, 0.03, 0.03, 0.03, 0.0]
    assert terrain.step(-0.02, length_m=None).height_m(5.0) == -0.02


def test_highest_between_two_points_either_way_round():
    ground = terrain.box(0.04, start_m=0.35, length_m=0.05)
    assert ground.highest_m(0.3, 0.5) == ground.highest_m(0.5, 0.3) == 0.04
    assert ground.highest_m(0.45, 0.5) == 0.0


@pytest.mark.parametrize("seed", range(5))
def test_stones_stay_below_their_height_and_differ_by_seed(seed):
    ground = terrain.stones(seed, height_m=0.012)
    heights = [z for _, z in ground.points_m]
    assert 0.008 < max(heights) <= 0.012
    assert min(heights) == 0.0
    assert ground == terrain.stones(seed)
    assert ground.points_m != terrain.stones(seed + 1).points_m


def test_gravel_lies_on_the_ground_without_overlap():
    ground = terrain.gravel(3)
    for stone, following in zip(ground.loose, ground.loose[1:], strict=False):
        assert stone.x_m + stone.z_m < following.x_m - following.z_m
        assert max(math.hypot(x, z) for x, z in stone.corners_m) <= stone.z_m * (1 + 1e-9)


@pytest.mark.parametrize(
    "make",
    [
        lambda: terrain.ramp(60.0),
        lambda: terrain.ramp(5.0, start_m=0.0),
        lambda: terrain.step(0.5),
        lambda: terrain.step(0.02, length_m=-1.0),
        lambda: terrain.box(-0.01),
        lambda: terrain.stones(1, height_m=0.2),
        lambda: terrain.gravel(1, length_m=50.0),
        lambda: terrain.step(math.nan),
    ],
)
def test_a_bad_number_is_refused_in_one_line_that_says_what_is_allowed(make):
    with pytest.raises(ValueError, match=r"^terrain: \w+ = .*: allowed .* \.\. .*$"):
        make()


def test_a_ground_that_goes_back_is_refused():
    with pytest.raises(ValueError, match="must go forward"):
        terrain.Terrain("fold", ((0.0, 0.0), (1.0, 0.0), (0.5, 0.1)))
