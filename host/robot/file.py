"""Loads robot files: TOML in, one checked Robot out, or one line with the file, key, value and what is allowed."""

from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path
from typing import Any, NoReturn, TypeVar, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from shared.gait.gaits import GAIT_NAMES

from ..util import files
from ..util.errors import UserError
from .actuators import CanBus
from .builds import unbuildable
from .checks import complaints
from .gait_names import new_name
from .model import Robot
from .values import Table, show

FOLDER = Path(__file__).parent / "files"
AnyTable = TypeVar("AnyTable", bound=Table)
UNION_KEYS = {"actuator": ("servo", "bldc", "pd"), "bus": ("dynamixel", "can", "none")}


class RobotFileError(UserError):
    """A robot file that can't be used."""


def robot_names() -> list[str]:
    """Return the names of the robots that come with the software, sorted."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def driven_names() -> list[str]:
    """Return the names of the robots that this software can drive; the others are only simulated."""
    return [name for name in robot_names() if load_robot(name).bus.kind != "none"]


def load_robot(name_or_path: str) -> Robot:
    """Return the robot of a name, or of a file that ends in .toml; RobotFileError if anything is wrong."""
    path = find(name_or_path)
    return checked(read_toml(path), str(path))


def load_can_robot(name_or_path: str) -> tuple[Robot, CanBus]:
    """Return the robot of a name or file, and its bus; UserError if its joints are not on CAN."""
    robot = load_robot(name_or_path)
    if robot.bus.kind != "can":
        raise UserError(f"{robot.name} has no joints on CAN; try --robot parallel")
    return robot, robot.bus


def checked(data: dict[str, Any], place: str) -> Robot:
    """Return the robot of a file's tables; RobotFileError that begins with ``place`` if anything is wrong."""
    for key, sentence in former_names(data):
        raise RobotFileError(f"{place}: {key}: {sentence}")
    robot = parsed(Robot, data, place)
    for key, value, allowed in complaints(robot):
        raise RobotFileError(f"{place}: {key}: value {show(value)}: allowed: {allowed}")
    for sentence in unbuildable(robot):
        raise RobotFileError(f"{place}: {sentence}")
    return robot


def parsed(model: type[AnyTable], data: dict[str, Any], place: str) -> AnyTable:
    """Return a file's tables as a ``model``; RobotFileError that begins with ``place`` if a value is wrong."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        errors = error.errors()
        # A missing key is often there under a wrong name, and that error says more.
        first = next((one for one in errors if one["type"] != "missing"), errors[0])
        raise RobotFileError(f"{place}: {explain(first, data, model)}") from None


def find(name_or_path: str) -> Path:
    """Return the file of a robot's name, or the path itself."""
    if name_or_path.endswith(".toml"):
        return Path(name_or_path)
    names = robot_names()
    if name_or_path in names:
        return FOLDER / f"{name_or_path}.toml"
    hint = did_you_mean(name_or_path, names)
    raise RobotFileError(
        f"robot {show(name_or_path)}: unknown{hint}: allowed: {', '.join(names)}, or the path of a file ending in .toml"
    )


def read_toml(path: Path, what: str = "robot") -> dict[str, Any]:
    """Return the tables of a robot's or a gait's TOML file."""
    try:
        return files.read_toml(path)
    except FileNotFoundError:
        known = ", ".join(robot_names() if what == "robot" else GAIT_NAMES)
        raise RobotFileError(f"{path}: no such file; {what}s known by name are {known}") from None
    except OSError as error:
        raise RobotFileError(f"{path}: can't be read: {error.strerror}") from None
    except UnicodeDecodeError as error:
        raise RobotFileError(f"{path}: byte {error.start} is not UTF-8 text: save the file as UTF-8") from None
    except ValueError as error:
        _complain_about_syntax(path, str(error))


def _complain_about_syntax(path: Path, message: str) -> NoReturn:
    reason, _, place = " ".join(message.split()).partition(" (at ")
    place = place.rstrip(")") or "TOML"
    if "overwrite" in reason or "declare" in reason or "twice" in reason:
        reason = f"a key or table is given twice ({reason})"
    raise RobotFileError(f"{path}: {place}: {reason}: allowed: TOML as in {FOLDER.name}/{robot_names()[0]}.toml")


def former_names(data: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield where a file uses a gait's former name, and a sentence with its present name."""
    gait = data.get("gait", {})
    for key, value in gait.items() if isinstance(gait, dict) else ():
        for name in [value] if isinstance(value, str) else value if isinstance(value, dict) else ():
            if new_name(name):
                yield f"gait.{key}", new_name(name)
    yield from ((f"table {name}", new_name(name)) for name in data if new_name(name))


def explain(error: ErrorDetails, data: dict[str, Any], model: type[BaseModel] = Robot) -> str:
    """Return ``key: value ...: what is allowed`` of one pydantic error."""
    place = [part for at, part in enumerate(error["loc"]) if not _is_no_key(error["loc"], at)]
    key, kind, value = ".".join(str(part) for part in place), error["type"], error["input"]
    if kind == "missing":
        page = "robot-files" if model is Robot else "gaits"
        return f"{key}: value missing: it must be there; docs/{page}.md names what is allowed"
    if kind == "extra_forbidden":
        siblings = known_keys(place[:-1], data, model)
        hint = did_you_mean(str(place[-1]), siblings)
        return f"{key}: value {show(value)}: unknown key{hint}: allowed: {', '.join(siblings)}"
    if kind.startswith("union_tag") and isinstance(value, dict):
        found = f"value {show(value['kind'])}" if "kind" in value else "value missing"
        return f"{key}.kind: {found}: allowed: one of {', '.join(show(name) for name in UNION_KEYS[key])}"
    if kind == "value_error":  # about a table as a whole: the sentence begins with the key
        return ".".join(filter(None, (key, error["msg"].removeprefix("Value error, "))))
    if kind == "allowed":
        return f"{key}: value {show(value)}: allowed: {error['msg']}"
    return f"{key}: value {show(value)}: allowed: {'an array of tables' if kind == 'tuple_type' else 'a table'}"


def _is_no_key(place: tuple[int | str, ...], at: int) -> bool:
    return place[at] == "[key]" or (at == 1 and place[at] in UNION_KEYS.get(str(place[0]), ()))


def known_keys(place: list[int | str], data: dict[str, Any], model: type[BaseModel]) -> list[str]:
    """Return the keys that the table at ``place`` may have, in a file of ``model``."""
    inside: Any = data
    for part in place:
        inside = inside[part]
        if isinstance(part, str):
            model = _table_of(model, part, inside)
    return list(model.model_fields)


def _table_of(model: type[BaseModel], key: str, inside: Any) -> type[BaseModel]:
    """Return the class of the table under ``key``; if there are several, the one for the table's ``kind``."""
    tables = [choice for choice in _parts(model.model_fields[key].annotation) if issubclass(choice, BaseModel)]
    if len(tables) == 1:
        return tables[0]
    return next(table for table in tables if inside["kind"] in get_args(table.model_fields["kind"].annotation))


def _parts(annotation: Any) -> list[type]:
    return [part for part in (annotation, *get_args(annotation)) if isinstance(part, type)]


def did_you_mean(word: str, known: list[str]) -> str:
    """Return a hint for a mistyped word, or nothing."""
    close = get_close_matches(word, known, 1)
    return f", did you mean {close[0]}?" if close else ""
