"""A bus of emulated servos: bytes in, bytes out, with the disturbances of a real one on request."""

import random
from dataclasses import dataclass, field

from ...bus.dynamixel import table as t
from ...bus.dynamixel.calibration.data import Calibration, counts_per_rad
from ...robot.model import Robot
from ..plant import Plant
from . import packets as p
from .servo import EmulatedServo

GAP_S = 0.005  # silence after which a half packet is given up
TURN_S = 0.003  # in which a silent id could answer a broadcast ping (host/bus/dynamixel/roll_call.py)


@dataclass
class Disturbance:
    """Shares of packets that are lost or damaged on the wire, both ways, and how many were."""

    lost: float = 0.0
    corrupted: float = 0.0
    seed: int = 0
    packets: int = 0
    lost_packets: int = 0
    corrupted_packets: int = 0
    chance: random.Random = field(init=False)

    def __post_init__(self) -> None:
        self.chance = random.Random(f"bus {self.seed}")

    def carry(self, packet: bytes) -> bytes:
        """Return the part of a packet that arrives: all of it, nothing, or the packet with one byte changed."""
        self.packets += 1
        luck = self.chance.random()
        if luck < self.lost:
            self.lost_packets += 1
            return b""
        if luck < self.lost + self.corrupted:
            self.corrupted_packets += 1
            damaged = bytearray(packet)
            damaged[self.chance.randrange(len(damaged))] ^= self.chance.randrange(1, 256)
            return bytes(damaged)
        return packet


