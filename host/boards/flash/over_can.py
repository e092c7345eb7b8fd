"""Flashes the joints of a robot over their bus: one image goes to all at once, and each asks for the blocks it missed.

Nothing is written before every joint has accepted the image's header, and none is switched over before all have the
whole image: until then a failure leaves all joints with their old firmware. Then each joint starts the new one on trial
and is confirmed once it reports that it runs; a joint that does not start it goes back by itself.
"""

import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from firmware.can_update import FLAG_ARMED, FLAG_CONFIRMED, HEADER_BLOCKS, LOOK_FLAGS, VERSION
from firmware.flash_map import HEADER, SLOTS
from shared.joint.faults import FAULT_DUPLICATE_ID
from shared.wire import names as w
from shared.wire.codec import Heartbeat, UpdateAnswer
from shared.wire.names import PROTOCOL_HASH

from ...bus.can.service import joint_name
from ...bus.can.update_bus import ANSWER_S, BLOCK_BYTES, Ask, UpdateBus
from ...util.errors import NOT_ACHIEVED, UserError
from ..build.image_file import ImageFile

FIRST_WORD, LAST_WORD = 5, 28  # of a header: protocol, sha256, board, build, version, role
ERASE_ANSWER_S = 5.0  # a sector takes 2 s at most (DS8626, 128 KiB in words), and the joint reports before each
VERIFY_S = 0.4  # a sha256 of 448 KiB takes 0.2 s (assumed); the host asks again after this time
RESTART_S = 15.0  # a start takes a second, three failed ones and the old firmware five (assumed)
KEEP_S = 1.0  # between questions for the joints' progress; after ten seconds without one they leave the update
SLOW_SHARE = 0.05  # of the blocks: if a joint loses more, its flash or the bus is slow: send more slowly (chosen)
MISSING_MOST = 20_000  # blocks to ask one joint for at once: four seconds, while the others wait (chosen)
BEYOND = 0x1FFFF  # no block has so high a number
ROUNDS = 40  # of repeating missed blocks
LISTEN_S = 0.5  # two heartbeats

WHY = {
    w.UPDATE_WHY_ARMED: "is armed: let the robot sit down, disarm it, then flash again",
    w.UPDATE_WHY_NO_FLASH: "is a simulated joint, whose flash can't be written",
    w.UPDATE_WHY_OTHER_UPDATE: "is being flashed by another program: wait ten seconds, then flash again",
    w.UPDATE_WHY_NOT_A_HEADER: "got a damaged header: flash again",
    w.UPDATE_WHY_OTHER_BOARD: "is a board of another type than the image's",
    w.UPDATE_WHY_RUNNING_SLOT: "runs from the slot for which the image is: flash again",
    w.UPDATE_WHY_OTHER_IMAGE: "got another image than announced: check that no other computer is flashing",
    w.UPDATE_WHY_NO_MEMORY: "has too little memory for the update: reset it, then flash again",
    w.UPDATE_WHY_FLASH: "can't write its flash, which may be worn out",
    w.UPDATE_WHY_DIFFERENT: "reads the image back differently: flash again; if it stays so, its flash is worn out",
    w.UPDATE_WHY_WRONG_STATE: "has left the update, as after a reset: check its supply, then flash again",
}


@dataclass
class JointOutcome:
    """The result for one joint; ``slot``, ``build`` and ``version`` are those of the firmware that runs at the end."""

    node: int
    joint: str
    board: str
    slot: str
    build: str
    version: str
    protocol: int
    changed: bool = False
    confirmed: bool = False
    note: str = ""
    failure: str = ""

    @property
    def target(self) -> int:
        """The slot that does not run."""
        return 1 - SLOTS.index(self.slot)


Tell = Callable[[str, float], None]  # the present work, and its progress, 0 .. 1


def check_image(image: ImageFile) -> None:
    """UserError if an image is not for a joint, or speaks another protocol than this computer."""
    about = image.about
    if about.role != "joint":
        raise UserError(f"--can: only joints are on the bus; this image is for the role {about.role}")
    if about.protocol != PROTOCOL_HASH:
        raise UserError(
            f"the image speaks protocol {about.protocol or 0:#06x}, this computer {PROTOCOL_HASH:#06x}: "
            f"build the image again (caramelo firmware image)"
        )


