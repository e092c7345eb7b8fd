"""Reads joints.dbc: the subset of the DBC format that the integer codec can carry (little-endian integers).

Independent of any library on purpose: the tests compare the codec made from this reading with cantools.
All scales and limits are exact fractions, because a limit must fall on a whole raw value.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from shared.joint import faults

SOURCE = Path(__file__).with_name("joints.dbc")
MAX_SIGNED_BITS, MAX_UNSIGNED_BITS = 31, 30  # what a small int of 32-bit MicroPython holds

_MESSAGE = re.compile(r"BO_ (\d+) (\w+): (\d+) (\w+)$")
_SIGNAL = re.compile(
    r" SG_ (\w+) : (\d+)\|(\d+)@([01])([+-]) \(([-+.\deE]+),([-+.\deE]+)\) \[([-+.\deE]+)\|([-+.\deE]+)\] \"(.*)\" "
)
_COMMENT = re.compile(r"CM_ (?:BO_ (\d+)|SG_ (\d+) (\w+)) \"(.*)\";$")
_VALUES = re.compile(r"VAL_ (\d+) (\w+) (.*);$")
_ATTRIBUTE = re.compile(r"BA_ \"(\w+)\" (?:BO_ (\d+)|SG_ (\d+) (\w+)) (?:\"(.*)\"|(-?\d+));$")
_IGNORED = re.compile(r"(VERSION|NS_|BS_|BU_|BA_DEF_|BA_DEF_DEF_|CM_ \")|$")


class DbcError(ValueError):
    """An error in one line: file, line or message, what is wrong, what is allowed."""


@dataclass(frozen=True)
class Signal:
    """One field of a frame. ``low`` and ``high`` are raw; ``special`` is the raw value outside them that has a name."""

    name: str
    start: int
    length: int
    signed: bool
    factor: Fraction
    offset: Fraction
    low: int
    high: int
    unit: str
    choices: tuple[tuple[int, str], ...] = ()
    comment: str = ""
    core_unit: str = "1"
    words: str = ""  # "faults": the choices are the codes of shared/joint/faults.py

    @property
    def special(self) -> int | None:
        outside = [raw for raw, _ in self.choices if not self.low <= raw <= self.high]
        return outside[0] if outside else None

    @property
    def is_flags(self) -> bool:
        """Whether the named values are single bits, to be combined."""
        return len(self.choices) > 1 and all(raw > 0 and raw & (raw - 1) == 0 for raw, _ in self.choices)

    @property
    def bit_low(self) -> int:
        return -(1 << (self.length - 1)) if self.signed else 0

    @property
    def bit_high(self) -> int:
        return (1 << (self.length - self.signed)) - 1

    @property
    def layout(self) -> tuple[object, ...]:
        """The properties that decide how raw integers go into the frame."""
        return (self.start, self.length, self.signed, self.low, self.high, self.special)


@dataclass(frozen=True)
class Message:
    """One kind of frame. Instance i of ``first .. first + instances - 1`` has identifier base + i * stride."""

    identifier: int
    name: str
    length: int
    sender: str
    signals: tuple[Signal, ...]
    comment: str = ""
    instances: int = 1
    first: int = 0
    stride: int = 1
    instance_of: str = ""
    codec: str = ""

    @property
    def identifiers(self) -> list[int]:
        return [self.identifier + i * self.stride for i in range(self.first, self.first + self.instances)]


def _fail(place: str, what: str) -> DbcError:
    return DbcError(f"joints.dbc: {place}: {what}")


def _signal(place: str, groups: tuple[str, ...]) -> dict[str, object]:
    name, start, length, order, sign, factor, offset, low, high, unit = groups
    scale, zero = Fraction(factor), Fraction(offset)
    if order != "1":
        raise _fail(place, f"{name} is big-endian, allowed only little-endian (@1)")
    if scale <= 0:
        raise _fail(place, f"{name} has factor {factor}; it must be above 0")
    limits = [(Fraction(limit) - zero) / scale for limit in (low, high)]
    if any(limit.denominator != 1 for limit in limits):
        raise _fail(place, f"{name} has a limit that is not a whole raw value; use a multiple of {factor}")
    return {
        "name": name, "start": int(start), "length": int(length), "signed": sign == "-", "factor": scale,
        "offset": zero, "low": int(limits[0]), "high": int(limits[1]), "unit": unit,
    }  # fmt: skip


def _check_signal(place: str, signal: Signal, bits_used: set[int], frame_bits: int) -> None:
    bits = set(range(signal.start, signal.start + signal.length))
    if signal.length < 1 or signal.length > (MAX_SIGNED_BITS if signal.signed else MAX_UNSIGNED_BITS):
        raise _fail(place, f"{signal.name} has {signal.length} bits, allowed signed 1..31, unsigned 1..30")
    if max(bits) >= frame_bits or bits & bits_used:
        raise _fail(place, f"{signal.name} overlaps another signal or leaves the frame")
    if not signal.bit_low <= signal.low <= signal.high <= signal.bit_high:
        raise _fail(place, f"{signal.name} has raw limits {signal.low}..{signal.high} that its bits can't hold")
    outside = [raw for raw, _ in signal.choices if not signal.low <= raw <= signal.high]
    if len(outside) > 1 or any(not signal.bit_low <= raw <= signal.bit_high for raw in outside):
        raise _fail(place, f"{signal.name} names values {outside} outside its limits, allowed one, within its bits")
    bits_used |= bits


def _check(messages: list[Message]) -> None:
    taken: dict[int, str] = {}
    for message in messages:
        bits_used: set[int] = set()
        for signal in message.signals:
            _check_signal(message.name, signal, bits_used, 8 * message.length)
        if message.length > 8:
            raise _fail(message.name, f"{message.length} bytes; classic CAN carries 0..8")
        for identifier in message.identifiers:
            if identifier > 0x7FF:
                raise _fail(message.name, f"identifier {identifier:#x} is above 0x7ff")
            if identifier in taken:
                raise _fail(message.name, f"identifier {identifier:#x} is already {taken[identifier]}'s")
            taken[identifier] = message.name


class _Reader:
    """Collects the lines of a DBC into plain dictionaries; ``messages`` makes the frozen records of them."""

    def __init__(self) -> None:
        self.heads: dict[int, dict[str, object]] = {}
        self.signals: dict[int, dict[str, dict[str, object]]] = {}
        self.current = -1

    def _target(self, place: str, message: str | None, owner: str | None, signal: str | None) -> dict[str, object]:
        number = int(message or owner or -1)
        if number not in self.heads or (signal and signal not in self.signals[number]):
            raise _fail(place, f"no message or signal {number} {signal or ''}")
        return self.signals[number][signal] if signal else self.heads[number]

    def line(self, place: str, text: str) -> None:
        if found := _MESSAGE.match(text):
            self.current = int(found[1])
            if self.current in self.heads:
                raise _fail(place, f"identifier {found[1]} is given twice")
            self.heads[self.current] = {
                "identifier": self.current, "name": found[2], "length": int(found[3]), "sender": found[4],
            }  # fmt: skip
            self.signals[self.current] = {}
        elif found := _SIGNAL.match(text):
            self.signals[self.current][found[1]] = _signal(place, found.groups())
        elif found := _COMMENT.match(text):
            self._target(place, found[1], found[2], found[3])["comment"] = found[4]
        elif found := _VALUES.match(text):
            pairs = re.findall(r"(-?\d+) \"(\w+)\"", found[3])
            self._target(place, found[1], None, found[2])["choices"] = tuple((int(raw), word) for raw, word in pairs)
        elif found := _ATTRIBUTE.match(text):
            key = re.sub(r"(?<=[a-z])(?=[A-Z])", "_", found[1]).lower()
            value = int(found[6]) if found[6] else found[5]
            self._target(place, found[2], found[3], found[4])[key] = value
        elif not _IGNORED.match(text):
            raise _fail(place, f"can't read {text.strip()[:60]!r}")

    def messages(self) -> list[Message]:
        made = []
        for identifier, head in sorted(self.heads.items()):
            signals = sorted((Signal(**fields) for fields in self.signals[identifier].values()), key=lambda s: s.start)  # type: ignore[arg-type]
            made.append(Message(signals=tuple(signals), **head))  # type: ignore[arg-type]
        return made


def parse(text: str) -> list[Message]:
    """Return the messages of a DBC text in order of identifier, checked; DbcError with one line otherwise."""
    reader = _Reader()
    for number, line in enumerate(text.splitlines(), 1):
        reader.line(f"line {number}", line)
    messages = reader.messages()
    _check(messages)
    return messages


def fault_words() -> tuple[tuple[int, str], ...]:
    """Return (code, word) of every fault of a joint; FAULT_COAST_FROM is a limit, not a code."""
    codes = {n: v for n, v in vars(faults).items() if n.startswith("FAULT_") and n != "FAULT_COAST_FROM"}
    return tuple(sorted((value, name.removeprefix("FAULT_").lower()) for name, value in codes.items()))


def with_faults(messages: list[Message]) -> list[Message]:
    """Return the messages with the fault codes where the DBC asks for them."""
    words, made = fault_words(), []
    for message in messages:
        signals = (replace(s, choices=words) if s.words == "faults" else s for s in message.signals)
        made.append(replace(message, signals=tuple(signals)))
    return made


def load() -> list[Message]:
    """Return the messages of the project's own DBC."""
    return with_faults(parse(SOURCE.read_text()))
