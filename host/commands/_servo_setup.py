"""`caramelo servos setup`: gives new servos, plugged in one at a time, their ids, the bus's rate and settings."""

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, redirect_stdout
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ..util.console import print_table, write_error, write_json
from ..util.errors import UserError
from ._options import RobotName

if TYPE_CHECKING:
    from ..bus.dynamixel.calibration.person import Person
    from ..bus.dynamixel.link import Link
    from ..bus.dynamixel.setup import Done
    from ..robot.model import Robot


def setup(
    robot: RobotName = "caramelo",
    port: Annotated[str | None, typer.Option(help="Serial port (default: the robot file's).")] = None,
    joint: Annotated[str | None, typer.Option(metavar="JOINT", help="Set up only this one, such as 'FR hip'.")] = None,
    calibration: Annotated[Path | None, typer.Option(metavar="FILE", help="Take its ids (default: 1 .. 12).")] = None,
    answers: Annotated[Path | None, typer.Option(metavar="FILE", help="Take the answers from a file.")] = None,
    record: Annotated[Path | None, typer.Option(metavar="FILE", help="Write each answer to a file.")] = None,
    sim: Annotated[bool, typer.Option("--sim", help="Practise on twelve emulated servos, fresh from the box.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print one JSON object; questions go to stderr.")] = False,
) -> int:
    """Set up new servos, plugged in one at a time: id, rate, return delay and limits, whatever they were before.

    Ctrl-C stops; the same command goes on from there, because a file keeps what is done. --joint sets up a single
    servo, such as a spare part. If a servo can't be used, one sentence says why; plug in the next one.

    Examples: caramelo servos setup; caramelo servos setup --joint 'RL calf'; caramelo servos setup --sim
    """
    from ..bus.base import JOINT_LABELS
    from ..bus.dynamixel.calibration.data import default_path, load_calibration, nominal
    from ..bus.dynamixel.calibration.person import AtTerminal, FromFile, matching, read_answers
    from ..bus.dynamixel.link import serial_bus
    from ..bus.dynamixel.setup import Setup
    from ..robot.file import load_robot

    data = load_robot(robot)
    rate, chosen = serial_bus(data).baud, JOINT_LABELS if joint is None else (matching(joint, JOINT_LABELS),)
    if chosen[0] is None:
        raise UserError(f"--joint {joint}: allowed {', '.join(JOINT_LABELS)}")
    if answers is not None and record is not None:
        raise UserError("--record: not with --answers: those answers are in a file already")
    ids = (nominal(data) if calibration is None else load_calibration(calibration, data)).ids
    person: Person = AtTerminal(record)
    if answers is not None:
        person = FromFile(read_answers(answers), str(answers), not sim)
    keep = (Path("out/servos") if sim else default_path(data).parent) / f"{data.name}.servos.unfinished"
    with redirect_stdout(sys.stderr) if as_json else nullcontext(), _servos(data, port, sim) as (link, plug):
        steps = Setup(data, link, person, ids, rate, keep if joint is None else None, plug)
        done = steps.run([JOINT_LABELS.index(label) for label in chosen])
        name = link.port.port_name
    _show(data.name, name, done, as_json)
    return 0


@contextmanager
def _servos(robot: "Robot", port: str | None, sim: bool) -> Iterator[tuple["Link", Callable[[int], None] | None]]:
    """Yield an open link to the plugged-in servo, and for emulated servos a function that plugs the next one in."""
    from ..bus.dynamixel.link import open_link
    from ..bus.dynamixel.port import latency_warning

    if sim:
        from ..sim.servos.tray import Tray

        tray = Tray(robot)
        yield tray.link, tray.plug
        return
    with open_link(robot, port) as link:
        if warning := latency_warning(link.port.port_name):
            write_error(f"warning: {warning}")
        yield link, None


def _show(robot: str, port: str, done: "dict[int, Done]", as_json: bool) -> None:
    from ..bus.base import JOINT_LABELS

    rows = [{"joint": JOINT_LABELS[joint], **asdict(one)} for joint, one in sorted(done.items())]
    if as_json:
        write_json({"robot": robot, "port": port, "servos": rows})
    else:
        print_table(("joint", "id", "baud", "firmware", "was id", "at baud", "settings written"),
                    [tuple(row.values()) for row in rows])
