"""Talking to servos by register, with the SDK's packets: single reads and writes, broadcasts, group reads and writes.

Every bad answer is counted and thrown away. The SDK's group reads stop at the first missing answer and drop the
status bits, so this module collects the answers itself: each one counts separately, in whatever order they arrive.
"""

import termios
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

import serial
from dynamixel_sdk import BROADCAST_ID, COMM_RX_TIMEOUT, COMM_SUCCESS
from dynamixel_sdk.group_sync_write import GroupSyncWrite

from ...robot.actuators import ServoBus
from ...robot.model import Robot
from ...util.errors import NOT_ACHIEVED, UserError
from ..base import Counters
from . import table as t
from .packets import packet_handler
from .port import ServoPort
from .roll_call import IDS, call_roll
from .table import Register

# Outside the control loop a busy machine may be late; a scan asks 253 ids, most of them in vain.
PATIENCE_MS, PING_PATIENCE_MS = 30.0, 8.0
RETRIES = 5  # at 4 % lost or damaged packets one exchange in ten million fails; each waits twice as long as the last
Answered = TypeVar("Answered")


class ServoError(UserError):
    """A servo that does not answer, or refuses."""

    def __init__(self, sentence: str) -> None:
        super().__init__(sentence, NOT_ACHIEVED)


class Silent(ServoError):
    """A servo that does not answer."""

    def __init__(self, servo: int) -> None:
        super().__init__(f"servo id {servo} does not answer: check its cable and power")


class Answer(NamedTuple):
    """One servo's good answer: its bytes from an address on, and whether it raises its alert flag."""

    address: int
    data: bytes
    alert: bool

    def value(self, register: Register) -> int:
        """Return a register among the bytes."""
        return t.unpack(register, self.data, self.address)


