"""What starts on a board: the gait board's stream and Ctrl-C, a joint's new id, the self-test, generated modules."""

import sys
import types

import pytest

from firmware import joint_store, link
from firmware.board_sim import SimBoard
from firmware.joint import Joint
from firmware.selftest import self_test
from firmware.settings import Memory
from host.boards.build.generated import APPLICATION, LEAVES, ROBOT_PARAMS, generated_modules
from host.protocol.gait_frames import frame
from host.robot.file import load_robot
from host.robot.scale import attitude_block, core_params
from shared.record import pack


class Usb:
    """A USB port with bytes waiting in it."""

    def __init__(self, data):
        self.data = list(data)
        self.interrupt = 3
        self.sent = b""

    def setinterrupt(self, byte):
        self.interrupt = byte

    def readinto(self, buffer):
        if not self.data:
            return None  # as the port's streams do
        count = min(len(buffer), len(self.data))
        buffer[:count], self.data[:count] = self.data[:count], []
        return count

    def write(self, buffer):
        self.sent += bytes(buffer)
        return len(buffer)


@pytest.fixture
def stream_class(monkeypatch):
    """Return UsbStream; the module it lies in reads a generated one."""
    robot = load_robot("caramelo")
    params = types.ModuleType("firmware.robot_params")
    params.PARAMS, params.ATTITUDE = core_params(robot), attitude_block(robot)
    monkeypatch.setitem(sys.modules, "firmware.robot_params", params)
    from firmware.start_gait import UsbStream

    return UsbStream


def test_a_frame_full_of_ctrl_c_does_not_stop_the_gait_board(stream_class):
    sent = frame(link.SENSED, [0x0303] * 4, 2)
    assert sent.count(3) >= 8
    port = Usb(sent)
    stream, data = stream_class(port), bytearray(64)
    assert port.interrupt == -1
    assert stream.readinto(data) == len(sent)
    assert data[: len(sent)] == sent
    assert stream.readinto(data) == 0
    stream.write(b"answer")
    assert port.sent == b"answer"


def read_all(stream, data):
    while stream.readinto(data):
        pass


@pytest.mark.parametrize("block", [1, 3, 4, 9, 10, 64])
@pytest.mark.parametrize("before", [b"", b"a", b"\x03\x03b", b"\x03" * 9 + b"c"])
@pytest.mark.parametrize("after", [b"", b"de"])
def test_ten_ctrl_c_in_a_row_stop_the_gait_board(stream_class, before, after, block):
    nine = Usb(before + b"\x03" * 9 + after)
    stream, data = stream_class(nine), bytearray(block)
    read_all(stream, data)
    assert (nine.data, nine.interrupt) == ([], -1)
    ten = Usb(before + b"\x03" * 10 + after)
    stream, data = stream_class(ten), bytearray(block)
    with pytest.raises(KeyboardInterrupt):
        read_all(stream, data)
    assert ten.interrupt == 3


@pytest.fixture
def take_node(monkeypatch):
    """Return the function; the module it lies in needs a chip's modules."""
    for name in ("machine", "pyb", "stm", "micropython"):
        module = types.ModuleType(name)
        module.__getattr__ = lambda attribute: 0
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "firmware.start_joint", raising=False)
    from firmware.start_joint import take_node

    return take_node


def test_a_joint_takes_over_its_id_once_and_keeps_it(take_node):
    settings = Memory()
    settings.put("node", bytes([7]))
    assert take_node(Joint(SimBoard(), settings), settings) == 1
    joint = Joint(SimBoard(), settings)
    assert joint.parameters.node == 7
    assert take_node(joint, settings) == 0


@pytest.mark.parametrize("data", [b"\x00", b"\x0d", b"seven", b"", None])
def test_an_id_that_is_none_is_left(take_node, data):
    settings = Memory()
    if data is not None:
        settings.put("node", data)
    joint = Joint(SimBoard(), settings)
    assert take_node(joint, settings) == 0
    assert joint.parameters.node == 0
    assert settings.get("node") == data


def test_broken_parameters_are_not_overwritten_by_an_id(take_node):
    settings = Memory()
    settings.put("node", bytes([7]))
    settings.put(joint_store.KEY, b"torn")
    assert take_node(Joint(SimBoard(), settings), settings) == 0
    assert (settings.get("node"), settings.get(joint_store.KEY)) == (bytes([7]), b"torn")


def test_the_self_test_passes_here_and_finds_a_wrong_answer(monkeypatch):
    assert self_test() == ""
    monkeypatch.setattr("firmware.selftest.sin_q15", lambda angle: 1)
    assert self_test() == "sin_q15(0x2000) is 1, not 23171"


def test_a_gait_board_gets_its_robots_integers():
    for name in ("caramelo", "parallel"):
        modules = generated_modules("gait", name, ["shared.num.fixed"])
        robot, found = load_robot(name), {}
        exec(modules[ROBOT_PARAMS], found)
        assert list(found["PARAMS"]) == pack(core_params(robot))
        assert list(found["ATTITUDE"]) == pack(attitude_block(robot))
    assert list(generated_modules("joint", "caramelo", [])) == [APPLICATION, LEAVES]
