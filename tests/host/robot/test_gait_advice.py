"""Which gaits are advised for which robot: the robot file's own words, and a word for those it does not name."""

import re

import pytest

from host.robot.file import driven_names, load_robot
from host.robot.gait_advice import UNTRIED, WALKED_IN_SPACE, gait_advice, why_not_advised
from shared.gait.gaits import GAIT_NAMES
from tests import ROOT

DOCS = ROOT / "docs" / "gaits.md"


def advising(name, advised_m_s):
    """Return a robot that advises these gaits up to these speeds, and says nothing of others."""
    robot = load_robot(name)
    gait = robot.gait.model_copy(update={"advised_m_s": advised_m_s, "not_advised": {}})
    return robot.model_copy(update={"gait": gait})


@pytest.mark.parametrize("name", driven_names())
def test_the_robots_that_come_along_have_tried_every_gait(name):
    robot = load_robot(name)
    advice = gait_advice(robot)
    assert tuple(advice) == GAIT_NAMES
    assert UNTRIED not in advice.values()
    assert advice[robot.gait.default] == ""


def test_advice_goes_up_to_a_speed():
    robot = load_robot("caramelo")
    assert why_not_advised(robot, "trot", 0.3) == ""
    assert why_not_advised(robot, "trot", -0.3) == ""
    assert why_not_advised(robot, "trot", 0.4) == "tried only up to 0.3 m/s"
    assert "kept for comparison" in why_not_advised(robot, "paper-trot")


def test_a_gait_that_the_robot_file_does_not_name_has_not_been_tried():
    assert set(gait_advice(advising("caramelo", {})).values()) == {UNTRIED}


def test_who_walks_in_space_is_not_sent_there():
    """`caramelo walk --in space` advised to try `caramelo walk --in space`."""
    robot = advising("caramelo", {"trot": 0.3})
    assert why_not_advised(robot, "crawl", 0.05, in_space=True) == WALKED_IN_SPACE
    assert "--in space" in UNTRIED
    assert "--in space" not in WALKED_IN_SPACE
    assert why_not_advised(robot, "trot", 0.4, in_space=True) == "tried only up to 0.3 m/s"


@pytest.mark.parametrize("name", driven_names())
def test_the_docs_say_of_every_gait_what_the_robot_file_says(name):
    text = " ".join(re.sub(r"[ |\n]+", " ", DOCS.read_text()).split())
    robot = load_robot(name)
    for gait, most_m_s in robot.gait.advised_m_s.items():
        assert f"`{gait}` on {name.capitalize()} up to {most_m_s:g} m/s" in text
    for gait, reason in robot.gait.not_advised.items():
        assert f"`{gait}` on {name.capitalize()} no: {reason}" in text
