"""Builds all that any command builds from a robot before it runs, so that a file that passes the check can be used."""

from collections.abc import Iterator

from shared.gait.gaits import GAITS, gait_for

from ..util.errors import UserError
from .actuators import Bldc, CanBus
from .joint_gains import impedance_gains, joint_blocks
from .joint_setups import joint_setups
from .model import Robot
from .plane import planar_robot
from .scale import attitude_block, core_params


def unbuildable(robot: Robot) -> Iterator[str]:
    """Yield a sentence for each part that can't be built: planner, gaits, the plane, the joints' blocks and gains."""
    for build in (_planner, planar_robot, attitude_block, _joints):
        try:
            build(robot)
        except (UserError, ValueError) as error:
            yield str(error)


def _planner(robot: Robot) -> None:
    params = core_params(robot)
    for entry in (*GAITS, *(own.entry for own in robot.gait.own)):
        try:
            gait_for(entry, params)
        except ValueError as error:
            raise UserError(f"gait {entry[0]}: {error}") from error


def _joints(robot: Robot) -> None:
    if isinstance(robot.actuator, Bldc):
        for setup in dict.fromkeys(joint_setups(robot)):
            joint_blocks(robot.actuator, setup)
        if isinstance(robot.bus, CanBus) and robot.bus.loops == "impedance":
            impedance_gains(robot.actuator)
