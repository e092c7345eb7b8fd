"""Loads gait files: TOML in, a robot with that gait out, or one line with the file, key, value and what is allowed."""

from pathlib import Path

from .builds import unbuildable
from .file import RobotFileError, parsed, read_toml
from .gait_names import gait_index
from .model import Robot
from .own_gait import OwnGait


def with_gait(robot: Robot, name_or_path: str | None) -> Robot:
    """Return a robot that starts with a gait it knows, or that of a file ending in .toml; None keeps its own gait.

    UserError for an unknown name, or a file that can't be used.
    """
    if name_or_path is None:
        return robot
    if not name_or_path.endswith(".toml"):
        gait_index(robot, name_or_path)
        return _changed(robot, default=name_or_path)
    own = parsed(OwnGait, read_toml(Path(name_or_path), "gait"), name_or_path)
    others = tuple(each for each in robot.gait.own if each.name != own.name)
    robot = _changed(robot, own=(*others, own), default=own.name)
    for sentence in unbuildable(robot):
        raise RobotFileError(f"{name_or_path}: {sentence}")
    return robot


def _changed(robot: Robot, **values: object) -> Robot:
    return robot.model_copy(update={"gait": robot.gait.model_copy(update=values)})
