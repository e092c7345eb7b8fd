"""The broadcast ping of protocol 2.0, which all servos answer one after the other. It ends when nobody's turn is left.

Every id has a turn, in order (Robotis e-manual, protocol 2.0, ping). That of a silent id lasts 3 ms; an answer ends its
own, so each delays the later ones by its time on the wire (Robotis's own devices: OpenCR, dxl_process_packet). The SDK
waits as if all 252 answered: 0.8 s at 4 000 000 baud, but 1.4 s at 57600 and 4.4 s at 9600.
"""

from collections.abc import Callable
from typing import Any

from dynamixel_sdk import BROADCAST_ID, COMM_SUCCESS, INST_PING

IDS = 253  # 0 .. 252; 253 is reserved, 254 addresses all (e-manual, protocol 2.0, packet id)
TURN_MS = 3.0
HEADER = b"\xff\xff\xfd"
PING = [*HEADER, 0, BROADCAST_ID, 3, 0, INST_PING, 0, 0]  # the SDK fills in the check sum
ANSWER = 14  # bytes: model and firmware after the error; the check sum at the end
ID, MODEL = 4, 9  # their places in it


def call_roll(port: Any, packets: Any) -> dict[int, int]:
    """Return the model numbers of all servos that answer, by id."""
    sent = packets.txPacket(port, list(PING))
    port.is_using = False
    return answers_in(_listen(port), packets.updateCRC) if sent == COMM_SUCCESS else {}


def _listen(port: Any) -> bytes:
    """Return what comes until every id has had its turn; not more than all could say, if the line is never silent."""
    came, most = b"", IDS * ANSWER
    port.allow(ANSWER, IDS * TURN_MS, most)
    while len(came) < most:
        more = port.readPort(most - len(came))
        came += more
        port.allow_more(len(more))
        if port.isPacketTimeout():
            break
    return came


def answers_in(data: bytes, check_sum: Callable[[int, bytes, int], int]) -> dict[int, int]:
    """Return the models in the whole answers among these bytes, by id, whatever else is between them."""
    found = dict[int, int]()
    at = data.find(HEADER)
    while at >= 0 and len(data) - at >= ANSWER:
        answer = data[at : at + ANSWER]
        intact = check_sum(0, answer, ANSWER - 2) == int.from_bytes(answer[-2:], "little")
        if intact:
            found[answer[ID]] = int.from_bytes(answer[MODEL : MODEL + 2], "little")
        at = data.find(HEADER, at + (ANSWER if intact else len(HEADER)))
    return found
