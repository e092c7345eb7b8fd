"""`caramelo joints figures`: the figures that the joints' bus must reach, and those that it reaches here."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Annotated

import typer

from ...util.console import print_table, screen, write_json
from ...util.errors import NOT_ACHIEVED
from ...util.extras import not_installed
from ...util.progress import cases
from .options import Json, RobotName


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
