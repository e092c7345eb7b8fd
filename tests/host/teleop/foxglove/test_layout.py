"""The layout file: its panels are placed, and show and publish topics that there are."""

import json
import re

import pytest

from host.control.telemetry import Extra, status
from host.records.channels import CHANNELS, DRAWN
from host.teleop.foxglove.viewers import COMMAND, SPEED, Viewers
from tests import ROOT
from tests.host.control.rig import Rig

LAYOUT = json.loads((ROOT / "host/teleop/foxglove/layout.json").read_text())
PANELS = LAYOUT["configById"]
PATH = re.compile(r"(/\w+)\.(\w+)(?:\[(\d+)\])?")


def places(node):
    """Yield the panels of a part of the layout."""
    if isinstance(node, str):
        yield node
    else:
        yield from places(node["first"])
        yield from places(node["second"])


def test_every_panel_has_its_place():
    assert sorted(places(LAYOUT["layout"])) == sorted(PANELS)


def paths():
    for panel in PANELS.values():
        yield from (each["value"] for each in panel.get("paths", ()))
        if "topicPath" in panel:
            yield panel["topicPath"]


@pytest.mark.parametrize("path", list(paths()))
def test_what_is_plotted_is_told(path):
    topic, name, at = PATH.fullmatch(path).groups()
    if topic == "/status":
        rig = Rig()
        rig.run(0.1)
        value = status(rig.loop, Extra())[name]
        assert at is None or len(value) > int(at)
    else:
        assert int(at) < CHANNELS[topic][name]["maxItems"]


def test_the_picture_is_of_topics_that_there_are():
    picture = PANELS["3D!robot"]
    assert set(picture["topics"]) <= set(DRAWN)
    assert (picture["followTf"], picture["layers"]["grid"]["frameId"]) == ("base_link", "odom")


def test_what_it_publishes_is_taken():
    heard, told = [], []
    viewers = Viewers("123456", heard.append, told.append)
    viewers.take(1, COMMAND, b'{"type": "pair", "code": "123456"}')
    published = [panel for panel in PANELS.values() if "topicName" in panel]
    assert {panel["topicName"] for panel in published} == {COMMAND}
    for panel in published:
        viewers.take(1, panel["topicName"], panel["value"].encode())
    assert PANELS["Teleop!drive"]["topic"] == SPEED
    assert viewers.malformed == 0
    assert [each["message"]["type"] for each in heard] == ["posture", "posture", "reset", "stop"]
