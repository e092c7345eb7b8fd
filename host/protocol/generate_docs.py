"""Renders the protocol for people and other tools: tables of docs/can-protocol.md, and the expanded DBC.

joints.dbc holds one message per kind. SavvyCAN, Kvaser's tools and cantools need one per identifier, with
the joints' names: `caramelo joints dbc` writes that.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction

from .dbc import Message, Signal
from .parameters import Parameter

JOINTS = [f"{leg}_{joint}" for leg in ("FR", "FL", "RR", "RL") for joint in ("hip", "thigh", "calf")]


def _number(value: Fraction) -> str:
    """Decimal text of a fraction, exact up to 28 digits."""
    return f"{Decimal(value.numerator) / value.denominator:f}"


def _physical(signal: Signal, raw: int) -> str:
    return _number(raw * signal.factor + signal.offset)


def message_table(messages: list[Message], protocol_hash: int) -> str:
    lines = [
        f"Protocol hash: `0x{protocol_hash:04X}`", "",
        "| identifiers | message | bytes | sender | meaning |", "|---|---|---|---|---|",
    ]  # fmt: skip
    for m in messages:
        step = f" (+{m.stride} per {m.instance_of})" if m.instance_of else ""
        last = f" .. 0x{m.identifiers[-1]:03X}" if m.instances > 1 else ""
        sender = "any" if m.sender.startswith("Vector") else m.sender
        lines.append(f"| 0x{m.identifiers[0]:03X}{last}{step} | `{m.name}` | {m.length} | {sender} | {m.comment} |")
    return "\n".join(lines)


def _field_row(message: Message, signal: Signal, name: str, bits: str) -> str:
    kind = f"{'int' if signal.signed else 'uint'}{signal.length}"
    unit = f"{_number(signal.factor)} {signal.unit}".strip()
    if signal.core_unit not in ("1", signal.unit):
        unit += f" ({signal.core_unit})"
    limits = f"{_physical(signal, signal.low)} .. {_physical(signal, signal.high)}"
    if signal.special is not None:
        limits += f"; raw {signal.special} = {dict(signal.choices)[signal.special]}"
    return f"| `{message.name}` | {name} | {bits} | {kind} | {unit} | {limits} | {signal.comment} |"


def field_table(messages: list[Message]) -> str:
    """One row per field; the equal slots of a group share one."""
    lines = ["| message | field | bits | type | one raw unit | range | meaning |", "|---|---|---|---|---|---|---|"]
    for m in messages:
        if m.instance_of == "group":
            first, last = m.signals[0], m.signals[-1]
            lines.append(_field_row(m, first, f"`{first.name}` .. `{last.name}`", f"{first.length} each"))
            continue
        for s in m.signals:
            lines.append(_field_row(m, s, f"`{s.name}`", f"{s.start}..{s.start + s.length - 1}"))
    return "\n".join(lines)


def word_tables(messages: list[Message]) -> str:
    parts, seen = [], set()
    for m in messages:
        for s in m.signals:
            words = [f"{raw} {word}" for raw, word in s.choices if raw != s.special]
            if s.words:
                words = [f"{words[0]}, else the codes of `shared/joint/{s.words}.py`"]
            if words and (s.name, s.choices) not in seen:
                seen.add((s.name, s.choices))
                kind = "bits" if s.is_flags else "values"
                parts.append(f"* `{m.name}.{s.name}` ({kind}): " + ", ".join(words))
    return "\n".join(parts)


def _parameter_row(p: Parameter) -> str:
    low, high, default = (f"{p.to_value(raw):.10g}" for raw in (p.low, p.high, p.default))
    access = {"measured": "no", "live": "any time", "disarmed": "disarmed"}[p.access]
    several = p.count > 1
    number = f"{p.id} .. {p.id + p.count - 1}" if several else str(p.id)
    name = f"{p.name.removesuffix('_0')}_i" if several else p.name
    limits = f"{low} .. {high}" + ("" if p.zero else ", not 0")
    stored = "yes" if p.stored else "no"
    cells = (number, f"`{name}`", p.unit, p.raw_per_unit, limits, default, access, stored, p.meaning)
    return "| " + " | ".join(map(str, cells)) + " |"


def parameter_table(parameters: list[Parameter]) -> str:
    lines = [
        "| id | name | unit | raw per unit | range | default | write | stored | meaning |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    return "\n".join([*lines, *(_parameter_row(p) for p in parameters if p.place == 0)])


def fill(text: str, tables: dict[str, str]) -> str:
    """Return ``text`` with its table between each pair of markers; every table must appear."""
    for name, table in tables.items():
        pattern = re.compile(rf"(<!-- generated: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        text, found = pattern.subn(lambda m, body=table: f"{m[1]}{body}\n{m[2]}", text)  # type: ignore[misc]
        if found != 1:
            raise ValueError(f"docs/can-protocol.md: marker of table {name!r} found {found} times, allowed once")
    return text


def _instance(message: Message, number: int) -> tuple[str, Callable[[Signal], str]]:
    """Return the name of one instance of a message, and a function for its signals' names there."""
    if message.instance_of == "group":
        slots = JOINTS[4 * number : 4 * number + 4]
        return f"{message.name}_{number}", lambda s: slots[int(s.name[-1])]
    if message.instance_of == "node":
        return f"{message.name}_{JOINTS[number - 1] if number else 'node_0'}", lambda s: s.name
    if message.instance_of:
        return f"{message.name}_{number}", lambda s: s.name
    return message.name, lambda s: s.name


def _signal_line(signal: Signal, name: str, receiver: str) -> str:
    sign = "-" if signal.signed else "+"
    limits = f"[{_physical(signal, signal.low)}|{_physical(signal, signal.high)}]"
    scale = f"({_number(signal.factor)},{_number(signal.offset)})"
    return f' SG_ {name} : {signal.start}|{signal.length}@1{sign} {scale} {limits} "{signal.unit}" {receiver}'


def expanded_dbc(messages: list[Message]) -> str:
    """One message per identifier, signals of groups named after their joints."""
    heads, tails = [], []
    for m in messages:
        receiver = "joint" if m.sender == "host" else "host"
        for number, identifier in enumerate(m.identifiers, m.first):
            name, signal_name = _instance(m, number)
            lines = [f"BO_ {identifier} {name}: {m.length} {m.sender}"]
            lines += [_signal_line(s, signal_name(s), receiver) for s in m.signals]
            heads.append("\n".join(lines))
            for s in m.signals:
                if s.choices:
                    words = " ".join(f'{raw} "{word}"' for raw, word in s.choices)
                    tails.append(f"VAL_ {identifier} {signal_name(s)} {words} ;")
    note = 'CM_ "Written by caramelo joints dbc.";'
    return 'VERSION "1"\n\nNS_ :\n\nBS_:\n\nBU_: host joint\n\n' + "\n\n".join([*heads, note, "\n".join(tails)]) + "\n"
