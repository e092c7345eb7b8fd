"""`caramelo joints busload|dbc`: how much of the bus the schedule takes, and the protocol for other tools."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...util.console import print_table, say, screen, tell_written, write_json
from ...util.errors import NOT_ACHIEVED, UserError
from .options import Json, RobotName

if TYPE_CHECKING:
    from ...bus.can.load import LoadRow

MOST_SHARE = 0.7  # above it a lost frame can't be repeated in the same cycle (chosen)


def busload(
    robot: RobotName = "parallel",
    rate: Annotated[float | None, typer.Option(min=20, max=1000, help="Hz (default: the robot file's).")] = None,
    buses: Annotated[
        int | None, typer.Option(min=1, max=2, help="2: front legs on one, rear legs on the other (default: file's).")
    ] = None,
    as_json: Json = False,
) -> int:
    """Print how much of each bus the configured schedule takes, at worst and typically. Exit code 1 above 70 %.

    Example: caramelo joints busload --rate 400 --buses 2
    """
    from ...bus.can.host_loops import KINDS
    from ...bus.can.load import busload as busload_of
    from ...bus.can.load import default_schedule
    from ...bus.can.pair import bus_of
    from ...robot.file import load_can_robot

    _, own = load_can_robot(robot)
    count, hz = buses or len(own.channels), rate or own.rate_hz
    nodes = [tuple(node for node in range(1, 13) if count == 1 or bus_of(node) == bus) for bus in range(count)]
    loads = [busload_of(default_schedule(hz, part, (KINDS[own.loops],)), own.bitrate) for part in nodes]
    if as_json:
        each = [{"nodes": part, "rows": [vars(row) for row in rows]} for part, rows in zip(nodes, loads, strict=True)]
        write_json({"rate_hz": hz, "buses": each})
    else:
        for part, rows in zip(nodes, loads, strict=True):
            screen().print(f"nodes {part[0]} to {part[-1]}, {hz:g} Hz")
            print_table(("frame", "bytes", "frames/s", "worst %", "typical %"), [_cells(row) for row in rows])
    return 0 if max(rows[-1].worst_share for rows in loads) <= MOST_SHARE else NOT_ACHIEVED


def _cells(row: "LoadRow") -> tuple[str, ...]:
    shares = (f"{100 * row.worst_share:.2f}", f"{100 * row.typical_share:.2f}")
    return row.name, str(row.length or ""), f"{row.frames_per_s:.0f}", *shares


def dbc(
    out: Annotated[Path | None, typer.Option(metavar="FILE", help="Write here instead of to the terminal.")] = None,
    as_json: Json = False,
) -> int:
    """Write the protocol as a DBC file with a message for each identifier, for SavvyCAN, Kvaser's tools and cantools.

    Example: caramelo joints dbc --out joints.dbc
    """
    from ...protocol import dbc as source
    from ...protocol.generate_docs import expanded_dbc
    from ...util.files import write_text

    if as_json and out is None:
        raise UserError("--json: a DBC file is not JSON; name the file with --out FILE")
    text = expanded_dbc(source.load())
    if out is None:
        say(text.removesuffix("\n"))
        return 0
    write_text(out, text)
    if as_json:
        write_json({"file": str(out), "bytes": len(text.encode())})
    else:
        tell_written([out])
    return 0
