"""`caramelo parity`: shows that every Python computes the same numbers from the same source."""

from typing import TYPE_CHECKING, Annotated, Any

import typer

from ..util.console import print_table, screen, write_json
from ..util.errors import NOT_ACHIEVED, UserError
from ._options import Json

if TYPE_CHECKING:
    from ..boards.runtimes import Runtime
    from ..lab.parity.check import Report

EMULATED = "cortex-m-viper"  # slow, so only by its name
Names = Annotated[list[str] | None, typer.Option("--runtime", help="Only this runtime, and CPython; repeatable.")]
Port = Annotated[str | None, typer.Option(help="Serial port of a real board, e.g. /dev/ttyACM0.")]
Vectors = Annotated[int, typer.Option(min=8, help="Vectors per function; 200 also means walks of 5000 ticks.")]
Coverage = Annotated[bool, typer.Option("--coverage", help="Also report which statements ran, in a traced VM.")]
Memory = Annotated[bool, typer.Option("--memory", help="Print each function's largest value and heap instead.")]


def parity(
    runtime: Names = None,
    port: Port = None,
    vectors: Vectors = 200,
    coverage: Coverage = False,
    memory: Memory = False,
    as_json: Json = False,
) -> int:
    """Run the same vectors in CPython and in every MicroPython here, and compare the results by their digests.

    The vectors cover every public function of shared/ over its range, and walks in every gait. If a
    runtime differs, the command prints the first vector that differs, and the exit code is 1.

    The runtime cortex-m-viper, an emulated Cortex-M4 with the board's own machine code, takes minutes and runs only
    when you name it.

    Examples: caramelo parity; caramelo parity --runtime wasi-source; caramelo parity --port /dev/ttyACM0
    """
    import tempfile
    from pathlib import Path

    from ..lab.parity.check import examine, failures
    from ..lab.parity.coverage import cover
    from ..lab.parity.sources import gather
    from ..util.progress import cases

    if memory:
        if runtime or port or coverage:
            raise UserError("parity --memory: goes without --runtime, --port and --coverage")
        return show_memory(as_json)
    chosen = choose(runtime, port)
    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder, cases("parity") as tell:
        work = Path(folder)
        sources = gather(work)
        names = [runtime.name for runtime in chosen]
        steps = len(names) + coverage
        reports = examine(chosen, sources, work, vectors, lambda name: tell(names.index(name) + 1, steps, name))
        if coverage:
            tell(steps, steps, "coverage")
        covered = cover(sources, work / "coverage") if coverage else None
    broken = list(failures(reports))
    if as_json:
        write_json(_summary(reports, broken, covered))
    else:
        _print(reports, broken, covered)
    return NOT_ACHIEVED if broken or (covered is not None and not covered.enough) else 0


def show_memory(as_json: bool) -> int:
    """Print each function's largest intermediate value and how much heap it takes; return 1 if any keeps a byte."""
    import tempfile
    from dataclasses import asdict
    from pathlib import Path

    from ..lab.parity.sources import gather
    from ..lab.parity.table import measure_rows
    from ..util.progress import cases

    with tempfile.TemporaryDirectory(prefix="caramelo-") as folder, cases("memory") as tell:
        tell(1, 1, "every function in two VMs")
        rows = measure_rows(gather(Path(folder)), Path(folder))
    if as_json:
        write_json({"functions": [asdict(row) for row in rows]})
    else:
        print_table(("function", "bits", "frame in bytecode", "kept", "as viper"),
                    [(row.name, row.bits, row.frame, row.kept, row.viper) for row in rows])
    return NOT_ACHIEVED if any(row.kept or row.viper for row in rows) else 0


def choose(names: list[str] | None, port: str | None) -> "list[Runtime]":
    """Return the wanted runtimes, CPython first; UserError for an unknown name or a port that is none."""
    from ..boards.flash.link import check_port
    from ..boards.runtimes import all_runtimes

    if port is not None:
        check_port(port)
    runtimes = all_runtimes(port, emulated=EMULATED in (names or []))
    known = [runtime.name for runtime in runtimes]
    for name in names or []:
        if name not in known:
            raise UserError(f"--runtime {name}: allowed {', '.join(known)}")
    return [r for r in runtimes if not names or r.name in names or r.name in ("cpython", "board")]


def _summary(reports: "list[Report]", broken: list[str], covered: Any) -> dict[str, Any]:
    rows = [
        {
            "name": report.runtime.name,
            "version": report.version,
            "word_bits": report.word_bits,
            "emitter": report.runtime.emitter,
            "digest": report.digest if report.digests else None,
            "seconds": round(report.seconds, 3),
            "skipped": report.skipped,
        }
        for report in reports
    ]
    summary = {"vectors": reports[0].vectors, "identical": not broken, "runtimes": rows, "differences": broken}
    return summary if covered is None else {**summary, "coverage": covered.summary()}


def _print(reports: "list[Report]", broken: list[str], covered: Any) -> None:
    rows: list[tuple[object, ...]] = []
    for report in reports:
        about = (report.version, report.word_bits, report.runtime.emitter, report.vectors, report.digest)
        if report.skipped:
            rows.append((report.runtime.name, "", "", report.runtime.emitter, "", "", "", f"skipped: {report.skipped}"))
        else:
            rows.append((report.runtime.name, *about, f"{report.seconds:.1f}", _verdict(report, reports[0])))
    print_table(("runtime", "version", "bits", "emitter", "vectors", "digest", "s", ""), rows, 130)
    console = screen()
    for sentence in broken:
        console.print(sentence, soft_wrap=True)
    if covered is not None:
        console.print(covered.sentence(), soft_wrap=True)


def _verdict(report: "Report", reference: "Report") -> str:
    if report.failure:
        return "failed"
    if report is reference:
        return "reference"
    return "differs" if report.difference else "equal"
