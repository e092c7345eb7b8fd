"""Requests to joints: sent with a sequence number, repeated while no answer comes; refusals become sentences.

A repeated request has the same number, so a joint that has done it answers again but does not do it twice.
"""

from collections.abc import Callable

from shared.wire import names as w
from shared.wire.parameters import PARAMETER_CHALLENGE

from ...util.errors import NOT_ACHIEVED, UserError
from ..base import JOINT_LABELS
from .link import JointLink, Response

TRIES = 4
ANSWER_S = 0.02  # a joint answers within a millisecond; adapters and a full bus take longer
POLL_S = 0.001
DISCOVER_S = 0.1  # boards answer within 63 ms

RESULTS = {
    w.RESULT_UNKNOWN_COMMAND: "it does not know the command: flash the same version as the host's",
    w.RESULT_UNKNOWN_PARAMETER: "it does not know the parameter: flash the same version as the host's",
    w.RESULT_OUT_OF_RANGE: "the value is out of range",
    w.RESULT_READ_ONLY: "the parameter can only be read",
    w.RESULT_NEEDS_DISARMED: "it is armed: disarm it first",
    w.RESULT_WRONG_STATE: "not possible in its present state: disarm it, or wait until it is ready",
    w.RESULT_FAULT_PRESENT: "a fault is latched or its cause is still there: see joints status, then joints clear",
    w.RESULT_WRONG_HASH: "it speaks another protocol: flash the same version as the host's",
    w.RESULT_NO_SESSION: "the request contains no session",
    w.RESULT_NO_SETPOINT: "it has received no set-point lately: the bus loses frames",
    w.RESULT_FAR_FROM_SETPOINT: "the set-point is far from where it is",
    w.RESULT_NOT_HOMED: "it does not know its angle: put the robot into its sitting pose, and home it",
    w.RESULT_NOT_COMMISSIONED: "it is not commissioned: run caramelo joints commission",
    w.RESULT_STORAGE_FAILED: "its file system refused to save",
    w.RESULT_DUPLICATE_ID: "another board has the same node: run caramelo joints scan, then set-id",
    w.RESULT_WRONG_KEY: "the board's number does not match: caramelo joints scan shows it",
    w.RESULT_BUSY: "it is busy: try again",
    w.RESULT_WRONG_CHALLENGE: "the request lacks its challenge: the joint was armed or let go meanwhile; try again",
}


def joint_name(node: int) -> str:
    """Return a node's name."""
    return f"{JOINT_LABELS[node - 1]} (node {node})" if node else "board without a node"


def _done(name: str, answer: Response | None, remedy: str) -> Response:
    """Return the answer of a joint or board that did what it was asked; else UserError says why not."""
    if answer is None:
        raise UserError(f"{name} does not answer: {remedy}", NOT_ACHIEVED)
    if answer.result != w.RESULT_OK:
        refusal = RESULTS.get(answer.result, f"result {answer.result}")
        raise UserError(f"{name} refuses: {refusal}", NOT_ACHIEVED)
    return answer


class Requests:
    """Asks joints; while it waits, ``idle`` goes on with all other work until the time that it is given."""

    def __init__(self, link: JointLink, idle: Callable[[float], None]) -> None:
        self.link, self._idle = link, idle

    def _exchange(self, node: int, command: int, index: int, value: int, anybody: bool = False) -> Response | None:
        """Return a node's answer, or anybody's, or None if none of four tries got one."""
        link, port = self.link, self.link.port
        for attempt in range(TRIES):
            link.responses.clear()
            sequence = link.request(node, command, index, value, again=attempt > 0)
            end_s = port.now() + ANSWER_S
            while port.now() < end_s:
                self._idle(port.now() + POLL_S)
                for answer in link.responses:
                    known = anybody or answer.node == node
                    if known and (answer.command, answer.sequence) == (command, sequence):
                        return answer
        return None

    def demand(self, node: int, command: int, index: int = 0, value: int = 0) -> Response:
        """Return a node's answer if it did what it was asked; else UserError says why not."""
        answer = self._exchange(node, command, index, value)
        return _done(joint_name(node), answer, "check its power and the CAN cable")

    def challenged(
        self, node: int, command: int = w.COMMAND_ARM, index: int = 0, low: int = w.PROTOCOL_HASH
    ) -> Response:
        """Request arming, commissioning or homing of a joint, with its challenge, and ``low`` in the lower bits."""
        challenge = self.demand(node, w.COMMAND_READ_PARAMETER, PARAMETER_CHALLENGE).value
        return self.demand(node, command, index, challenge << 16 | low & 0xFFFF)

    def to_board(self, command: int, number: int, index: int) -> Response:
        """Ask the board with a number, whatever its node: for set-id."""
        answer = self._exchange(0, command, index, number, anybody=True)
        return _done(f"board {number:#x}", answer, "caramelo joints scan lists the boards")

    def discover(self) -> dict[int, set[int]]:
        """Return the boards' numbers by node; two numbers under one node are two boards with one id.

        Asks twice, and up to TRIES more times while a joint that is heard has not answered: an answer may get lost.
        """
        found: dict[int, set[int]] = {}
        for turn in range(2 + TRIES):
            if turn >= 2 and all(node in found for node in self.link.alive()):
                break
            self._discover_once(found)
        return found

    def _discover_once(self, found: dict[int, set[int]]) -> None:
        link, port = self.link, self.link.port
        link.responses.clear()
        link.request(0, w.COMMAND_DISCOVER)
        end_s = port.now() + DISCOVER_S
        while port.now() < end_s:
            self._idle(port.now() + POLL_S)
        for answer in link.responses:
            if answer.command == w.COMMAND_DISCOVER:
                found.setdefault(answer.node, set()).add(answer.value)
