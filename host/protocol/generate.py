"""Writes everything made from joints.dbc and parameters.toml: codec, names, limits, docs tables.

Run as ``python -m host.protocol.generate``. No line of the output depends on the machine.
"""

from __future__ import annotations

import hashlib
from pathlib import Path

from .. import ROOT
from ..util.files import write_text
from . import dbc, parameters
from . import generate_codec as wire_codec
from . import generate_docs as wire_docs
from . import generate_names as wire_names
from .dbc import Message
from .parameters import Parameter

DOCS = "docs/can-protocol.md"


def canonical(messages: list[Message], table: list[Parameter]) -> str:
    """The meaning of the frames and parameters, without layout, order and comments of the sources."""
    lines = []
    for m in sorted(messages, key=lambda message: message.identifier):
        lines.append(f"message {m.identifier} {m.name} {m.length} {m.first} {m.instances} {m.stride}")
        for s in sorted(m.signals, key=lambda signal: signal.start):
            choices = " ".join(f"{raw}={word}" for raw, word in sorted(s.choices))
            lines.append(
                f"signal {s.name} {s.start} {s.length} {s.signed:d} {s.factor} {s.offset} {s.low} {s.high} {s.unit} "
                f"{choices}"
            )
    lines += [f"parameter {p.id} {p.name} {p.unit} {p.raw_per_unit}" for p in table]
    return "\n".join(lines)


def protocol_hash(messages: list[Message], table: list[Parameter]) -> int:
    """First 16 bits of the SHA-256 of the canonical text; skips 0 and 0xFFFF, which are empty and erased memory."""
    digest = hashlib.sha256(canonical(messages, table).encode()).digest()
    pairs = [digest[i] << 8 | digest[i + 1] for i in range(0, len(digest), 2)]
    return next(value for value in pairs if value not in (0, 0xFFFF))


def outputs() -> dict[Path, str]:
    """The whole text of every generated file."""
    messages, table = dbc.load(), parameters.load()
    number = protocol_hash(messages, table)
    tables = {
        "messages": wire_docs.message_table(messages, number),
        "fields": wire_docs.field_table(messages),
        "words": wire_docs.word_tables(messages),
        "parameters": wire_docs.parameter_table(table),
    }
    return {
        ROOT / "shared/wire/codec.py": wire_codec.render(messages),
        ROOT / "shared/wire/names.py": wire_names.render_names(messages, number),
        ROOT / "shared/wire/parameters.py": wire_names.render_parameters(table),
        ROOT / DOCS: wire_docs.fill((ROOT / DOCS).read_text(), tables),
    }


if __name__ == "__main__":
    for path, text in outputs().items():
        write_text(path, text)
