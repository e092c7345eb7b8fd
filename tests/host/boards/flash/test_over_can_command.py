"""`caramelo flash --can`: a line for every joint, one JSON object, exit codes, one line for wrong use."""

import pytest

from firmware.can_update import VERSION
from host.boards.build.image_file import write_image_file
from host.sim.joints.sim_robot import SimPort
from shared.wire import names as w

from .can_joints import Bench, CanJoint, image_of, running

OLD, NEW = image_of(1, "old"), image_of(2)


@pytest.fixture
def robot(monkeypatch):
    """Return two joints on a simulated bus, whose end is the command's port."""
    bench = Bench([CanJoint(node, OLD) for node in (4, 5)])
    bench.settle()
    monkeypatch.setattr("host.bus.can.open.open_port", lambda bus, interface, channel: SimPort(bench))
    return bench.joints


@pytest.fixture
def image(tmp_path):
    path = tmp_path / "joint.caramelo"
    write_image_file(NEW, path)
    return str(path)


def test_each_joint_gets_a_line_and_a_second_time_has_nothing_to_do(run, robot, image):
    code, out, err = run("flash", image, "--can", "5", "4", "--dry-run")
    assert (code, err) == (0, "")
    old = f"build {OLD.about.build}, version 0.2.0, protocol {w.PROTOCOL_HASH:#06x}, slot a"
    assert out.splitlines() == [
        f"FL hip (node 4): runs {old}; would be flashed", f"FL thigh (node 5): runs {old}; would be flashed"]
    assert running(robot) == {OLD.about.build}
    code, out, err = run("flash", image, "--can", "4", "5")
    assert code == 0
    new = f"build {NEW.about.build}, version 0.2.0, protocol {w.PROTOCOL_HASH:#06x}, slot b"
    assert out.splitlines() == [f"FL hip (node 4): runs {new}, confirmed", f"FL thigh (node 5): runs {new}, confirmed"]
    parts = [line.split(":")[1].strip() for line in err.splitlines()]
    assert parts == ["erasing", "writing slot b", "verifying", "starting"]
    code, out, err = run("flash", image, "--can", "4", "5")
    assert (code, err) == (0, "")
    assert out.splitlines()[0] == f"FL hip (node 4): nothing to do: runs {new}"


def test_one_json_object_also_when_a_joint_goes_back(run_json, robot, image):
    robot[1].broken = (NEW.about.build,)
    code, told, err = run_json("flash", image, "--can", "4", "5")
    assert code == 1
    assert [joint["changed"] for joint in told["joints"]] == [True, False]
    assert told["joints"][1]["failure"] in err
    assert err.count("\n") == 1
    assert told["build"] == NEW.about.build


def test_all_wants_all_twelve(refused, robot, image):
    line = refused("flash", image, "--can", "--all", code=1)
    assert "FR hip (node 1) is not there: check its power, the CAN cable and both terminators" in line


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("take", lambda frame: None, "runs firmware that can't be updated over the bus: flash it once over USB"),
        ("_update", None, "is a simulated joint, whose flash can't be written"),
    ],
)
def test_a_joint_that_can_not_be_updated_is_told(refused, robot, image, monkeypatch, name, value, words):
    monkeypatch.setattr(robot[0].joint.updating, name, value)
    assert f"FL hip (node 4) {words}" in refused("flash", image, "--can", "4", "5", code=1)


def test_another_way_of_updating_is_told(refused, robot, image, monkeypatch):
    monkeypatch.setattr("firmware.can_update.VERSION", VERSION + 1)
    line = refused("flash", image, "--can", "4", "5")
    assert f"needs update version {VERSION + 1}, which this host does not know" in line


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--can",), "name the joints by number, 1 to 12, or all with --all"),
        (("--can", "3", "--all"), "name the joints by number, 1 to 12, or all with --all"),
        (("--can", "13"), "flash --can 13: allowed 1 to 12: FR hip 1, thigh 2, calf 3, then FL, RR, RL"),
        (("--can", "3", "--port", "/dev/null"), "--port and --id are for boards on USB"),
        (("3",), "go with --can"),
        (("--port", "/dev/null", "--robot", "caramelo"), "go with --can"),
        (("--can", "3", "--robot", "caramelo"), "caramelo has no joints on CAN"),
    ],
)
def test_wrong_use(refused, image, arguments, words):
    assert words in refused("flash", image, *arguments)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (image_of(1, protocol=0x1234), "the image speaks protocol 0x1234"),
        (image_of(1, board="CARAMELO_GAIT"), "is a CARAMELO_JOINT, but the image is for a CARAMELO_GAIT"),
    ],
)
def test_a_foreign_image(refused, robot, tmp_path, wrong, words):
    path = tmp_path / "wrong.caramelo"
    write_image_file(wrong, path)
    before = [joint.done for joint in robot]
    assert words in refused("flash", str(path), "--can", "4", "5")
    assert running(robot) == {OLD.about.build}
    assert [joint.done for joint in robot] == before  # nothing was programmed or erased
