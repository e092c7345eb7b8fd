"""A joint's saved parameters in a JSON file: raw integers by name, with the protocol that they belong to."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from shared.wire.names import PROTOCOL_HASH

from ...protocol.parameters import Parameter, ParameterError, load
from ...util.errors import UserError
from ...util.files import read_text, write_text

NOT_IN_FILES = "node_id"  # a file may go to another joint, which keeps its own node


def kept() -> list[Parameter]:
    """Return the parameters that belong in a file."""
    return [parameter for parameter in load() if parameter.stored and parameter.name != NOT_IN_FILES]


def write_file(path: Path, node: int, values: Mapping[str, int]) -> None:
    """Write raw values by name; ``node`` says where they came from."""
    content = {"protocol": f"{PROTOCOL_HASH:#06x}", "node": node, "parameters": dict(values)}
    write_text(path, json.dumps(content, indent=1) + "\n")


def read_file(path: Path) -> dict[str, int]:
    """Return the raw values of a file, each known and within its limits; UserError names what is wrong."""
    try:
        content: Any = json.loads(read_text(path))
        protocol, values = content["protocol"], dict(content["parameters"])
    except OSError as error:
        raise UserError(f"{path}: can't be read: {error.strerror or error}") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise UserError(f"{path}: not a file of params save --file ({type(error).__name__}: {error})") from error
    if protocol != f"{PROTOCOL_HASH:#06x}":
        raise UserError(f"{path}: has protocol {protocol}, this is {PROTOCOL_HASH:#06x}: save the joint's again")
    known = {parameter.name: parameter for parameter in kept()}
    for name, raw in values.items():
        if name not in known or type(raw) is not int:
            raise UserError(f"{path}: {name} = {raw!r}: allowed: whole numbers, for parameters that a joint saves")
        try:
            known[name].to_raw(known[name].to_value(raw))
        except ParameterError as error:
            raise UserError(f"{path}: {error}") from error
    return values
