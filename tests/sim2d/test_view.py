"""What the page and the picture show of a walk: the whole robot, the loose stones where they lie."""

import json
import math
import re

import numpy as np
import pytest

from host.lab.teleop.browser import missing, open_browser, patient
from sim2d import terrain
from sim2d.run import simulate
from sim2d.view import STONE_STEP_M, animation_html, path_png

from .conftest import caramelo
from .helpers import Stand

TORSO_HALF_M = (0.15, 0.035)
DATA = re.compile(r'<script id="data" type="application/json">(.*?)</script>', re.S)


def shown(recording):
    """Return the data in the page of a recording."""
    page = animation_html(recording, "title", "sentence", [("a", "b")], TORSO_HALF_M)
    return json.loads(DATA.search(page)[1])


class Fall(Stand):
    """Lets its front legs go until the robot lies on its nose."""

    def tick(self, sensed):
        super().tick(sensed)
        return [goal * (0.2 if leg < 2 else 1.6) for leg in range(4) for goal in self.pose_rad[leg * 3 : leg * 3 + 3]]


class Push(Stand):
    """Pushes its feet to and fro along the ground."""

    def tick(self, sensed):
        super().tick(sensed)
        swing = 0.5 * math.sin(20 * len(self.sensed) / self.rate_hz)
        return [goal + swing * (joint % 3 == 1) for joint, goal in enumerate(self.pose_rad)]


@pytest.fixture(scope="module")
def tall():
    """A robot with a trunk far larger than the view was made for, that stretches and folds its legs."""
    robot = caramelo()
    return simulate(robot, Fall(robot.stand_pose_rad), terrain.flat(), duration_s=1.0)


@pytest.fixture(scope="module")
def stony():
    robot = caramelo()
    ground = terrain.gravel(3, 0.012, start_m=0.15, length_m=0.3)
    return simulate(robot, Push(robot.stand_pose_rad), ground, duration_s=0.5, start_x_m=0.15)


def test_the_view_holds_the_whole_robot_at_every_instant(tall):
    data = shown(tall)
    aside, above, under = data["view_m"]
    length, height = TORSO_HALF_M
    for (x, z, pitch), ground, *limbs in zip(
        data["torso"], data["ground_z"], data["hip"], data["knee"], data["foot"], strict=True
    ):
        points = [point for limb in limbs for point in limb]
        for along in (-length, length):
            for up in (-height, height):
                points.append((x + along * math.cos(pitch) + up * math.sin(pitch),
                               z - along * math.sin(pitch) + up * math.cos(pitch)))
        assert all(abs(px - x) < aside and pz - ground < above and ground - pz < under for px, pz in points)


def test_loose_stones_are_drawn_where_they_lie(stony):
    data = shown(stony)
    assert len(data["stones"]) == len(stony.terrain.loose) > 5
    moved = stony.stone_xz_m[-1] - stony.stone_xz_m[0]
    assert np.hypot(*moved.T).max() > 10 * STONE_STEP_M  # the feet push some of them
    for stone, moves in enumerate(data["stone_moves"]):
        frame, x, z, turn = moves[-1]
        assert moves[0][0] == 0
        assert frame < len(data["time_s"])
        assert math.dist((x, z), stony.stone_xz_m[-1, stone]) < 2 * STONE_STEP_M
        assert turn == pytest.approx(stony.stone_turn_rad[-1, stone], abs=0.05)
        assert len(moves) <= len(data["time_s"])
    assert "stone_moves" in animation_html(stony, "t", "s", [], TORSO_HALF_M).split("</script>")[1]


def test_the_picture_has_the_stones_too(stony, monkeypatch, tmp_path):
    from matplotlib.axes import Axes

    filled = []
    draw = Axes.fill
    monkeypatch.setattr(Axes, "fill", lambda axes, *a, **more: filled.append(a) or draw(axes, *a, **more))
    path_png(stony, "title", tmp_path / "path.png")
    assert (tmp_path / "path.png").stat().st_size > 10_000
    assert len(filled) == 1 + 2 * len(stony.terrain.loose)


def test_a_run_of_one_row_is_drawn(tmp_path):
    robot = caramelo(torso_half_height_m=0.25)  # its trunk lies on the ground at once
    fallen = simulate(robot, Stand(robot.stand_pose_rad), terrain.flat(), duration_s=5.0)
    assert not fallen.outcome.ok
    assert len(fallen.time_s) == 1
    assert len(shown(fallen)["time_s"]) == 1
    path_png(fallen, "title", tmp_path / "path.png")


@pytest.fixture(scope="module")
def browser():
    if missing():
        pytest.skip(missing())
    with open_browser() as running:
        yield running


@pytest.mark.parametrize("motion", ["no-preference", "reduce"])
def test_the_page_starts_by_itself_and_begins_again_at_its_end(browser, tmp_path, stony, motion):
    """Where the system asks for less motion it waits for the button."""
    (tmp_path / "walk.html").write_text(animation_html(stony, "title", "sentence", [("a", "b")], TORSO_HALF_M))
    page = patient(browser.new_context(reduced_motion=motion)).new_page()
    page.goto((tmp_path / "walk.html").as_uri())
    if motion == "reduce":
        assert page.evaluate("playing") is False
        page.click("#play")
    page.wait_for_function("frame > 2")
    page.evaluate("frame = n - 1")
    page.wait_for_function("playing && frame > 0 && frame < n - 1")
    page.click("#play")
    assert page.evaluate("playing") is False
