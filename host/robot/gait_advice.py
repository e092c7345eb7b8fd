"""Which gaits are advised for a robot, up to which speed, and why the others are not advised.

The robot file says what was tried (docs/robot-files.md), and only this module reads it. A gait that the file does not
name has not been tried.
"""

from .gait_names import gait_names
from .model import Robot

UNTRIED = "not tried on this robot in three dimensions, where it may fall sideways: try caramelo walk --in space"


def why_not_advised(robot: Robot, gait: str, speed_m_s: float = 0.0) -> str:
    """Return why a gait is not advised for this robot at this speed, "" if it is; at speed 0, about the gait alone."""
    own = robot.gait
    if gait not in own.advised_m_s:
        return own.not_advised.get(gait, UNTRIED)
    most_m_s = own.advised_m_s[gait]
    return f"tried only up to {most_m_s:g} m/s" if abs(speed_m_s) > most_m_s else ""


def gait_advice(robot: Robot) -> dict[str, str]:
    """Return every gait's name, in the planner's order, with why it is not advised for this robot, "" if it is."""
    return {gait: why_not_advised(robot, gait) for gait in gait_names(robot)}
