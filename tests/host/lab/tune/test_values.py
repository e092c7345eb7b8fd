"""What of a robot file is searched: what somebody chose, between bounds that hold it; and the robots it makes."""

import pytest

from host.lab.tune.values import LIMIT, RobotFile
from host.robot.file import FOLDER, load_robot, robot_names
from host.robot.trot_tuning import GAIT, NUMBERS
from host.util.errors import UserError

OWN = {f"trot.{name}" for name in NUMBERS}


def keys(file, speed=False, gait=GAIT):
    return {each.key for each in file.searched(gait, speed)}


def test_what_was_chosen_is_searched_and_what_was_measured_or_published_is_not():
    assert keys(RobotFile("solo12")) == OWN | {
        "stance.rest_height_m", "stance.foot_forward_m", "stance.foot_outward_m"}
    assert keys(RobotFile("caramelo")) == OWN  # its stance is that of its configuration
    assert keys(RobotFile("caramelo"), speed=True) == OWN | {LIMIT}
    assert keys(RobotFile("caramelo"), speed=True, gait="paper-trot") == {LIMIT}  # a table has no such numbers


def test_a_number_of_the_trot_that_the_file_gives_is_searched_if_it_was_chosen(tmp_path):
    path = tmp_path / "my.toml"
    text = (FOLDER / "solo12.toml").read_text()
    path.write_text(text + "\n[trot]\nlow_lift = 0.1 # [-] (chosen)\nhigh_lift = 0.2 # [-] (measured)\n")
    found = {each.key: each.now for each in RobotFile(str(path)).searched(GAIT, False)}
    assert found["trot.low_lift"] == 0.1
    assert "trot.high_lift" not in found
    assert found["trot.level_share"] == NUMBERS["level_share"].usual


def test_nothing_to_search_is_told(tmp_path):
    path = tmp_path / "my.toml"
    text = (FOLDER / "solo12.toml").read_text().replace("(chosen)", "(measured)")
    own = "".join(f"{name} = {number.usual} # (measured)\n" for name, number in NUMBERS.items())
    path.write_text(f"{text}\n[trot]\n{own}")
    with pytest.raises(UserError, match=r"nothing to search: none of .* is marked chosen or tuned"):
        RobotFile(str(path)).searched(GAIT, False)


@pytest.mark.parametrize("name", robot_names())
def test_every_robots_own_values_lie_within_the_bounds_and_make_the_same_robot(name):
    file = RobotFile(name)
    searched = file.searched(GAIT, True)
    for each in searched:
        assert each.low <= each.now <= each.high
        assert each.at(each.share) == pytest.approx(each.now, rel=1e-3, abs=1e-9)
        assert each.at(-1.0) == pytest.approx(each.low, rel=1e-3)
        assert each.at(2.0) == pytest.approx(each.high, rel=1e-3)
    made = file.like({each.key: each.now for each in searched})
    given = load_robot(name)
    assert made is not None
    assert made.model_copy(update={"trot": {}}) == given.model_copy(update={"trot": {}})


def test_a_robot_that_can_not_be_used_is_none():
    file = RobotFile("solo12")
    assert file.like({"stance.rest_height_m": 0.9}) is None
    assert file.like({"trot.low_lift": 0.9}) is None


def test_the_written_copy_is_the_robot_that_was_tried(tmp_path):
    file = RobotFile("solo12")
    searched = file.searched(GAIT, True)
    values = {each.key: each.at(each.share + 0.02) for each in searched}
    path = tmp_path / "tuned.toml"
    path.write_text(file.rewritten(searched, values))
    assert load_robot(str(path)) == file.like(values)
    again = RobotFile(str(path))
    assert {each.key: each.now for each in again.searched(GAIT, True)} == values
    assert {(each.key, each.low, each.high) for each in again.searched(GAIT, True)} == {
        (each.key, each.low, each.high) for each in searched}


def test_a_file_with_a_byte_order_mark_is_read_and_written_like_any(tmp_path):
    """Some editors put it before UTF-8, and end lines otherwise."""
    path, copy = tmp_path / "marked.toml", tmp_path / "copy.toml"
    path.write_text((FOLDER / "solo12.toml").read_text(), encoding="utf-8-sig", newline="\r\n")
    file = RobotFile(str(path))
    assert file.robot == load_robot("solo12")
    copy.write_text(file.rewritten([], {}))
    assert load_robot(str(copy)) == file.robot
