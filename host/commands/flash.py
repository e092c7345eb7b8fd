"""`caramelo flash`: puts firmware on boards, and never leaves a board without working firmware."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import progress, screen, write_error, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Json, RobotName
from .joints.options import Channel, Interface

if TYPE_CHECKING:
    from ..boards.flash.flash import Outcome, Wish

ImagePath = Annotated[Path, typer.Argument(metavar="IMAGE", help="Image file made by caramelo firmware image.")]
Nodes = Annotated[list[int] | None, typer.Argument(metavar="ID", help="With --can: the joints, 1 to 12.")]
Can = Annotated[bool, typer.Option("--can", help="Over the joints' bus: the joints named, or all twelve with --all.")]
Port = Annotated[list[str] | None, typer.Option("--port", help="Serial port of the board; repeatable with --all.")]
All = Annotated[bool, typer.Option("--all", help="All boards, found or named with --port; with --can all joints.")]
Node = Annotated[int | None, typer.Option("--id", min=1, max=12, help="Id that the joint gets on the bus and keeps.")]
JOINTS_ROBOT = "parallel"  # whose joints are on CAN
Dry = Annotated[bool, typer.Option("--dry-run", help="Only print what would be done.")]


def flash(
    image: ImagePath,
    nodes: Nodes = None,
    can: Can = False,
    port: Port = None,
    every: All = False,
    node: Node = None,
    dry_run: Dry = False,
    robot: RobotName = JOINTS_ROBOT,
    interface: Interface = None,
    channel: Channel = None,
    as_json: Json = False,
) -> int:
    """Put firmware on a board. It goes into the slot that does not run, and the board compares it. The old firmware
    stays until the new one has proved itself.

    Over USB the motor supply must be off; over the joints' bus no joint may be armed. A joint keeps its parameters.

    Examples: caramelo flash out/firmware/joint.caramelo --port /dev/ttyACM0 --id 3;
    caramelo flash out/firmware/joint.caramelo --can --all; caramelo flash out/firmware/joint.caramelo --can 4 5 6
    """
    if can:
        from ._flash_can import flash_over_can

        if port or node is not None:
            raise UserError("flash --can: --port and --id are for boards on USB; name joints by number, or --all")
        return flash_over_can(image, nodes or [], every, dry_run, (robot, interface, channel), as_json)
    if nodes or interface or channel or robot != JOINTS_ROBOT:
        raise UserError("flash: joint numbers, --robot, --interface and --channel go with --can; "
                        "name boards on USB with --port")
    from ..boards.build.image_file import read_image_file
    from ..boards.flash.flash import Wish

    ports = _ports(port or [], every)
    if node is not None and len(ports) > 1:
        raise UserError(f"--id {node}: two joints with the same id can't share a bus; flash them one by one")
    wish = Wish(read_image_file(image), node, dry_run)
    outcomes, failures = [], {}
    for device in ports:
        try:
            outcomes.append(_flash(device, wish))
        except UserError as error:
            if not every:
                raise
            failures[device] = str(error)
            write_error(str(error))
            continue
        if not as_json:
            _print(outcomes[-1])
    if as_json:
        write_json({"boards": [asdict(outcome) for outcome in outcomes], "failures": failures})
    return NOT_ACHIEVED if failures else 0


def _flash(device: str, wish: "Wish") -> "Outcome":
    from ..boards.flash.flash import flash as flash_board

    with progress(device, 1) as advance:
        return flash_board(device, wish, lambda done, total: advance(done / total if total else 1))


def _ports(named: list[str], every: bool) -> list[str]:
    """Return the ports to flash; UserError if the command does not name them clearly."""
    from ..boards.flash.link import found_ports

    if not every:
        if len(named) != 1:
            raise UserError("flash: name one board with --port DEVICE, or several with --all")
        return named
    ports = named or found_ports()
    if not ports:
        raise UserError("flash --all: no board with a USB serial port is plugged in")
    return list(dict.fromkeys(ports))


def _print(outcome: "Outcome") -> None:
    console = screen()
    console.soft_wrap = True
    if not outcome.changed:
        console.print(f"{outcome.port}: nothing to do: slot {outcome.slot} runs build {outcome.build}")
        return
    head = "would write" if outcome.dry_run else "wrote"
    size = f"{outcome.bytes} bytes" if outcome.bytes else "which holds it already"
    console.print(f"{outcome.port}: {head} build {outcome.build} to slot {outcome.slot}, {size}")
    if not outcome.dry_run:
        protocol = "none" if outcome.protocol is None else f"{outcome.protocol:#x}"
        console.print(
            f"{outcome.port}: runs version {outcome.version}, protocol {protocol}, "
            f"self-test {outcome.self_test}, confirmed"
        )
