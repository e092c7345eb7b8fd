"""Which gaits are advised for a robot, up to which speed, and why the others are not advised.

The robot file says what was tried (docs/robot-files.md), and only this module reads it. A gait that the file does not
name has not been tried.
"""

from .gait_names import gait_names
from .model import Robot

UNTRIED = "not tried on this robot; only a walk in three dimensions shows if it falls over: caramelo walk --in space"
WALKED_IN_SPACE = "not tried on this robot before: judge it by this walk"


def why_not_advised(robot: Robot, gait: str, speed_m_s: float = 0.0, *, in_space: bool = False) -> str:
    """Return why a gait is not advised for this robot at this speed, "" if it is; at speed 0, about the gait alone.

    ``in_space``: it has just walked in three dimensions, so nobody has to be sent there.
    """
    most_m_s = tried_up_to_m_s(robot, gait)
    if most_m_s is None:
        return robot.gait.not_advised.get(gait, WALKED_IN_SPACE if in_space else UNTRIED)
    return f"tried only up to {most_m_s:g} m/s" if abs(speed_m_s) > most_m_s else ""


def tried_up_to_m_s(robot: Robot, gait: str) -> float | None:
    """Return up to which speed a gait is advised, None if the file does not say."""
    return robot.gait.advised_m_s.get(gait)


def gait_advice(robot: Robot) -> dict[str, str]:
    """Return every gait's name, in the planner's order, with why it is not advised for this robot, "" if it is."""
    return {gait: why_not_advised(robot, gait) for gait in gait_names(robot)}
