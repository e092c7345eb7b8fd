"""`caramelo joints figures|compare`: the figures of the bus, and loops in the joint beside those on the host."""

from collections.abc import Callable
from dataclasses import asdict
from functools import partial
from typing import Annotated, Any

import typer

from ...util.console import print_table, progress, screen, write_json
from ...util.errors import NOT_ACHIEVED
from ...util.extras import not_installed
from ...util.progress import cases
from .options import Json, RobotName

# Key of a row: its heading and its form
COLUMNS = {
    "loops": ("loops", "{}"),
    "rate_hz": ("Hz", "{}"),
    "buses": ("buses", "{}"),
    "walked_s": ("s", "{:.1f}"),
    "speed_m_s": ("m/s", "{:.3f}"),
    "error_rms_deg": ("error deg", "{:.2f}"),
    "error_worst_deg": ("worst", "{:.1f}"),
    "lag_ms": ("lag ms", "{}"),
    "error_after_lag_deg": ("left deg", "{:.2f}"),
    "lowest_body_m": ("body m", "{:.3f}"),
}
WIDTH = 90  # of the table


def figures(
    robot: RobotName = "parallel",
    messages: Annotated[
        int, typer.Option(min=1, max=1_000_000, help="Random frames of each type to compare with cantools.")
    ] = 1000,
    distance: Annotated[float, typer.Option(min=0.3, max=5.0, help="Metres walked over CAN and directly.")] = 0.5,
    as_json: Json = False,
) -> int:
    """Print the figures of the bus: codec, load, time of a cycle, speed. Exit code 1 if the bus misses one.

    The bar is set for 100 000 frames of each type and 1.5 m, which takes minutes.

    Example: caramelo joints figures --messages 100000 --distance 1.5
    """
    from ...lab.joints import figures as found
    from ...robot.file import load_can_robot

    data, _ = load_can_robot(robot)
    steps: dict[str, Callable[[], list[found.Figure]]] = {
        "codec": lambda: [found.codec_figure(messages)],
        "load": lambda: found.load_figures(data),
        "cycle": lambda: found.cycle_figures(data),
        "speed": lambda: [found.speed_figure(data, distance)],
    }
    missing = not_installed("cantools")
    note = f"the codec was not compared: {missing}" if missing else ""
    if missing:
        del steps["codec"]
    rows: list[found.Figure] = []
    with cases("figures") as tell:
        for number, (name, figures_of) in enumerate(steps.items(), 1):
            tell(number, len(steps), name)
            rows += figures_of()
    if as_json:
        write_json({"figures": [asdict(row) for row in rows], "note": note})
    else:
        head = ("figure", "wanted", "found", "reached")
        print_table(head, [(row.what, row.wanted, row.found, "yes" if row.reached else "NO") for row in rows])
        if note:
            screen().print(note, soft_wrap=True)
    return 0 if all(row.reached for row in rows) else NOT_ACHIEVED


def compare(
    robot: RobotName = "parallel",
    seconds: Annotated[float, typer.Option(min=1.0, max=60.0, help="Simulated time that each walks.")] = 3.0,
    as_json: Json = False,
) -> int:
    """Walk at 0.05 m/s with the position loops in the joint, and on the host in velocity and in current mode.

    "error" is set-point minus angle of all twelve motors, rms and worst; "lag" the shift in time that makes it least,
    and "left" the error that then remains; "body" is the body's least height; "s" is how long the robot walked. If it
    is stopped, its walk ends there, and the command with exit code 1.

    Example: caramelo joints compare --seconds 3
    """
    from ...lab.joints.compare import CASES
    from ...lab.joints.compare import compare as compared
    from ...robot.file import load_can_robot

    data, _ = load_can_robot(robot)
    rows: list[dict[str, Any]] = []
    with progress("walks", seconds * len(CASES)) as show:
        for case in CASES:
            before_s = seconds * len(rows)
            rows.append(compared(data, *case, seconds, partial(_show, show, before_s)).as_dict())
    if as_json:
        write_json({"seconds": seconds, "walks": rows})
    else:
        head = tuple(heading for heading, _ in COLUMNS.values())
        print_table(head, [tuple(_cell(row[key], form) for key, (_, form) in COLUMNS.items()) for row in rows], WIDTH)
        for row in rows:
            if row["stopped"]:
                name = f"{row['loops']}, {row['rate_hz']} Hz"
                screen().print(f"{name}: stopped after {row['walked_s']:.1f} s: {row['stopped']}", soft_wrap=True)
    return NOT_ACHIEVED if any(row["stopped"] for row in rows) else 0


def _show(show: Callable[[float], None], before_s: float, walked_s: float) -> None:
    show(before_s + walked_s)


def _cell(value: Any, form: str) -> str:
    return "-" if value is None else form.format(value)