class CanFlash:
    """One update of ``nodes`` to ``image`` over ``bus``."""

    def __init__(
        self, bus: UpdateBus, image: ImageFile, nodes: list[int], tell: Tell = lambda what, done: None
    ) -> None:
        self.bus, self.image, self.nodes, self._tell = bus, image, nodes, tell
        self._build = int(image.about.build[:6], 16)
        self.joints: dict[int, JointOutcome] = {}
        self._entered: list[int] = []

    def survey(self) -> dict[int, JointOutcome]:
        """Check what the joints are, and refuse those that must not be flashed. This writes nothing."""
        self.bus.wait(LISTEN_S)
        for node, heard in self.bus.joints.items():
            self._check_rest(node, heard.heartbeat)
        flags = self._all(self.nodes, Ask(w.UPDATE_LOOK, LOOK_FLAGS))
        for node, answer in flags.items():
            if answer.reason:
                raise self._refusal(node, answer.reason)
            if answer.high != VERSION:
                raise UserError(f"{joint_name(node)} needs update version {answer.high}, which this host does not know")
        words = dict.fromkeys(self.nodes, b"")
        for index in range(FIRST_WORD, LAST_WORD):
            for node, answer in self._all(self.nodes, Ask(w.UPDATE_LOOK, index)).items():
                words[node] += struct.pack("<HH", answer.low, answer.high)
        for node in self.nodes:
            self.joints[node] = _described(node, words[node], flags[node])
            self._check(self.joints[node])
        armed = [node for node in self.nodes if flags[node].low & FLAG_ARMED]
        if armed:
            raise self._refusal(armed[0], w.UPDATE_WHY_ARMED)
        return self.joints

    def _check_rest(self, node: int, beat: Heartbeat | None) -> None:
        """UserError if any joint of the robot is armed, even one not to be flashed, or if two boards share a node."""
        if beat is not None and w.STATE_READY <= beat.state <= w.STATE_FAULT_REACTION:
            raise self._refusal(node, w.UPDATE_WHY_ARMED)
        if beat is not None and beat.fault == FAULT_DUPLICATE_ID:
            text = f"{joint_name(node)}: two boards have this node; change one with caramelo joints set-id"
            raise UserError(text, NOT_ACHIEVED)

    def _check(self, joint: JointOutcome) -> None:
        about = self.image.about
        if joint.board != about.board:
            raise UserError(f"{joint.joint} is a {joint.board}, but the image is for a {about.board}")
        if joint.protocol != about.protocol:
            joint.note = f"spoke protocol {joint.protocol:#06x}, unlike this computer's {about.protocol:#06x}"

    def waiting(self) -> list[int]:
        """Return the joints that do not run the image yet."""
        return [node for node, joint in self.joints.items() if joint.build != self.image.about.build]

    def run(self) -> list[JointOutcome]:
        """Bring all joints to the image; UserError if none has changed. Failures of single joints are reported."""
        todo = self.waiting()
        if todo:
            try:
                self._write(todo)
            except BaseException:
                self._cancel()
                raise
            self._switch(todo)
        self._confirm([node for node in self.nodes if not self.joints[node].failure])
        return list(self.joints.values())

    def _write(self, todo: list[int]) -> None:
        """Get the whole image into the other slot of all these joints."""
        about = self.image.about
        bound = (about.protocol or 0) | int(about.build[:4], 16) << 16
        self._entered = list(todo)
        self._expect(self._all(todo, Ask(w.UPDATE_BEGIN, value=bound)))
        self._send_headers(todo)
        self._erase(todo)
        for slot in sorted({self.joints[node].target for node in todo}):
            self._send_image(slot, todo)
        self._tell("verifying", 0.0)
        missing = [node for node in todo if self._state(node) != w.UPDATE_IS_WHOLE]
        self._expect(self._all(missing, Ask(w.UPDATE_VERIFY), VERIFY_S), w.UPDATE_IS_WHOLE)
        self._tell("verifying", 1.0)

    def _send_headers(self, todo: list[int]) -> None:
        """Send each slot's header until all its joints have received and accepted it."""
        for _ in range(ROUNDS):
            answers = self._expect(self._all(todo, Ask(w.UPDATE_LOOK, LOOK_FLAGS)))
            waiting = [node for node, answer in answers.items() if answer.state == w.UPDATE_IS_WAITING]
            if not waiting:
                return
            for slot in sorted({self.joints[node].target for node in waiting}):
                head = self.image.slots[slot][:HEADER]
                for number in range(HEADER_BLOCKS):
                    self.bus.block(slot, number, head[BLOCK_BYTES * number : BLOCK_BYTES * (number + 1)], header=True)
        raise UserError(f"{joint_name(waiting[0])} does not get the image's header: the bus loses frames", NOT_ACHIEVED)

    def _erase(self, todo: list[int]) -> None:
        """Let all joints erase, and wait for each: it reports before every sector, but hears nothing meanwhile."""
        if all(self._state(node) == w.UPDATE_IS_WHOLE for node in todo):
            return
        for node in todo:
            self.bus.request(node, Ask(w.UPDATE_ERASE))
        left, asked_s, began_s = list(todo), self.bus.port.now(), self.bus.port.now()
        while left:
            self.bus.wait(KEEP_S / 20)
            now_s = self.bus.port.now()
            left = [node for node in todo if self._state(node) in (w.UPDATE_IS_CHECKED, w.UPDATE_IS_ERASING)]
            self._tell("erasing", 1 - len(left) / len(todo))
            for node in left:
                if now_s - max(began_s, self.bus.joints[node].heard_s) > ERASE_ANSWER_S:
                    text = f"{joint_name(node)} has not answered for {ERASE_ANSWER_S:g} s while erasing its flash"
                    raise UserError(f"{text}: reset it, then flash again; nothing was switched over", NOT_ACHIEVED)
            if left and now_s - asked_s > KEEP_S / 4:
                asked_s = now_s
                self._nudge(todo)
        self._expect({node: self._answered(node) for node in todo})

    def _nudge(self, todo: list[int]) -> None:
        """Repeat requests that may have got lost: ask joints that have not begun to erase, and the others' progress."""
        for node in todo:
            begun = self._state(node) != w.UPDATE_IS_CHECKED
            self.bus.request(node, Ask(w.UPDATE_LOOK, LOOK_FLAGS) if begun else Ask(w.UPDATE_ERASE))

    def _send_image(self, slot: int, todo: list[int]) -> None:
        """Send one slot's image once to all its joints, then the blocks that any joint misses, until none does."""
        nodes = [n for n in todo if self.joints[n].target == slot and self._state(n) == w.UPDATE_IS_TAKING]
        if not nodes:
            return
        image = self.image.slots[slot][HEADER:]
        every = range(-(-len(image) // BLOCK_BYTES))
        self._send_blocks(slot, image, every, todo, f"writing slot {SLOTS[slot]}")
        for turn in range(ROUNDS):
            left = [node for node, count in self._left(nodes).items() if count]
            if not left:
                return
            for node in left:  # all joints get the blocks that one missed, so that the next one has less to ask for
                wanted = self._missing(node)
                self._send_blocks(slot, image, wanted, todo, f"repeating what was missed, round {turn + 1}")
        raise UserError(f"{joint_name(left[0])} misses blocks after {ROUNDS} rounds: check the cable", NOT_ACHIEVED)

    def _send_blocks(self, slot: int, image: bytes, numbers: Sequence[int], todo: list[int], what: str) -> None:
        """Send blocks; check now and then how many the joints miss, and slow down if the first pass loses many."""
        told_s, told, before = self.bus.port.now(), 0, dict.fromkeys(todo, 0)
        taking = [n for n in todo if self.joints[n].target == slot and self._state(n) == w.UPDATE_IS_TAKING]
        self._tell(what, 0.0)
        for count, number in enumerate(numbers):
            self.bus.block(slot, number, image[BLOCK_BYTES * number : BLOCK_BYTES * (number + 1)])
            if self.bus.port.now() - told_s > KEEP_S:
                self._tell(what, count / len(numbers))
                left = self._left(todo)
                lost = [left[node] - before[node] + count - told for node in taking if told]
                if isinstance(numbers, range) and max(lost, default=0) > SLOW_SHARE * (count - told):
                    self.bus.slow_down()
                told_s, told, before = self.bus.port.now(), count, left
        self._tell(what, 1.0)

    def _left(self, nodes: list[int]) -> dict[int, int]:
        """Return how many blocks joints miss, by a question for blocks beyond the end, which returns only the count."""
        answers = self._expect(self._all(nodes, Ask(w.UPDATE_MISSING, value=BEYOND)))
        return {node: answer.low | answer.high << 16 for node, answer in answers.items()}

    def _missing(self, node: int) -> list[int]:
        """Ask a joint for its missing blocks; return their numbers, rising, no more than the others can wait for."""
        joint = self.bus.joints[node]
        joint.missing.clear()
        start, before = 0, -1
        while before < len(joint.missing) < MISSING_MOST:
            before = len(joint.missing)
            self._expect(self._all([node], Ask(w.UPDATE_MISSING, value=start)))
            start = max(joint.missing, default=-1) + 1
        return sorted(joint.missing)

    def _switch(self, todo: list[int]) -> None:
        """Let all start the new firmware; a joint that can't or does not come back gets a failure."""
        self._tell("starting", 0.0)
        answers = self.bus.ask(dict.fromkeys(todo, Ask(w.UPDATE_SWITCH)))
        self._entered = []
        for node, answer in answers.items():
            if answer.reason:  # one without an answer may have restarted already, which is checked below
                self.joints[node].failure = self._refusal(node, answer.reason).args[0]
        left = [node for node in todo if not self.joints[node].failure]
        end_s = self.bus.port.now() + RESTART_S
        while left and self.bus.port.now() < end_s:
            self.bus.wait(KEEP_S / 10)
            left = [node for node in left if not self._is_back(node)]
            self._tell("starting", 1 - len(left) / len(todo))
        for node in left:
            self.joints[node].failure = (
                f"{joint_name(node)} has not come back within {RESTART_S:g} s: check its supply; it starts the new "
                f"firmware three times at most, then the old one"
            )

    def _is_back(self, node: int) -> bool:
        """Check whether a joint runs its application again, and note its firmware."""
        asked = self.bus.ask({node: Ask(w.UPDATE_LOOK, LOOK_FLAGS)}, tries=1)
        if node not in asked or asked[node].state != w.UPDATE_IS_RUNNING:
            return False
        words = b""
        for index in range(FIRST_WORD, LAST_WORD):
            answer = self.bus.ask({node: Ask(w.UPDATE_LOOK, index)}).get(node)
            if answer is None:
                return False
            words += struct.pack("<HH", answer.low, answer.high)
        joint, now = self.joints[node], _described(node, words, asked[node])
        joint.slot, joint.build, joint.version, joint.changed = now.slot, now.build, now.version, True
        joint.protocol = now.protocol
        if now.build != self.image.about.build:
            joint.changed = False
            joint.failure = f"{joint.joint}: the new firmware did not start; build {now.build} runs again"
        return True

    def _confirm(self, nodes: list[int]) -> None:
        """Confirm the new firmware of these joints."""
        answers = self.bus.ask(dict.fromkeys(nodes, Ask(w.UPDATE_CONFIRM, value=self._build)))
        for node in nodes:
            joint = self.joints[node]
            if node not in answers:
                joint.failure = f"{joint.joint} did not answer the confirmation: flash again"
            elif answers[node].reason:
                joint.failure = self._refusal(node, answers[node].reason).args[0]
            else:
                joint.confirmed = True

    def _cancel(self) -> None:
        """Let joints that have left their application start it again, the old one."""
        self.bus.ask({node: Ask(w.UPDATE_CANCEL) for node in self._entered}, tries=3)

    def _all(self, nodes: list[int], ask: Ask, wait_s: float = ANSWER_S) -> dict[int, UpdateAnswer]:
        """Ask joints; UserError names the first that does not answer."""
        answers = self.bus.ask(dict.fromkeys(nodes, ask), wait_s)
        for node in nodes:
            if node not in answers:
                raise self._silent(node)
        return answers

    def _state(self, node: int) -> int:
        return self._answered(node).state

    def _answered(self, node: int) -> UpdateAnswer:
        return self.bus.joints[node].last

    def _expect(self, answers: Mapping[int, UpdateAnswer], state: int | None = None) -> Mapping[int, UpdateAnswer]:
        """Return the answers; UserError for the first refusal, or for a joint in a wrong state."""
        for node, answer in answers.items():
            if answer.reason:
                raise self._refusal(node, answer.reason)
            if answer.state == w.UPDATE_IS_RUNNING or (state is not None and answer.state != state):
                raise self._refusal(node, w.UPDATE_WHY_WRONG_STATE)
        return answers

    def _refusal(self, node: int, reason: int) -> UserError:
        return UserError(f"{joint_name(node)} {WHY.get(reason, f'refuses, reason {reason}')}", NOT_ACHIEVED)

    def _silent(self, node: int) -> UserError:
        """Return what is wrong with a joint that does not answer."""
        beat = self.bus.joints[node].heartbeat
        if beat is None:
            text = f"{joint_name(node)} is not there: check its power, the CAN cable and both terminators"
        elif beat.mode == w.MODE_UPDATING:
            text = f"{joint_name(node)} has fallen silent: check its supply, then flash again"
        else:
            text = f"{joint_name(node)} runs firmware that can't be updated over the bus: flash it once over USB"
        return UserError(text, NOT_ACHIEVED)


def _described(node: int, words: bytes, flags: UpdateAnswer) -> JointOutcome:
    """Return a joint's firmware: ``words`` are those of its header from FIRST_WORD on."""
    protocol, _, *texts = struct.unpack("<I32s16s16s16s8s", words)
    board, build, version, _ = [text.split(b"\0")[0].decode("ascii", "replace") for text in texts]
    confirmed = bool(flags.low & FLAG_CONFIRMED)
    return JointOutcome(
        node, joint_name(node), board, SLOTS[flags.low & 1], build, version, protocol, confirmed=confirmed
    )
