"""`caramelo joints arm|disarm|clear|set-id`: torque on and off, latched faults, a board's number on the bus."""

from typing import Annotated

import typer

from ...util.console import screen
from ...util.errors import NOT_ACHIEVED, UserError
from .options import Channel, Interface, RobotName, Seconds, Sim, joints


def arm(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, seconds: Seconds = None,
    limit: Annotated[
        float | None, typer.Option(min=0.0, max=1.0, help="Share of current limit (default: stand.torque_fraction).")
    ] = None,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Arm all joints where they are and hold them while this runs, then disarm. Exit code 1 if a joint gives up.

    A robot that stands on its legs needs most of the current: with half of it, a joint stalls after a second.

    Example: caramelo joints arm --sim --seconds 1
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.open()
        bus.limit_torque(bus.robot.stand.torque_fraction if limit is None else limit)
        console = screen()  # loaded now, because that takes longer than the joints' watchdog waits
        console.print("arming; Ctrl-C disarms")
        bus.torque(True)
        began_s = bus.now()
        try:
            while bus.cycle.armed and (seconds is None or bus.now() - began_s < seconds):
                bus.run_for(0.05)
        except KeyboardInterrupt:
            screen().print("stopped")
        gave_up = bus.cycle.reaction in ("damp", "stop")
        bus.torque(False)
        timing = bus.cycle.timing.as_dict()
    screen().print(f"disarmed; cycles started late: {timing['late']}, skipped: {timing['skipped']}", soft_wrap=True)
    return NOT_ACHIEVED if gave_up else 0


def disarm(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False
) -> int:
    """Disarm all joints, no matter which program armed them. Exit code 1 if one does not confirm it.

    Example: caramelo joints disarm
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.torque(False)
        bus.await_off()
    screen().print("all joints have let go")
    return 0


def clear(robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False) -> int:
    """Clear latched faults. This arms nothing. Exit code 1 if something still prevents arming.

    Example: caramelo joints clear
    """
    with joints(robot, interface, channel, sim) as bus:
        bus.clear_faults()
        bus.refuse_unfit()
    screen().print("no fault is latched")
    return 0


def set_id(
    board: Annotated[str, typer.Argument(metavar="BOARD", help="The board's number, as joints scan shows it.")],
    node: Annotated[int, typer.Argument(metavar="NODE", min=0, max=12, help="The new node; 0 takes the old one away.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Give a board another node, which it keeps. Refused if another board has that node.

    Example: caramelo joints set-id 0x2ab1c2d3 5
    """
    from shared.wire import names as w

    try:
        number = int(board, 0)
    except ValueError as error:
        raise UserError(f"BOARD {board}: give a number such as 0x2ab1c2d3") from error
    with joints(robot, interface, channel, sim) as bus:
        taken = bus.requests.discover().get(node, set()) - {number}
        if node and taken:
            raise UserError(f"node {node} is taken by board {min(taken):#x}: give that one another node first")
        bus.requests.to_board(w.COMMAND_SET_ID, number, node)
        bus.run_for(0.05)
        if node:
            bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"board {number:#x} is now node {node}")
    return 0
