"""The emulator's packets against the e-manual's examples, and against dynamixel-sdk both ways."""

import pytest
from dynamixel_sdk import COMM_SUCCESS, PacketHandler
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from host.bus.dynamixel.packets import packet_handler
from host.bus.dynamixel.roll_call import ANSWER, IDS, answers_in, call_roll
from host.sim.servos.packets import READ, WRITE, Framing1, Framing2, Instruction, framing

# E-manual, protocol 2.0: ping of id 1, its answer; read of 4 bytes at 132 of id 1; write of 512 to 116.
PING = bytes.fromhex("FFFFFD0001030001194E")
PONG = bytes.fromhex("FFFFFD000107005500060426655D")
READ_POSITION = bytes.fromhex("FFFFFD0001070002840004001D15")
WRITE_GOAL = bytes.fromhex("FFFFFD0001090003740000020000CA89")
# E-manual, protocol 1.0: ping of id 1, its answer.
PING_1 = bytes.fromhex("FFFF010201FB")
PONG_1 = bytes.fromhex("FFFF010200FC")


def take(frames, data):
    return frames.take(bytearray(data))


def test_the_manuals_examples():
    assert take(Framing2(), PING) == Instruction(1, 1, b"")
    assert take(Framing2(), READ_POSITION) == Instruction(1, READ, bytes([132, 0, 4, 0]))
    assert take(Framing2(), WRITE_GOAL) == Instruction(1, WRITE, bytes([116, 0, 0, 2, 0, 0]))
    assert Framing2().status(1, 0, bytes([0x06, 0x04, 0x26])) == PONG
    assert take(Framing1(), PING_1) == Instruction(1, 1, b"")
    assert Framing1().status(1, 0, b"") == PONG_1


def test_a_packet_comes_in_pieces_and_after_rubbish():
    frames, buffer = Framing2(), bytearray(b"\x00\xff\xff")
    assert frames.take(buffer) is None
    buffer += PING[:6]
    assert frames.take(buffer) is None
    buffer += PING[6:] + PING[:3]
    assert frames.take(buffer) == Instruction(1, 1, b"")
    assert bytes(buffer) == PING[:3]


class Wire:
    """What the SDK needs of a port; keeps what is sent, hands out what is to be received."""

    is_using = False

    def __init__(self, answer=b""):
        self.sent, self.answer = b"", answer

    def clearPort(self):
        pass

    def writePort(self, packet):
        self.sent = bytes(packet)
        return len(packet)

    def readPort(self, length):
        data, self.answer = self.answer[:length], self.answer[length:]
        return data

    def isPacketTimeout(self):
        return not self.answer


@pytest.mark.parametrize("protocol", [1.0, 2.0])
@given(data=st.lists(st.sampled_from([0, 1, 0x55, 0xFD, 0xFE, 0xFF]), min_size=1, max_size=24))
@settings(max_examples=100)
def test_what_the_sdk_sends_arrives(protocol, data):
    """Except a header among the data: the SDK (4.1.0) forgets to stuff it. Nothing that is sent here holds one."""
    assume(bytes([0xFF, 0xFF, 0xFD]) not in bytes(data))
    wire = Wire()
    PacketHandler(protocol).writeTxOnly(wire, 3, 100, len(data), list(data))
    address = bytes([100]) if protocol == 1.0 else bytes([100, 0])
    assert take(framing(protocol), wire.sent) == Instruction(3, WRITE, address + bytes(data))


@pytest.mark.parametrize("protocol", [1.0, 2.0])
@given(data=st.lists(st.sampled_from([0, 1, 0x55, 0xFD, 0xFE, 0xFF]), min_size=1, max_size=24))
@example(data=[0xFF, 0xFF, 0xFD, 0xFF, 0xFD, 0xFD])
@example(data=[0xFF, 0xFF, 0xFD, 0xFF, 0xFF, 0xFD, 0xFD])
@settings(max_examples=100)
def test_what_a_servo_answers_arrives(protocol, data):
    """Also where the data look like a header, which protocol 2.0 stuffs; of two, the SDK (4.1.0) takes out too much."""
    wire = Wire(framing(protocol).status(3, 0, bytes(data)))
    handler = packet_handler(protocol)
    packet, result = handler.rxPacket(wire) if protocol == 1.0 else handler.rxPacket(wire, False)
    assert result == COMM_SUCCESS
    start = 5 if protocol == 1.0 else 9
    assert bytes(packet[start : start + len(data)]) == bytes(data)


