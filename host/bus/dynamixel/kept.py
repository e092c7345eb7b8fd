"""A TOML file with what a guided procedure has done so far, joint by joint, from which it can go on."""

from collections.abc import Mapping
from dataclasses import asdict, fields
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from ...util.errors import UserError
from ...util.files import read_toml, write_text
from ..base import JOINT_LABELS

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Done = TypeVar("Done", bound="DataclassInstance")


def write_kept(path: Path, robot: str, done: Mapping[int, Done]) -> None:
    """Write what is done for each joint: dataclasses of whole numbers."""
    lines = [f'robot = "{robot}"']
    for joint, one in sorted(done.items()):
        values = ", ".join(f"{name} = {value}" for name, value in asdict(one).items())
        lines.append(f'"{JOINT_LABELS[joint]}" = {{ {values} }}')
    write_text(path, "\n".join(lines) + "\n")


def read_kept(path: Path, robot: str, kind: type[Done]) -> dict[int, Done]:
    """Return what is done, by joint; UserError if it is not such a file, or belongs to another robot."""
    remedy = "delete the file to start again"
    try:
        tables = read_toml(path)
        if tables.pop("robot") != robot:
            raise UserError(f"{path}: begun for another robot; {remedy}")
        return {JOINT_LABELS.index(label): _one(values, kind) for label, values in tables.items()}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise UserError(f"{path}: can't go on from this file ({error}); {remedy}") from None


def _one(values: Mapping[str, int], kind: type[Done]) -> Done:
    if set(values) != {field.name for field in fields(kind)} or any(type(each) is not int for each in values.values()):
        raise TypeError("whole numbers only")
    return kind(**values)
