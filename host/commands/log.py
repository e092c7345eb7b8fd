"""`caramelo log`: summarises records, draws them, exports them as CSV, replays them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, progress, say, screen, tell_written, write_error, write_json, write_note
from ..util.errors import NOT_ACHIEVED, UserError
from ..util.files import check_folder
from ._options import Json

if TYPE_CHECKING:
    from ..records.reader import Fields, Record

File = Annotated[Path, typer.Argument(metavar="FILE", help="A record, or a folder (its newest record).")]

GROUP = typer.Typer(help="Look at records of drives, and replay them.", no_args_is_help=True)


@GROUP.command()
def info(file: File, as_json: Json = False) -> None:
    """Show what a record holds: robot, duration, messages, states, faults, timing.

    Example: caramelo log info walk.mcap
    """
    record = _read(file, FACTS)
    facts = record_facts(record)
    if as_json:
        write_json(facts)
    else:
        _show(facts)
    _say_what_is_missing(record)


# The fields that record_facts needs, for read_record.
FACTS = {"/state": ("state", "reason"), "/fault": ("sentence",), "/timing": ("missed",)}


def _read(file: Path, wanted: "Fields") -> "Record":
    """Read these fields of a record and return it; a bar shows the progress."""
    from ..records.reader import find_record, read_record

    path = find_record(file)
    size = path.stat().st_size if path.exists() else 0
    with progress(f"reading {path.name}", size) as show:
        return read_record(path, wanted, show)


def _say_what_is_missing(record: "Record") -> None:
    """Say behind a command's result if it is not of the whole record."""
    if not record.whole:
        write_error(f"{record.path}: cut off or damaged after {record.duration_s:.1f} s: read up to there")


def record_facts(record: "Record") -> dict[str, Any]:
    """Return a record's summary as plain values."""
    timing = record.of("/timing")
    return {
        "file": str(record.path),
        "robot": record.about.get("robot", ""),
        "core": record.about.get("core", ""),
        "duration_s": round(record.duration_s, 3),
        "whole": record.whole,
        "messages": dict(record.counts),
        "missed": timing[-1].values["missed"] if timing else 0,
        "states": [
            {"time_s": round(time_s, 3), **row.values}
            for time_s, row in zip(record.times_s("/state"), record.of("/state"), strict=True)
        ],
        "faults": [row.values["sentence"] for row in record.of("/fault")],
    }


def _show(facts: dict[str, Any]) -> None:
    console = screen()
    missed = f", {facts['missed']} missed deadlines" if "/timing" in facts["messages"] else ""
    console.print(f"{facts['robot'] or facts['file']}: {facts['duration_s']:.1f} s{missed}", soft_wrap=True)
    print_table(("channel", "messages"), facts["messages"].items())
    for change in facts["states"]:
        console.print(f"{change['time_s']:8.2f} s  {change['state']:<12} {change['reason']}")
    for fault in facts["faults"]:
        console.print(f"fault: {fault}")


@GROUP.command()
def plot(
    file: File, out: Annotated[Path | None, typer.Option(metavar="PNG", help="Default: beside the record.")] = None
) -> None:
    """Draw joints, loads, attitude, health and timing into a PNG file.

    Examples: caramelo log plot walk.mcap --out walk.png; caramelo log plot logs/
    """
    from ..records.plot import FIELDS, plot_png

    if out is not None and out.suffix != ".png":
        raise UserError(f"--out {out}: give a name that ends in .png")
    record = _read(file, FIELDS)
    target = out or record.path.with_suffix(".png")
    if target.resolve() == record.path.resolve():
        raise UserError(f"{target}: is the record itself; name the picture with --out")
    write_note("drawing")
    plot_png(record, target)
    tell_written([target])
    _say_what_is_missing(record)


@GROUP.command()
def export(
    what: Annotated[str, typer.Argument(metavar="csv", help="The format: csv.")],
    file: Annotated[Path | None, typer.Argument(metavar="FILE", help="A record, or a folder (its newest).")] = None,
    out: Annotated[Path | None, typer.Option(metavar="DIR", help="Default: a folder beside the record.")] = None,
) -> None:
    """Write one CSV file per channel.

    Example: caramelo log export csv walk.mcap --out walk-csv
    """
    from ..records.export import export_csv

    if what != "csv" or file is None:
        wrong = "names no record" if what == "csv" else f"{what} is not a format"
        raise UserError(f"log export: {wrong}: use caramelo log export csv FILE, such as "
                        f"caramelo log export csv {what if what != 'csv' and file is None else 'walk.mcap'}")
    check_folder("--out", out)
    record = _read(file, {})
    with progress(f"writing {record.counts.total()} rows", record.path.stat().st_size) as show:
        written = export_csv(record, out or record.path.with_suffix(""), show)
    tell_written(written)
    _say_what_is_missing(record)


@GROUP.command()
def replay(file: File, as_json: Json = False) -> int:
    """Feed the recorded inputs to the planner again; the joint targets must come out the same to the bit.

    Exit code 1 at the first difference. Example: caramelo log replay walk.mcap
    """
    from ..records.replay import FIELDS
    from ..records.replay import replay as again

    record = _read(file, FIELDS)
    with progress("replaying", len(record.of("/planner"))) as show:
        result = again(record, show)
    facts = {"ok": result.ok, "ticks": result.ticks, "difference": result.difference, "same_core": result.same_core,
             "whole": record.whole}
    if as_json:
        write_json(facts)
    else:
        core = "" if result.same_core else " (recorded with another version of the core)"
        say(f"{result.ticks} ticks are the same to the bit{core}" + (f"; {result.difference}" * (not result.ok)))
    _say_what_is_missing(record)
    return 0 if result.ok else NOT_ACHIEVED