class Link:
    """The servos on one open port."""

    def __init__(self, port: Any, protocol: float = 2.0, counters: Counters | None = None) -> None:
        self.port, self.protocol = port, protocol
        self.packets = packet_handler(protocol)
        self.counters = Counters() if counters is None else counters
        self._given_up = 0  # answers that did not come in time but may still come

    def ping(self, servo: int, tries: int = RETRIES, patience_ms: float = PING_PATIENCE_MS) -> int | None:
        """Return the model number of a servo, or None if it does not answer."""

        def ask() -> int | None:
            model, result, _ = self._guard(self.packets.ping, self.port, servo)
            return int(model) if self._count(result) else None

        return self._persist(ask, tries, patience_ms)

    def ping_all(self) -> dict[int, int]:
        """Return the model numbers of all servos that answer, by id; asks only once.

        A damaged answer is missing, and two servos with the same id may look like one. Protocol 1.0 has no broadcast
        ping: there each id is asked separately.
        """
        if self.protocol == 1.0:
            models = {servo: self.ping(servo, 1, PING_PATIENCE_MS) for servo in range(IDS)}
            return {servo: model for servo, model in models.items() if model is not None}
        with self.patient(PATIENCE_MS):
            found: dict[int, int] = self._guard(call_roll, self.port, self.packets)
        return found

    def read(self, servo: int, register: Register) -> int:
        """Return a register; Silent after a few tries."""
        args = (self.port, servo, register.address, register.size)

        def ask() -> int | None:
            data, result, _ = self._guard(self.packets.readTxRx, *args)
            return t.unpack(register, data, register.address) if self._count(result) else None

        value = self._persist(ask)
        if value is None:
            raise Silent(servo)
        return value

    def write(self, servo: int, register: Register, value: int) -> None:
        """Write a register; ServoError if the servo does not confirm it."""
        args, why = (self.port, servo, register.address, register.size, t.pack(register, value)), ""

        def ask() -> bool | None:
            nonlocal why
            result, error = self._guard(self.packets.writeTxRx, *args)
            why = self.refusal(error)
            return (self._count(result) and not why) or None

        if self._persist(ask):
            return
        self.counters.refused += bool(why)
        raise ServoError(f"servo id {servo} refuses: {why}") if why else Silent(servo)

    def _persist(
        self, ask: Callable[[], Answered | None], tries: int = RETRIES, first_ms: float = PATIENCE_MS
    ) -> Answered | None:
        """Ask until there is an answer, with twice the patience each time; None after so many tries.

        Packets have no numbers: once a try has been given up, what comes may be the answer to that one, and the present
        one's would be taken for that to the next question.
        """
        for number in range(tries):
            with self.patient(first_ms * 2**number):
                answer = ask()
                if answer is not None and number > 0:
                    self._drain()
            if answer is not None:
                return answer
        return None

    def set_up(self, servo: int, name: str, settings: Iterable[tuple[Register, int]]) -> None:
        """Let go of a servo and write only settings that differ, as writing wears them. ServoError if it tripped."""
        if tripped := t.hardware_error_text(self.read(servo, t.HARDWARE_ERROR)):
            raise ServoError(f"{name} has tripped: {tripped}; let it cool, then: caramelo servos reboot {servo}")
        self.write(servo, t.TORQUE_ENABLE, 0)
        self.write(servo, t.WATCHDOG, 0)
        for register, value in settings:
            if self.read(servo, register) != value:
                self.write(servo, register, value)

    def refusal(self, error: int) -> str:
        """Return why a servo refused an instruction, "" if it did not."""
        if self.protocol == 1.0:
            # Bits 3, 4, 6: range, checksum, instruction. The others are the servo's own condition.
            return "value out of range or damaged packet" if error & 0x58 else ""
        number = error & ~t.ALERT
        return t.STATUS_ERRORS.get(number, f"error {number}") if number else ""

    def reboot(self, servo: int) -> None:
        """Restart a servo, which clears a trip."""
        if self.protocol == 1.0:
            raise UserError("protocol 1.0 can't restart a servo: switch its power off and on")

        def ask() -> bool | None:
            result, _ = self._guard(self.packets.reboot, self.port, servo)
            return self._count(result) or None

        if self._persist(ask) is None:
            raise Silent(servo)

    @contextmanager
    def patient(self, patience_ms: float) -> Iterator[None]:
        """Wait longer for answers than a control cycle can."""
        former, self.port.patience_ms = self.port.patience_ms, patience_ms
        try:
            yield
        finally:
            self.port.patience_ms = former

    def _drain(self) -> None:
        """Let late answers pass."""
        time.sleep(self.port.patience_ms / 1000 if self.port.is_real else 0.0)
        self._guard(self.port.clearPort)

    def write_all(self, register: Register, values: Mapping[int, int]) -> None:
        """Write a register of many servos in one packet; they do not confirm it."""
        group = GroupSyncWrite(self.port, self.packets, register.address, register.size)
        for servo, value in values.items():
            group.addParam(servo, t.pack(register, value))
        self._count_sent(self._guard(group.txPacket))

    def broadcast(self, register: Register, value: int) -> None:
        """Write a register of every servo; they do not confirm it."""
        data = t.pack(register, value)
        args = (self.port, BROADCAST_ID, register.address, register.size, data)
        self._count_sent(self._guard(self.packets.writeTxOnly, *args))

    def _count_sent(self, result: int) -> None:
        """No servo confirms the packet, but one that did not even go out is counted."""
        self.counters.lost += result != COMM_SUCCESS

    def read_all(self, servos: Iterable[int], block: tuple[int, int]) -> dict[int, Answer]:
        """Return the good answers to one request for (address, length) to many servos."""
        wanted = list(servos)
        address, length = block
        if self.protocol == 1.0:
            ask = [byte for servo in wanted for byte in (length, servo, address)]
            result = self._guard(self.packets.bulkReadTx, self.port, ask, len(ask))
            whole = 6 + length
        else:
            result = self._guard(self.packets.syncReadTx, self.port, address, length, wanted, len(wanted), False)
            whole = 11 + length
        self.counters.sent += len(wanted)
        if result != COMM_SUCCESS:
            self.port.is_using = False
            self.counters.lost += len(wanted)
            return {}
        self.port.setPacketTimeout(whole * len(wanted))
        return self._collect(wanted, block)

    def _collect(self, wanted: list[int], block: tuple[int, int]) -> dict[int, Answer]:
        """Take answers until all are there or the time is over; count and drop foreign ones."""
        counters, found = self.counters, dict[int, Answer]()
        address, length = block
        bad = 0
        while len(found) + bad < len(wanted):
            packet, result = self._receive()
            if result == COMM_RX_TIMEOUT:
                break
            if result != COMM_SUCCESS:
                counters.corrupted += 1
                bad += 1
                continue
            servo, error, data = self._parts(packet)
            if servo not in wanted or servo in found or len(data) != length or self.refusal(error):
                self._count_stray()
                continue
            found[servo] = Answer(address, data, self._alert(error))
        counters.answered += len(found)
        missing = len(wanted) - len(found) - bad
        counters.lost += missing
        self._given_up = self._given_up + missing if missing else 0
        return found

    def _count_stray(self) -> None:
        """Count an answer that was not asked for now: a late one if some had been given up, else a wrong one."""
        if self._given_up:
            self._given_up -= 1
            self.counters.late += 1
        else:
            self.counters.wrong += 1

    def _receive(self) -> tuple[list[int], int]:
        if self.protocol == 1.0:
            packet, result = self._guard(self.packets.rxPacket, self.port)
        else:
            packet, result = self._guard(self.packets.rxPacket, self.port, False)
        return packet, result

    def _parts(self, packet: list[int]) -> tuple[int, int, bytes]:
        """Return id, error field and parameters of a status packet."""
        if self.protocol == 1.0:
            return packet[2], packet[4], bytes(packet[5 : 3 + packet[3]])
        return packet[4], packet[8], bytes(packet[9 : 5 + (packet[5] | packet[6] << 8)])

    def _alert(self, error: int) -> bool:
        """True if the servo has a hardware error; protocol 1.0 flags voltage, heat and overload one by one."""
        return bool(error & (0x25 if self.protocol == 1.0 else t.ALERT))

    def _count(self, result: int) -> bool:
        self.counters.sent += 1
        if result == COMM_SUCCESS:
            self.counters.answered += 1
        elif result == COMM_RX_TIMEOUT:
            self.counters.lost += 1
        else:
            self.counters.corrupted += 1
        return bool(result == COMM_SUCCESS)

    def _guard(self, call: Any, *arguments: Any) -> Any:
        """Call the SDK; turn the loss of the adapter into one sentence."""
        try:
            return call(*arguments)
        except (serial.SerialException, OSError, termios.error) as error:
            self.port.is_using = False
            what = f"{self.port.port_name}: the adapter is gone ({error.args[-1]})"
            raise ServoError(f"{what}: plug it in and start the command again") from None


