"""What starts on a board: the gait board's stream and Ctrl-C, a joint's new id, the self-test, generated modules."""

import pytest

from firmware import link
from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.node_id import take_node
from firmware.selftest import self_test
from host.build.generated import APPLICATION, ROBOT_PARAMS, generated_modules
from host.robot_file import load_robot
from host.scale import attitude_block, core_params


class Usb:
    """A USB port with bytes waiting in it."""

    def __init__(self, data):
        self.data = list(data)
        self.interrupt = 3
        self.sent = b""

    def setinterrupt(self, byte):
        self.interrupt = byte

    def any(self):
        return bool(self.data)

    def readinto(self, buffer):
        if not self.data:
            return 0
        buffer[0] = self.data.pop(0)
        return 1

    def write(self, buffer):
        self.sent += bytes(buffer)
        return len(buffer)


@pytest.fixture
def stream_class(monkeypatch):
    """Return UsbStream; the module it lies in reads a generated one."""
    import sys
    import types

    robot = load_robot("caramelo")
    params = types.ModuleType("firmware.robot_params")
    params.PARAMS, params.ATTITUDE = core_params(robot), attitude_block(robot)
    monkeypatch.setitem(sys.modules, "firmware.robot_params", params)
    from firmware.start_gait import UsbStream

    return UsbStream


def test_a_frame_full_of_ctrl_c_does_not_stop_the_gait_board(stream_class):
    writer = link.Writer()
    writer.open(link.SENSED)
    for _ in range(4):
        writer.put(0x0303, 2)
    frame = bytes(writer.buffer[: writer.close()])
    assert frame.count(3) >= 8
    port = Usb(frame)
    stream, byte = stream_class(port), bytearray(1)
    assert port.interrupt == -1
    while stream.any():
        assert stream.readinto(byte) == 1
    stream.write(b"answer")
    assert port.sent == b"answer"


def test_ten_ctrl_c_in_a_row_stop_the_gait_board(stream_class):
    port = Usb(b"\x03" * 12)
    stream, byte = stream_class(port), bytearray(1)
    for _ in range(9):
        stream.readinto(byte)
    with pytest.raises(KeyboardInterrupt):
        stream.readinto(byte)
    assert port.interrupt == 3


def test_a_joint_takes_over_its_id_once_and_keeps_it(tmp_path):
    path, parameters = tmp_path / "node.txt", str(tmp_path / "joint.bin")
    path.write_text("7\n")
    joint = Joint(SimBoard(), parameters)
    assert take_node(joint, str(path)) == 1
    assert not path.exists()
    assert take_node(joint, str(path)) == 0
    assert Joint(SimBoard(), parameters).parameters.node == 7


@pytest.mark.parametrize("text", ["0", "13", "seven", ""])
def test_an_id_that_is_none_is_left(tmp_path, text):
    path = tmp_path / "node.txt"
    path.write_text(text)
    joint = Joint(SimBoard(), str(tmp_path / "joint.bin"))
    assert take_node(joint, str(path)) == 0
    assert path.exists()
    assert joint.parameters.node == 0


def test_broken_parameters_are_not_overwritten_by_an_id(tmp_path):
    path, parameters = tmp_path / "node.txt", tmp_path / "joint.bin"
    path.write_text("7")
    parameters.write_bytes(b"torn")
    assert take_node(Joint(SimBoard(), str(parameters)), str(path)) == 0
    assert path.exists()
    assert parameters.read_bytes() == b"torn"


def test_the_self_test_passes_here_and_finds_a_wrong_answer(monkeypatch):
    assert self_test() == ""
    monkeypatch.setattr("firmware.selftest.sin_q15", lambda angle: 1)
    assert self_test() == "sin_q15(0x2000) is 1, not 23171"


def test_a_gait_board_gets_its_robots_integers():
    for name in ("caramelo", "parallel"):
        modules = generated_modules("gait", name)
        robot, found = load_robot(name), {}
        exec(modules[ROBOT_PARAMS], found)
        assert list(found["PARAMS"]) == core_params(robot)
        assert list(found["ATTITUDE"]) == attitude_block(robot)
        assert "PROTOCOL = None" in modules[APPLICATION]
    joint = generated_modules("joint", "caramelo")
    assert list(joint) == [APPLICATION]
    assert "PROTOCOL_HASH as PROTOCOL" in joint[APPLICATION]
    assert generated_modules(None, "caramelo") == {}
