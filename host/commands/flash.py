"""`caramelo flash`: puts firmware on boards, and never leaves one without."""

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated

import typer

from ..console import progress, screen, write_error, write_json
from ..errors import NOT_ACHIEVED, UserError
from . import HARDWARE

if TYPE_CHECKING:
    from ..build.image import Image
    from ..flash.flash import Outcome, Wish

Port = Annotated[list[str] | None, typer.Option("--port", help="Serial port of the board; with --all, several times.")]
All = Annotated[bool, typer.Option("--all", help="Flash every board named by --port; without any, every board found.")]
Role = Annotated[str, typer.Option(help="What the board is to be: joint or gait.")]
Node = Annotated[int | None, typer.Option("--id", min=1, max=12, help="The joint's id on the bus; it keeps it.")]
RobotName = Annotated[str, typer.Option("--robot", help="Whose data a gait board gets: a name, or a .toml file.")]
Slot = Annotated[str, typer.Option(help="Slot to write: a, b, or auto for the one not in use.")]
Dry = Annotated[bool, typer.Option("--dry-run", help="Only tell what would be done.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object.")]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("flash", rich_help_panel=HARDWARE)(flash)


def flash(
    port: Port = None,
    every: All = False,
    role: Role = "joint",
    node: Node = None,
    robot: RobotName = "caramelo",
    slot: Slot = "auto",
    dry_run: Dry = False,
    as_json: Json = False,
) -> int:
    """Build firmware and put it on a board: only what changed, compared on the board, old firmware kept until the new
    one has proved itself.

    The motor supply must be off. Files of your own and a joint's parameters stay.

    Example: caramelo flash --port /dev/ttyACM0 --role joint --id 3
    """
    from ..flash.flash import Wish

    ports = _ports(port or [], every)
    _check(role, node, slot, len(ports))
    wish = Wish(role, lambda emitter, arch: _image(role, emitter, arch, robot), slot, node, dry_run)
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
    from ..flash.flash import flash as flash_board

    with progress(device, 1) as advance:
        return flash_board(device, wish, lambda done, total: advance(done / total if total else 1))


def _ports(named: list[str], every: bool) -> list[str]:
    """Return the ports to flash; UserError if that is not clear."""
    from ..flash.link import found_ports

    if not every:
        if len(named) != 1:
            raise UserError("flash: name one board with --port DEVICE, or several with --all")
        return named
    ports = named or found_ports()
    if not ports:
        raise UserError("flash --all: no board is plugged in, or none with a USB serial port")
    return list(dict.fromkeys(ports))


def _check(role: str, node: int | None, slot: str, boards: int) -> None:
    from ..build.image import ROLES
    from ..flash.plan import SLOTS

    for option, value, allowed in (("--role", role, tuple(ROLES)), ("--slot", slot, ("auto", *SLOTS))):
        if value not in allowed:
            raise UserError(f"{option} {value}: not known; there are {', '.join(allowed)}")
    if node is not None and role != "joint":
        raise UserError(f"--id {node}: only joints have one; this is the role {role}")
    if node is not None and boards > 1:
        raise UserError(f"--id {node}: two joints with one id can't share a bus; flash them one by one")


def _image(role: str, emitter: str, arch: str, robot: str) -> "Image":
    from ..build.source import BuildError
    from .firmware import board_image

    try:
        return board_image(role, emitter, arch, robot)
    except BuildError as error:
        raise UserError(str(error)) from error


def _print(outcome: "Outcome") -> None:
    console = screen()
    console.soft_wrap = True
    if not outcome.changed:
        console.print(f"{outcome.port}: nothing to do: slot {outcome.slot} runs build {outcome.build}")
        return
    head = "would write" if outcome.dry_run else "wrote"
    console.print(
        f"{outcome.port}: {head} slot {outcome.slot}, build {outcome.build}: {len(outcome.uploaded)} files sent "
        f"({outcome.bytes} bytes), {len(outcome.copied)} copied on the board, {len(outcome.removed)} removed"
    )
    if outcome.dry_run:
        for path in outcome.uploaded:
            console.print(f"  send    {path}")
        for path in outcome.removed:
            console.print(f"  remove  {path}")
        return
    protocol = "none" if outcome.protocol is None else f"{outcome.protocol:#x}"
    console.print(
        f"{outcome.port}: runs version {outcome.version}, protocol {protocol}, self-test {outcome.self_test}, confirmed"
    )
