"""`caramelo joints set-id`: gives a board its number on the bus."""

from typing import Annotated

import typer

from ...util.console import screen
from ...util.errors import UserError
from .options import Channel, Interface, RobotName, Sim, joints


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
