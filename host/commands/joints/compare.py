"""`caramelo joints compare`: position loops in the joint beside loops on the host, in the simulator."""

from typing import Annotated, Any

import typer

from ...console import screen, write_json
from ...errors import NOT_ACHIEVED, UserError
from .options import Json, RobotName, print_table

COLUMNS = {
    "loops": "{}",
    "rate_hz": "{} Hz",
    "buses": "{}",
    "speed_m_s": "{:.3f} m/s",
    "error_rms_deg": "{:.2f} deg",
    "error_worst_deg": "{:.1f} deg",
    "lag_ms": "{} ms",
    "error_after_lag_deg": "{:.2f} deg",
    "lowest_body_m": "{:.3f} m",
}
HEAD = ("loops", "cycle", "buses", "speed", "error rms", "worst", "lag", "error left", "body, lowest")


def compare(
    robot: RobotName = "parallel",
    seconds: Annotated[float, typer.Option(min=1.0, max=60.0, help="How long each walks, simulated time.")] = 3.0,
    as_json: Json = False,
) -> int:
    """Walk at 0.05 m/s with the position loops in the joint, and on the host in velocity and in current mode.

    Error is set-point minus angle of all twelve motors; lag is the shift in time that makes it least, error left what
    remains then. Exit code 1 if the robot did not walk with one of them.

    Example: caramelo joints compare --seconds 3
    """
    from ...joints.compare import CASES
    from ...joints.compare import compare as compared
    from ...robot_file import load_robot

    data = load_robot(robot)
    if data.bus.kind != "can":
        raise UserError(f"{data.name} has no joints on CAN; try --robot parallel")
    rows: list[dict[str, Any]] = []
    for case in CASES:
        rows.append(compared(data, *case, seconds).as_dict())
    if as_json:
        write_json({"seconds": seconds, "walks": rows})
    else:
        print_table(HEAD, [tuple(form.format(row[key]) for key, form in COLUMNS.items()) for row in rows])
        for row in rows:
            if row["stopped"]:
                screen().print(f"{row['loops']}, {row['rate_hz']} Hz: {row['stopped']}", soft_wrap=True)
    return NOT_ACHIEVED if any(row["stopped"] for row in rows) else 0