class EmulatedBus:
    """Servos mounted as ``truth`` says on the joints of a plant."""

    def __init__(
        self,
        robot: Robot,
        plant: Plant,
        truth: Calibration,
        protocol: float = 2.0,
        disturbance: Disturbance | None = None,
    ) -> None:
        self.plant, self.protocol = plant, protocol
        self.disturbance = Disturbance() if disturbance is None else disturbance
        per_rad = counts_per_rad(robot)
        self.servos = [EmulatedServo(k, mount, per_rad[k], plant) for k, mount in enumerate(truth.joints)]
        self.baud = robot.bus.baud if robot.bus.kind == "dynamixel" else t.BAUDS[1]
        for servo in self.servos:
            servo.put(t.BAUD, t.BAUDS.index(self.baud))
            servo.put(t.PROTOCOL, int(protocol))
        self._framing = p.framing(protocol)
        self._buffer = bytearray()
        self._last_s = 0.0
        self.intact_answers = 0
        self._called = False

    def servo(self, number: int) -> EmulatedServo:
        """Return the servo with an id; KeyError if there is none."""
        for servo in self.servos:
            if servo.id == number:
                return servo
        raise KeyError(number)

    def advance(self, now_s: float) -> None:
        """Let time pass: the plant moves, the servos watch themselves."""
        self.plant.advance_to(now_s)
        for servo in self.servos:
            servo.watch(now_s)

    def idle(self) -> None:
        """Give up a half packet: the line has been silent."""
        self._buffer.clear()

    def receive(self, data: bytes, now_s: float, baud: int | None = None) -> list[bytes]:
        """Take bytes from the host and return the status packets that reach it, in order."""
        self.advance(now_s)
        if now_s - self._last_s > GAP_S:
            self.idle()
        self._last_s = now_s
        arrived = self.disturbance.carry(data)
        self._buffer += arrived
        answers: list[bytes] = []
        while (instruction := self._framing.take(self._buffer)) is not None:
            answers += self._answers(instruction, now_s, self.baud if baud is None else baud)
        carried = [self.disturbance.carry(answer) for answer in answers]
        self.intact_answers += sum(was == now for was, now in zip(answers, carried, strict=True))
        return [answer for answer in carried if answer]

    def delays_s(self, answers: list[bytes]) -> list[float]:
        """Return how long after a request its answers come: at once, or after the turns of ids that stay silent."""
        if not self._called or self.protocol == 1.0:
            return [0.0] * len(answers)
        return [TURN_S * max(0, answer[4] - before) for before, answer in enumerate(answers)]

    def _answers(self, instruction: p.Instruction, now_s: float, baud: int) -> list[bytes]:
        listening = [s for s in self.servos if not s.missing and t.BAUDS[s.get(t.BAUD)] == baud]
        if not instruction.intact:
            if instruction.servo == p.BROADCAST:
                return []
            error = 0x10 if self.protocol == 1.0 else t.CRC_ERROR
            return [self._framing.status(s.id, error, b"") for s in listening if s.id == instruction.servo]
        for servo in listening:
            servo.heard_s = now_s
        asked = self._asked(instruction, listening)
        self._called = instruction.servo == p.BROADCAST and instruction.code == p.PING
        if self._called:
            return self._call(instruction, listening)
        answers: list[bytes] = []
        for number, address, size in asked:
            answers += self._collide([self._read(s, address, size) for s in listening if s.id == number])
        if asked:
            return answers
        if instruction.code == p.SYNC_WRITE:
            self._sync_write(instruction.parameters, listening)
            return []
        addressed = [s for s in listening if instruction.servo in (s.id, p.BROADCAST)]
        replies = [self._single(s, instruction) for s in addressed]
        return [] if instruction.servo == p.BROADCAST else self._collide(replies)

    def _call(self, ping: p.Instruction, listening: list[EmulatedServo]) -> list[bytes]:
        """Return the answers to a broadcast ping in the order of the ids; those of one id come at once."""
        answers: list[bytes] = []
        for number in sorted({servo.id for servo in listening}):
            answers += self._collide([self._single(servo, ping) for servo in listening if servo.id == number])
        return answers

    def _asked(self, instruction: p.Instruction, listening: list[EmulatedServo]) -> list[tuple[int, int, int]]:
        """Return (id, address, size) of every answer that a reading instruction asks for."""
        data = instruction.parameters
        if instruction.code == p.SYNC_READ and self.protocol == 2.0 and len(data) >= 4:
            address, size = int.from_bytes(data[:2], "little"), int.from_bytes(data[2:4], "little")
            return [(number, address, size) for number in data[4:]]
        if instruction.code == p.BULK_READ and self.protocol == 1.0:
            return [(data[k + 1], data[k + 2], data[k]) for k in range(1, len(data) - 2, 3)]
        return []

    def _read(self, servo: EmulatedServo, address: int, size: int) -> bytes:
        error, data = servo.read(address, size)
        return self._status(servo, error, data)

    def _single(self, servo: EmulatedServo, instruction: p.Instruction) -> bytes:
        wide, data = self._framing.address_size, instruction.parameters
        address = int.from_bytes(data[:wide], "little")
        if instruction.code == p.PING:
            return self._status(servo, 0, servo.read(0, 2)[1] + servo.read(6, 1)[1] if wide == 2 else b"")
        if instruction.code == p.READ and len(data) == 2 * wide:
            return self._read(servo, address, int.from_bytes(data[wide:], "little"))
        if instruction.code == p.WRITE and len(data) > wide:
            answer_as = servo.id  # a servo confirms a new id under the old one
            error = servo.write(address, data[wide:])
            return self._status(servo, error, b"", answer_as)
        if instruction.code == p.REBOOT and wide == 2:
            servo.reboot()
            return self._status(servo, 0, b"")
        return self._status(servo, t.INSTRUCTION_ERROR, b"")

    def _sync_write(self, data: bytes, listening: list[EmulatedServo]) -> None:
        wide = self._framing.address_size
        address, size = int.from_bytes(data[:wide], "little"), int.from_bytes(data[wide : 2 * wide], "little")
        values = data[2 * wide :]
        for at in range(0, len(values) - size, size + 1):
            for servo in listening:
                if servo.id == values[at]:
                    servo.write(address, values[at + 1 : at + 1 + size])

    def _status(self, servo: EmulatedServo, error: int, data: bytes, number: int | None = None) -> bytes:
        trouble = servo.get(t.HARDWARE_ERROR)
        if self.protocol == 1.0:
            error = (0x08 if error else 0) | (trouble & 0x25)
        elif trouble:
            error |= t.ALERT
        return self._framing.status(servo.id if number is None else number, error, data)

    @staticmethod
    def _collide(answers: list[bytes]) -> list[bytes]:
        """Servos that share an id talk at once: on an open-drain line zeros win."""
        if len(answers) < 2:
            return answers
        return [bytes(a & b for a, b in zip(answers[0], answers[1], strict=False))]
