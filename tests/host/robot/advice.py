"""Robots whose file advises other gaits than theirs."""

from host.robot.file import load_robot


def advising(name, advised_m_s):
    """Return a robot that advises these gaits up to these speeds, and says nothing of others."""
    robot = load_robot(name)
    gait = robot.gait.model_copy(update={"advised_m_s": advised_m_s, "not_advised": {}})
    return robot.model_copy(update={"gait": gait})
