"""`caramelo joints scan|status|monitor`: shows what is on the bus, and what every joint reports."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, TextIO

import typer

from ...util.console import live_table, print_table, screen, write_json
from ...util.errors import NOT_ACHIEVED, UserError
from ...util.files import not_written, writing
from .options import Channel, Interface, Json, RobotName, Seconds, Sim, joints
from .table import Curves, rows_of, table


def scan(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """List the boards on the bus, and what prevents arming the robot. Exit code 1 if anything does.

    Example: caramelo joints scan --sim
    """
    with joints(robot, interface, channel, sim) as bus:
        boards = bus.requests.discover()
        wrong = bus.cycle.guard.before_arming(boards)
        trouble = bus.port.trouble
    rows = [(node, number) for node, numbers in sorted(boards.items()) for number in sorted(numbers)]
    if as_json:
        write_json({
            "boards": [{"node": node, "board": number} for node, number in rows],
            "wrong": [{"node": n.node, "what": n.what, "sentence": n.sentence} for n in wrong],
        })  # fmt: skip
    else:
        from ...bus.can.service import joint_name

        print_table(("joint", "board"), [(joint_name(node), f"{number:#010x}") for node, number in rows])
        for sentence in [*(notice.sentence for notice in wrong), *filter(None, [trouble])]:
            screen().print(sentence, soft_wrap=True)
    return NOT_ACHIEVED if wrong else 0


def status(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, sim: Sim = False,
    as_json: Json = False,
) -> int:  # fmt: skip
    """Show every joint's state, limits, lost frames, and its fault in words. Exit code 1 if one is missing or in fault.

    Example: caramelo joints status --interface udp_multicast --channel default
    """
    with joints(robot, interface, channel, sim) as bus:
        rows, counters = rows_of(bus), bus.port.counters.as_dict()
        trouble = bus.port.trouble
    if as_json:
        write_json({"joints": rows, "port": counters, "trouble": trouble})
    else:
        screen().print(table(rows))
        screen().print("frames: {sent} sent, {received} received, {unreadable} unreadable, "
                       "{full} lost to a full send buffer; {bus_off} times bus-off".format(**counters))
        if trouble:
            screen().print(trouble, soft_wrap=True)
    return 0 if all(row["fault"] == "none" for row in rows) else NOT_ACHIEVED


REFRESH_S = 0.1
# What monitor can plot -> key of a row, and the least span that fills a curve
PLOTS = {
    "angle": ("motor_deg", 2.0),
    "current": ("current_A", 0.2),
    "heat": ("winding_C", 2.0),
    "supply": ("bus_V", 0.5),
}


def monitor(
    robot: RobotName = "parallel", interface: Interface = None, channel: Channel = None, seconds: Seconds = None,
    plot: Annotated[str, typer.Option(help="Curve to draw: angle, current, heat or supply.")] = "angle",
    out: Annotated[Path | None, typer.Option(help="Record all reports, one JSON object per line.")] = None,
    sim: Sim = False,
) -> int:  # fmt: skip
    """Watch all joints in a live table with a curve for each. This arms nothing. --out records, line by line.

    Example: caramelo joints monitor --sim --seconds 2 --plot current --out joints.jsonl
    """
    if plot not in PLOTS:
        raise UserError(f"--plot {plot}: allowed {', '.join(PLOTS)}")
    key, span = PLOTS[plot]
    curves = Curves(span)
    with (
        _record(out) as record,
        joints(robot, interface, channel, sim) as bus,
        live_table() as show,
    ):
        began_s = bus.now()
        try:
            while seconds is None or bus.now() - began_s < seconds:
                bus.run_for(REFRESH_S)
                rows = rows_of(bus)
                show(table(rows, plot, [curves.add(row["joint"], row.get(key)) for row in rows]))
                if record is not None and out is not None:
                    with writing(out):
                        record.write(json.dumps({"time_s": round(bus.now() - began_s, 3), "joints": rows}) + "\n")
        except KeyboardInterrupt:
            screen().print("stopped")
    return 0


@contextmanager
def _record(path: Path | None) -> Iterator[TextIO | None]:
    """Yield a new file that is written line by line, so that nothing is lost when this ends; None without a path."""
    if path is None:
        yield None
        return
    try:
        file = path.open("x", buffering=1)
    except FileExistsError:
        raise UserError(f"--out {path}: the file exists: name another") from None
    except OSError as error:
        raise not_written(f"--out {path}", error) from error
    with file:
        yield file
