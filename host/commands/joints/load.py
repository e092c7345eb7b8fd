"""`caramelo joints busload`: how much of the bus the schedule takes."""

from typing import Annotated

import typer

from ...console import write_json
from ...errors import NOT_ACHIEVED, UserError
from .options import Json, RobotName, print_table


def busload(
    robot: RobotName = "parallel",
    rate: Annotated[float | None, typer.Option(min=20, max=1000, help="Hz; without it the robot file's.")] = None,
    buses: Annotated[int, typer.Option(min=1, max=2, help="Two buses: front legs on one, rear legs on the other.")] = 1,
    as_json: Json = False,
) -> int:
    """Print how much of the bus the configured schedule takes, worst and typical. Exit code 1 above 70 %.

    Example: caramelo joints busload --rate 400 --buses 2
    """
    from ...busload import busload as busload_of
    from ...busload import default_schedule
    from ...joints.host_loops import KINDS
    from ...robot_file import load_robot

    data = load_robot(robot)
    if data.bus.kind != "can":
        raise UserError(f"{data.name} has no CAN bus; try --robot parallel")
    kinds = (KINDS[data.bus.loops],)
    nodes = tuple(range(1, 1 + 12 // buses))
    rows = busload_of(default_schedule(rate or data.bus.rate_hz, nodes, kinds), data.bus.bitrate)
    if as_json:
        write_json({"buses": buses, "rows": [vars(row) for row in rows]})
    else:
        cells = [
            (
                r.name,
                r.length or "",
                f"{r.frames_per_s:.0f}",
                f"{100 * r.worst_share:.2f}",
                f"{100 * r.typical_share:.2f}",
            )
            for r in rows
        ]
        print_table(("frame", "bytes", "frames/s", "worst %", "typical %"), cells)
    return 0 if rows[-1].worst_share <= 0.7 else NOT_ACHIEVED
