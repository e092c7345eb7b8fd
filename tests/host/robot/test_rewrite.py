"""Values written into a robot file's text: nothing else changes, sources are read and set."""

import tomllib

import pytest

from host.robot.file import FOLDER, load_robot, robot_names
from host.robot.rewrite import NewValue, rewritten, sources, spreads


def text_of(name):
    return (FOLDER / f"{name}.toml").read_text()


@pytest.mark.parametrize("name", robot_names())
def test_every_number_of_a_robot_has_a_source(name):
    found = sources(text_of(name))
    data = tomllib.loads(text_of(name))
    assert set(found.values()) <= {"", "paper", "configuration", "urdf", "menagerie", "datasheet", "measured",
                                   "simulated", "derived", "assumed", "chosen"}
    numbers = [f"{table}.{key}" for table, inside in data.items() if isinstance(inside, dict) and table != "actuator"
               for key, value in inside.items() if type(value) in (int, float)]
    assert len(numbers) > 40
    assert [key for key in numbers if not found[key]] == []


@pytest.mark.parametrize("name", robot_names())
def test_without_values_a_file_stays_as_it_is_to_the_byte(name):
    assert rewritten(text_of(name), {}, "tuned") == text_of(name)


def test_only_the_lines_of_the_values_change_and_their_comments_keep_their_column(tmp_path):
    before = text_of("solo12")
    after = rewritten(before, {"stance.rest_height_m": NewValue(0.2345), "speed_limits.vx_m_s": NewValue(0.5)}, "tuned")
    changed = [(old, new) for old, new in zip(before.splitlines(), after.splitlines(), strict=True) if old != new]
    assert [old.partition(" ")[0] for old, _ in changed] == ["rest_height_m", "vx_m_s"]
    assert [old.replace("(chosen)", "(tuned)").partition("#")[2] for old, _ in changed] == [
        new.partition("#")[2] for _, new in changed]
    assert [old.index("#") for old, _ in changed] == [new.index("#") for _, new in changed]
    assert sources(after)["stance.rest_height_m"] == "tuned"
    path = tmp_path / "new.toml"
    path.write_text(after)
    assert load_robot(str(path)).stance.rest_height_m == 0.2345


def test_a_table_that_is_not_there_comes_in_with_what_its_numbers_mean(tmp_path):
    text = rewritten(text_of("solo12"), {"trot.low_lift": NewValue(0.1, "[of the leg] top of a swing")}, "tuned")
    assert text.startswith(text_of("solo12"))
    assert text.endswith("\n\n[trot]\nlow_lift = 0.1                         # [of the leg] top of a swing (tuned)\n")
    more = {"trot.low_lift": NewValue(0.12), "trot.level_share": NewValue(1.5, "[-] of it")}
    twice = rewritten(text, more, "tuned")
    assert twice.endswith("top of a swing (tuned)\nlevel_share = 1.5                      # [-] of it (tuned)\n")
    path = tmp_path / "new.toml"
    path.write_text(twice)
    assert load_robot(str(path)).trot == {"low_lift": 0.12, "level_share": 1.5}


def test_a_line_without_a_source_gets_one():
    assert rewritten("[a]\nx = 1.0\ny = 2 # why\n", {"a.x": NewValue(2.0), "a.y": NewValue(3.0)}, "tuned") == (
        "[a]\nx = 2.0 # (tuned)\ny = 3.0 # why (tuned)\n")


def test_what_was_measured_tells_its_spread():
    text = "[a]\nx = 1.0 # [N m] (2026-11-23, +-7 % between joints: measured)\ny = 2.0 # [deg] +-4 % (datasheet)\n"
    assert sources(text) == {"a.x": "measured", "a.y": "datasheet"}
    assert spreads(text) == {"a.x": 0.07}
    assert rewritten(text, {"a.x": NewValue(2.0)}, "tuned").startswith("[a]\nx = 2.0 # [N m] (tuned)\ny")