class Asked(Wire):
    """The same for a question and its answer."""

    def setPacketTimeout(self, length):
        pass


@pytest.mark.parametrize("protocol", [1.0, 2.0])
@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_an_answer_to_another_question_is_none(protocol, count):
    """The SDK (4.1.0) took a write's late answer for a ping's, and its check sum for the model."""
    late = framing(protocol).status(3, 0, bytes(count))
    for length in (1, 2, 4):
        _, result, _ = packet_handler(protocol).readTxRx(Asked(late), 3, 36, length)
        assert (result == COMM_SUCCESS) is (count == length)
    result, _ = packet_handler(protocol).write1ByteTxRx(Asked(late), 3, 36, 1)
    assert (result == COMM_SUCCESS) is (count == 0)
    if protocol == 2.0:
        _, result, _ = packet_handler(protocol).ping(Asked(late), 3)
        assert (result == COMM_SUCCESS) is (count == 3)


@given(packet=st.sampled_from([PING, READ_POSITION, WRITE_GOAL]), at=st.integers(0, 13), flip=st.integers(1, 255))
def test_no_damaged_packet_passes(packet, at, flip):
    damaged = bytearray(packet)
    damaged[at % len(packet)] ^= flip
    found = take(Framing2(), damaged)
    assert found is None or not found.intact


@st.composite
def roll_calls(draw):
    """Answers to a broadcast ping, whole, cut or damaged, and noise between them that may look like a header."""
    noise = st.lists(st.sampled_from([0, 0x55, 0xFD, 0xFF]), max_size=6).map(bytes)
    pieces = []
    for servo in draw(st.lists(st.integers(0, 252), max_size=6)):
        answer = Framing2().status(servo, draw(st.sampled_from([0, 0x80])), draw(st.binary(min_size=3, max_size=3)))
        damaged = bytearray(answer)
        damaged[draw(st.integers(0, len(answer) - 1))] ^= draw(st.integers(1, 255))
        cut = answer[: draw(st.integers(0, len(answer)))] + answer[draw(st.integers(0, len(answer))) :]
        pieces += [draw(st.sampled_from([answer, answer, bytes(damaged), cut])), draw(noise)]
    return draw(noise) + b"".join(pieces)


class Paced(Wire):
    """The same with the time limits of a roll call, which end when all has been taken."""

    def getBaudRate(self):
        return 57600

    def setPacketTimeoutMillis(self, msec):
        pass

    def allow(self, length, more_ms, most):
        assert (length, more_ms, most) == (ANSWER, 3.0 * IDS, IDS * ANSWER)

    def allow_more(self, length):
        pass


@given(data=roll_calls())
@settings(max_examples=300)
def test_a_roll_call_asks_as_the_sdk_does_and_takes_the_same_answers(data):
    handler, ours, theirs = packet_handler(2.0), Paced(data), Paced(data)
    wanted, _ = handler.broadcastPing(theirs)
    assert call_roll(ours, handler) == {servo: model for servo, (model, _) in wanted.items()}
    assert ours.sent == theirs.sent
    assert not ours.is_using


def test_a_lost_byte_hides_one_answer_only():
    answers = [Framing2().status(servo, 0, bytes([30, 0, 45])) for servo in range(1, 13)]
    for at in range(ANSWER):
        line = b"".join(answers[:3]) + answers[3][:at] + answers[3][at + 1 :] + b"".join(answers[4:])
        assert sorted(answers_in(line, packet_handler(2.0).updateCRC)) == [1, 2, 3, *range(5, 13)]