def serial_bus(robot: Robot) -> ServoBus:
    """Return the robot file's table of the servo bus; UserError if it has none."""
    if robot.bus.kind != "dynamixel":
        raise UserError(f"{robot.name} has no servo bus")
    return robot.bus


def protocol_of(robot: Robot) -> float:
    """Return the servos' protocol; 2.0 for emulated ones of a robot without a bus."""
    return robot.bus.protocol if robot.bus.kind == "dynamixel" else 2.0


@contextmanager
def open_link(robot: Robot, port: str | None = None, baud: int | None = None) -> Iterator[Link]:
    """Yield the link to a robot's servos with its port open; port and rate are the robot file's unless given."""
    own = serial_bus(robot)
    serial = ServoPort(port or own.port, baud or own.baud)
    serial.open()
    try:
        yield Link(serial, own.protocol)
    finally:
        serial.closePort()


class _Tape:
    """A port that stores what is sent."""

    is_using = False

    def __init__(self) -> None:
        self.data = b""

    def clearPort(self) -> None:
        """Receive nothing."""

    def writePort(self, packet: list[int]) -> int:
        self.data += bytes(packet)
        return len(packet)


def packet_of(protocol: float, register: Register, values: Mapping[int, int]) -> bytes:
    """Return the packet that ``write_all`` sends."""
    tape = _Tape()
    Link(tape, protocol).write_all(register, values)
    return tape.data
