"""`caramelo joints compare`: compares position loops in the joint with loops on the host, in the simulator."""

from typing import Annotated

import typer

from ...util.console import print_table, screen, write_json
from ...util.errors import NOT_ACHIEVED
from .options import Json, RobotName

# Key of a row: its heading and its form
COLUMNS = {
    "loops": ("loops", "{}"),
    "rate_hz": ("Hz", "{}"),
    "buses": ("buses", "{}"),
    "speed_m_s": ("m/s", "{:.3f}"),
    "error_rms_deg": ("error deg", "{:.2f}"),
    "error_worst_deg": ("worst", "{:.1f}"),
    "lag_ms": ("lag ms", "{}"),
    "error_after_lag_deg": ("left deg", "{:.2f}"),
    "lowest_body_m": ("body m", "{:.3f}"),
}


def compare(
    robot: RobotName = "parallel",
    seconds: Annotated[float, typer.Option(min=1.0, max=60.0, help="Simulated time that each walks.")] = 3.0,
    as_json: Json = False,
) -> int:
    """Walk at 0.05 m/s with the position loops in the joint, and on the host in velocity and in current mode.

    "error" is set-point minus angle of all twelve motors, rms and worst; "lag" the shift in time that makes it least,
    and "left" the error that then remains; "body" is the body's least height. Exit code 1 if the robot did not walk
    with one of the loops.

    Example: caramelo joints compare --seconds 3
    """
    from ...lab.joints.compare import CASES
    from ...lab.joints.compare import compare as compared
    from ...robot.file import load_can_robot

    data, _ = load_can_robot(robot)
    rows = [compared(data, *case, seconds).as_dict() for case in CASES]
    if as_json:
        write_json({"seconds": seconds, "walks": rows})
    else:
        head = tuple(heading for heading, _ in COLUMNS.values())
        print_table(head, [tuple(form.format(row[key]) for key, (_, form) in COLUMNS.items()) for row in rows])
        for row in rows:
            if row["stopped"]:
                screen().print(f"{row['loops']}, {row['rate_hz']} Hz: {row['stopped']}", soft_wrap=True)
    return NOT_ACHIEVED if any(row["stopped"] for row in rows) else 0
