"""`caramelo joints set-id|calibrate`: what a board is told once."""

from typing import Annotated

import typer

from ...util.console import screen
from ...util.errors import NOT_ACHIEVED, UserError
from .options import Channel, Interface, Node, RobotName, Sim, joints


def set_id(
    board: Annotated[str, typer.Argument(metavar="BOARD", help="The board's number, as joints scan shows it.")],
    node: Annotated[int, typer.Argument(metavar="NODE", min=0, max=12, help="The node it gets; 0 takes it away.")],
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Give a board another node, and keep it. Refused if another board has that node.

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
    screen().print(f"board {number:#x} is node {node} now")
    return 0


def calibrate(
    node: Node,
    kind: Annotated[str, typer.Option(help="full: free to turn; small: in an assembled leg; verify.")] = "small",
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
) -> int:  # fmt: skip
    """Calibrate one joint's motor against its encoder, and keep the result. Exit code 1 with the reason if it fails.

    Simulated joints are calibrated already, and their ideal current loop cannot be.

    Example: caramelo joints calibrate 5 --kind full
    """
    from shared.joint.calibration import CAL_FULL, CAL_SMALL, CAL_VERIFY
    from shared.wire import names as w

    kinds = {"full": CAL_FULL, "small": CAL_SMALL, "verify": CAL_VERIFY}
    if kind not in kinds:
        raise UserError(f"--kind {kind}: allowed {', '.join(kinds)}")
    if sim:
        raise UserError("simulated joints have an ideal current loop, which cannot be calibrated: leave --sim out")
    with joints(robot, interface, channel, sim) as bus:
        view = bus.link.views[node]
        bus.requests.challenged(node, w.COMMAND_CALIBRATE, kinds[kind], low=0)
        bus.run_for(0.5)
        while view.heartbeat.mode == w.MODE_CALIBRATING:
            bus.run_for(0.1)
        if view.heartbeat.fault:
            raise UserError(bus.cycle.guard.fault_text(view), NOT_ACHIEVED)
        if kind != "verify":
            bus.requests.demand(node, w.COMMAND_SAVE_PARAMETERS)
    screen().print(f"node {node} is calibrated")
    return 0
